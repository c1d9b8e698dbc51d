"""The default test force of an identification suits the magnets of any machine, and is the thesis's on its rig."""

import pytest

from amb_analysis.studies.receptance_measurement import force_amplitude, prepare_identification
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linear_constants
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from tests.support.messages import raises_naming

SCALE = "identification.force_scale"


def scale_of(scenario, **settings):
    """Return the scale that a plan sets; None if it leaves the start value, 1."""
    return prepare_run(load_scenario(scenario), settings).parameters["rolac_controller"].get(SCALE)


def largest_force(**changes):
    """Return K_i I_b (N) of an axis without static load (2.9)."""
    p = axis_parameters("mb1", "x", static_current=0.0, **changes)
    return linear_constants(p)[1] * float(p.bias_current)


@pytest.mark.parametrize("scenario", ["fig5_6", "fig4_9", "fig6_6", "drop"])
def test_the_rig_has_the_force_of_the_thesis(scenario):
    assert scale_of(scenario) is None


def test_force_is_that_of_the_rig_in_proportion_to_the_magnets():
    """550 N above 30 Hz on the rig; the magnets of the compressor have 2.2 times its K_i I_b."""
    values = prepare_run(load_scenario("compressor_levitated")).parameters["amb_actuator"]
    names = ("turns", "pole_area", "gap", "half_angle", "bias_current", "current_limit")
    own = {name: values[f"mb1.{name}_x"] for name in names if f"mb1.{name}_x" in values}
    share = largest_force(**own) / largest_force()
    assert share > 1.5
    assert scale_of("compressor_levitated") == pytest.approx(share, rel=1e-9)
    machine = prepare_identification(150.0 * 6.2832, machine=load_scenario("compressor_levitated"))
    assert force_amplitude(machine) == pytest.approx(550.0 * share, rel=1e-9)


def test_the_weakest_axis_decides():
    """Force is as the square of the turns, 20 of 48."""
    small = {"amb_actuator.mb2.turns_y": 20.0}
    before = scale_of("compressor_levitated")
    assert scale_of("compressor_levitated", **small) == pytest.approx(before * (20.0 / 48.0) ** 2, rel=1e-9)


def test_measured_magnets_scale_by_their_current_stiffness():
    """K_i of 544 N/A are the start values of the rig."""
    k_i = {"amb_actuator.mb1.k_i_measured_x": 54.4}
    assert scale_of("fig5_6", **k_i) == pytest.approx(0.1, rel=1e-9)


def test_a_stated_scale_is_kept():
    stated = {f"rolac_controller.{SCALE}": 0.5}
    assert scale_of("compressor_levitated", **stated) == 0.5


def test_a_small_magnet_has_its_own_current_stiffness_in_the_controller():
    """K_i = 0.5 N/A of each axis, 1/1000 of the rig's, which the controller took for its start value of 563 N/A."""
    small = {"amb_actuator.force_law": "measured", "amb_actuator.*.k_i_measured_?": "0.5 N/A"}
    own = prepare_run(load_scenario("fig4_9"), small).parameters["rolac_controller"]
    assert {own[f"{bearing}.k_i_{axis}"] for bearing in ("mb1", "mb2") for axis in "xy"} == {0.5}


def test_a_current_stiffness_that_the_controller_does_not_allow_is_refused():
    """A force against the current; with a constant that the user states for the controller, the run is allowed."""
    reversed_magnets = {"amb_actuator.force_law": "measured", "amb_actuator.*.k_i_measured_?": -5.0}
    with raises_naming(ValueError, "rolac_controller.mb1.k_i_x", "-5 N/A", ">= 1e-06 N/A"):
        prepare_run(load_scenario("fig4_9"), reversed_magnets)
    stated = reversed_magnets | {"rolac_controller.*.k_i_?": 5.0}
    assert prepare_run(load_scenario("fig4_9"), stated).parameters["rolac_controller"]["mb1.k_i_x"] == 5.0
