"""ROLAC and its relatives on top of a linear controller: a compressor under lead with two notches."""

import math
from pathlib import Path

import numpy as np
import pytest

import amb_cosim
from amb_cosim import studies
from amb_cosim.model_constants.receptance_file import read_table

EXAMPLES = Path(__file__).parents[2] / "examples" / "controllers"
LEAD = str(EXAMPLES / "lead_notches.toml")
AXES = [f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def layered():
    return amb_cosim.Scenario.load(EXAMPLES / "rolac_on_notches.toml").changed(receptances=None)


@pytest.fixture(scope="module")
def computed(layered, tmp_path_factory):
    """A table of the loop with that controller, from its linear model."""
    path = tmp_path_factory.mktemp("table") / "receptances.toml"
    studies.identify("9000 rpm", scenario=layered, output=path, computed=True, progress=False)
    return path


def synchronous(run, names, cycle):
    """Components of signals over four turns before a cycle, complex."""
    turns, theta = run.signals["cycle"].values, run.signals["rotor_contact.theta"].values
    chosen = (turns > cycle - 4) & (turns <= cycle)
    turn = np.exp(-1j * theta[chosen])
    return np.array([2.0 * np.mean(run.signals[name].values[chosen] * turn) for name in names])


def test_an_inactive_outer_loop_changes_no_bit_of_the_controller(layered):
    both = layered.changed(settle_cycles=2, end_cycle=10)
    alone = amb_cosim.Scenario.load("compressor_levitated").changed(
        fmu={"rolac_controller": LEAD}, settle_cycles=2, end_cycle=10, event=[], inputs=both.inputs
    )
    runs = [amb_cosim.run(scenario, progress=False) for scenario in (both, alone)]
    for axis in AXES:
        np.testing.assert_array_equal(*(run.signals[f"rotor_contact.{axis}"].values for run in runs))


def test_identified_receptance_includes_the_controller(layered, computed, tmp_path):
    """R of the linear model and of a co-simulation agree to 1e-6; with the PID, R differs."""
    path = tmp_path / "identified.toml"
    studies.identify("9000 rpm", scenario=layered, output=path, progress=False)
    (modelled,), (result,) = read_table(computed).entries, read_table(path).entries
    np.testing.assert_allclose(result.receptance, modelled.receptance, atol=1e-6 * np.abs(modelled.receptance).max())
    np.testing.assert_array_equal(result.inner, modelled.inner)
    under_pid = studies.identify("9000 rpm", scenario="compressor_levitated", computed=True, progress=False)
    assert np.abs(under_pid.results[0].receptance / modelled.receptance - 1.0).max() > 0.1


def test_rolac_reaches_the_least_squares_optimum(layered, computed):
    run = amb_cosim.run(layered.changed(receptances=str(computed)), progress=False)
    (entry,) = read_table(computed).entries
    sensors = [f"rotor_contact.{sensor}" for sensor in read_table(computed).sensors]
    before, after = (synchronous(run, sensors, cycle) for cycle in (10, 200))
    best = before - entry.receptance @ np.linalg.lstsq(entry.receptance, before, rcond=None)[0]
    assert run.summary.first_contact is None
    assert np.linalg.norm(best) < 0.85 * np.linalg.norm(before)
    assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(best), rel=1e-5)


def test_force_rejection_removes_the_bearing_forces_at_its_rate(layered, computed):
    scenario = layered.changed(
        receptances=str(computed),
        end_cycle=160,
        parameters={"rolac_controller": {"rolac.mode": "force_free", "rolac.alpha": 1.0}},
        inputs={"rotor_contact": {"impeller3.u": "0.65 g.m"}},
    )
    run = amb_cosim.run(scenario, progress=False)
    forces = [f"amb_actuator.{bearing}.f_{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
    before, after = (np.abs(synchronous(run, forces, cycle)) for cycle in (10, 160))
    np.testing.assert_allclose(after / before, math.exp(-1.0), rtol=0.05)  # after 150 turns of 1/150 s


@pytest.mark.parametrize("change", ["mb1.i_x.gain", "delay", "mb2.y.scale"])
def test_table_of_another_inner_loop_is_refused(layered, computed, change):
    other = layered.changed(receptances=str(computed), parameters={"linear_controller": {change: 0.9}})
    with pytest.raises(ValueError, match=rf"with linear_controller\.{change} = .*, not 0\.9; identify again"):
        amb_cosim.run(other, progress=False)


def test_table_of_other_matrices_is_refused(layered, computed):
    other = layered.changed(receptances=str(computed), fmu={"linear_controller": str(EXAMPLES / "cross_feedback.toml")})
    with pytest.raises(ValueError, match=r"identified with linear_controller\.matrices = .*; identify again"):
        amb_cosim.run(other, progress=False)


def test_error_of_a_missing_controller_names_the_option():
    scenario = amb_cosim.Scenario.load("compressor_levitated").changed(system="levitated_inner_loop")
    with pytest.raises(ValueError, match=r"made from a file; .* fmu\.linear_controller = 'lead\.mat'"):
        amb_cosim.run(scenario, progress=False)


def test_computed_and_measured_sensitivity_is_that_of_the_controller():
    layers = studies.sensitivity(EXAMPLES / "rolac_on_notches.toml")
    alone = studies.sensitivity("compressor_levitated", controller=LEAD)
    for axis, result in layers.axes.items():
        np.testing.assert_allclose(result.computed, alone.axes[axis].computed, rtol=1e-9)
        assert result.largest_difference < 1e-6
