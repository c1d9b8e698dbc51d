"""The controllers of the examples hold the compressor, keep their margins, and are the same in another tool."""

import math
import tomllib

import control
import numpy as np
import pytest

import amb_cosim
from amb_assessment.first_design import files
from amb_assessment.first_design.files import new_machine
from amb_assessment.first_design.rotor_text import plain_shaft
from amb_cosim import studies
from tests.support.any_gains import any_gains

NAMES = ("lead with two sections", "cross-feedback", "LQG", "H-infinity")

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def compare(examples):
    import compare

    return compare


@pytest.fixture(scope="module")
def margins_and_runs(compare):
    return {name: compare.compared(controller) for name, controller in compare.controllers().items()}


@pytest.mark.parametrize("name", NAMES)
def test_examples_levitate_the_compressor_through_an_unbalance_step(margins_and_runs, name):
    run = margins_and_runs[name][1]
    assert run.outcome.failure is None
    assert run.summary.recovery == "prevented"
    assert run.summary.first_contact is None


def test_the_page_of_the_examples_states_what_they_print(compare, margins_and_runs):
    page = (compare.HERE / "README.md").read_text(encoding="utf-8")
    printed = [f"{name}: {compare.summary(*found)}" for name, found in margins_and_runs.items()]
    assert [line for line in printed if line not in page] == []


@pytest.mark.parametrize("name", NAMES)
def test_examples_are_in_zone_a_computed_and_measured(margins_and_runs, name):
    margins = margins_and_runs[name][0]
    for axis in margins.axes.values():
        assert axis.zone == "A"
        assert axis.largest_difference < 1e-3
    assert all(disk.least > 0.4 for disk in margins.disk_margins.values())


def test_designed_controllers_have_larger_disk_margins_than_the_pid(margins_and_runs):
    least = {name: margins.disk_margins["currents"].least for name, (margins, _) in margins_and_runs.items()}
    assert least["lead with two sections"] > 1.6 * least["PID"]
    assert least["LQG"] > 1.6 * least["PID"]
    assert least["H-infinity"] > 1.3 * least["PID"]


def test_h_infinity_law_attains_its_stated_norm(compare):
    """The largest singular value of the sampled loop with its weights over frequency: no more, and not much less."""
    from h_infinity import GAIN, READINGS, SUBOPTIMAL, W_S, W_U, h_infinity
    from lqg import design_model

    controller, norm = h_infinity()
    plant = design_model()
    T = controller.sample_time
    plant = control.sample_system(plant, T, "zoh")
    (law,) = controller.laws.values()
    largest = 0.0
    for omega in 2.0 * np.pi * np.geomspace(0.5, 4999.0, 4000):
        z, eye = np.exp(1j * omega * T), np.eye(4)
        W_s, W_u = (weight(2.0 / T * (z - 1.0) / (z + 1.0)) for weight in (W_S, W_U))
        G, K = (s.C @ np.linalg.solve(z * np.eye(len(s.A)) - s.A, s.B) + s.D for s in (plant, law))
        G, K = GAIN * G, K / GAIN
        S = np.linalg.solve(eye - G @ K, np.hstack([READINGS * eye, G]))
        largest = max(largest, np.linalg.norm(np.vstack([W_s * S, W_u * K @ S]), 2))
    assert norm / SUBOPTIMAL < largest < norm * (1.0 + 1e-6)


def test_cross_feedback_reduces_the_gyroscopic_splitting(compare):
    """Forward and backward tilting near 54 Hz, whose damping ratio is 0.69; at rest nothing is coupled."""

    def tilting(controller):
        result = studies.poles("compressor_levitated", controller=controller, up_to="9000 rpm", count=4)
        pair = [pole for pole in result.poles if pole.damping_ratios[0] > 0.6]
        assert len(pair) == 2
        return [abs(pair[0].frequencies[k] - pair[1].frequencies[k]) / (2.0 * np.pi) for k in (0, -1)]

    bare, coupled = tilting(None), tilting(compare.controllers()["cross-feedback"])
    assert bare[1] > 3.0  # Hz
    assert coupled[1] < 0.1
    assert max(bare[0], coupled[0]) < 0.01


def test_search_writes_the_law_that_it_judged(examples, tmp_path):
    """The cost of an unstable loop is above `UNSTABLE`; the law of the file has the searched poles and zeros."""
    import search
    from scipy.signal import bilinear

    machine = search.Search("compressor_levitated", ["9000 rpm"], {"mb1": "at_mb1", "mb2": "at_mb2"}, None)
    coefficients, cost = machine.best(1)
    file = tmp_path / "found.toml"
    file.write_text(machine.text(coefficients), encoding="utf-8")
    (law,) = amb_cosim.linear_controller(file).laws.values()
    z = machine.z[::40]
    response = np.array([law.C @ np.linalg.solve(w * np.eye(len(law.A)) - law.A, law.B) + law.D for w in z])
    for k, of in enumerate(coefficients):
        top, bottom = bilinear(*search._ratio(*of), 1.0 / machine.step)
        np.testing.assert_allclose(response[:, 2 * k, 2 * k], np.polyval(top, z) / np.polyval(bottom, z), rtol=1e-3)
    loop = studies.poles("compressor_levitated", controller=file, up_to="9000 rpm")
    assert (cost > search.UNSTABLE) == bool(loop.unstable)


def test_search_levitates_a_machine_on_five_axes(examples, tmp_path, monkeypatch):
    """It writes beside the scenario, with the axial channel and the current limits of `amb-cosim new`."""
    import search

    monkeypatch.setattr(files, "first_design", any_gains)
    made, cwd = tmp_path / "fan", tmp_path / "elsewhere"
    cwd.mkdir()
    new_machine(made, plain_shaft("fan", 12.0, 0.4, 1000.0), 1000.0, tilt=0.5 * math.pi, thrust_disc=True)
    monkeypatch.chdir(cwd)
    options = ["--speeds", "1000 rad/s", "--pairs", "left=probe_left,right=probe_right", "--generations", "2"]
    monkeypatch.setattr("sys.argv", ["search.py", str(made / "levitation.toml"), *options])
    search.main()
    assert not any(cwd.iterdir())
    found, own = (tomllib.loads((made / name).read_text()) for name in ("found.toml", "control.toml"))
    assert found["channel"][-1]["to"] == own["channel"][-1]["to"] == "thrust.i_z"
    kp, expected = (float(file["channel"][-1]["blocks"][0]["kp"].split()[0]) for file in (found, own))
    assert kp == pytest.approx(expected, rel=1e-4)
    assert found["limits"] == own["limits"]
    assert not studies.poles(str(made / "levitation.toml"), controller=made / "found.toml", up_to="1000 rad/s").unstable
