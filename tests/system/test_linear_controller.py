"""A controller of one's own levitates a compressor: as a PID, as a file, from python-control in a few lines."""

import control
import numpy as np
import pytest

import amb_cosim
from amb_analysis.linear.linearisable import linearisable

H = 1e-4
K_S, K_I, K_B, C_B = 1.295e7, 1107.0, 1.3e7, 4e4  # of the scenario compressor_levitated
CLEARANCE = 0.25e-3
AXES = [f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
DEMANDS = [f"{bearing}.i_{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]

pytestmark = pytest.mark.slow


def as_pid(**options):
    """The PID of the scenario as matrices: i = -((K_b + K_s) x + C_b (x - x_before) / h) / K_i, x_before the state."""
    k, c = (K_B + K_S) / K_I, C_B / H / K_I
    eye = np.eye(4)
    law = (0.0 * eye, eye, c * eye, -(k + c) * eye)
    return amb_cosim.linear_controller(law, AXES, DEMANDS, H, sampled_arrays=True, limits=(-6.5, 5.0), **options)


def displacements(result):
    return np.array([result.signals[f"rotor_contact.{axis}"].values for axis in AXES])


@pytest.fixture(scope="module")
def under_pid():
    return amb_cosim.run("compressor_levitated", until=0.1, progress=False)


def test_pid_of_a_rig_written_as_data_gives_its_results_in_contact_too():
    """Sensors, gains and derivative as the linear model has them, over a rub: 1e-14 of the clearance."""
    (part,) = linearisable("fig4_7").parts(["rolac_controller"])
    names = [name.removeprefix("rolac_controller.") for name in (*part.inputs, *part.outputs)]
    read, demanded = ([n for n in names if n.startswith(start)] for start in ("s", "mb1.i_"))
    demanded += [n for n in names if n.startswith("mb2.i_")]
    law = part.selected(*([f"rolac_controller.{n}" for n in some] for some in (read, demanded))).law
    arrays = (law.A, law.B, law.C, law.D)
    local = amb_cosim.linear_controller(arrays, read, demanded, law.sample_time, sampled_arrays=True)
    runs = [amb_cosim.run("fig4_7", fmu=fmu, progress=False) for fmu in (None, {"rolac_controller": local})]
    assert runs[0].summary.first_contact is not None
    clearance = linearisable("fig4_7").parameters("rotor_contact")["rb1.clearance"]
    np.testing.assert_allclose(*map(displacements, runs), rtol=0.0, atol=1e-12 * clearance)


def test_controller_from_python_control_levitates_the_compressor(under_pid):
    s = control.tf("s")
    lead = -(2.34e4 + 36.0 * s / (5e-5 * s + 1.0))
    controller = amb_cosim.linear_controller(control.append(*[control.ss(lead)] * 4), AXES, DEMANDS, H)
    run = amb_cosim.run("compressor_levitated", fmu={"rolac_controller": controller}, until=0.1, progress=False)
    assert run.outcome.failure is None
    assert run.summary.first_contact is None
    assert np.abs(displacements(run)).max() == pytest.approx(np.abs(displacements(under_pid)).max(), rel=0.2)


def test_file_of_arrays_stands_for_an_fmu_in_a_scenario(under_pid, tmp_path):
    as_pid().save(tmp_path / "pid.mat")
    (tmp_path / "own.toml").write_text('base = "compressor_levitated"\nfmu.rolac_controller = "pid.mat"\n')
    run = amb_cosim.run(tmp_path / "own.toml", until=0.02, progress=False)
    both = [displacements(r)[:, : run.signals["time"].values.size] for r in (run, under_pid)]
    np.testing.assert_allclose(*both, rtol=0.0, atol=1e-12 * CLEARANCE)


def test_without_feedback_the_compressor_falls():
    """The sign counts: the same law with the other sign loses the rotor at once."""
    run = amb_cosim.run(
        "compressor_levitated", fmu={"rolac_controller": as_pid(gains=-1.0)}, until=0.02, progress=False
    )
    assert run.summary.first_contact is not None or run.outcome.failure is not None


def test_signal_that_no_component_has_is_named():
    law = amb_cosim.linear_controller(np.eye(4), [*AXES[:3], "elsewhere.x"], DEMANDS, H)
    with pytest.raises(ValueError, match=r"rolac_controller\.elsewhere\.x, a sensor, must be connected, and is not"):
        amb_cosim.run("compressor_levitated", fmu={"rolac_controller": law}, until=0.01, progress=False)
