"""The actuator as a model: signs, limits, independence of its axes, faults."""

import json
from pathlib import Path

import numpy as np
import pytest

from amb_actuator.actuator import AXES, MEASURED, MODEL
from fmi_export.model import Fault, Instance

THESIS = json.loads((Path(__file__).parents[1] / "reference" / "thesis.json").read_text())["amb"]
H = 250e-6
NAMES = [v.name for v in MODEL.interface.variables]

axes = pytest.mark.parametrize(("bearing", "axis"), AXES, ids=[f"{b}-{a}" for b, a in AXES])


@pytest.fixture
def actuator():
    made = Instance(MODEL, np.zeros(1))
    made.initialise()
    return made


def after_step(actuator, **inputs):
    for name, value in inputs.items():
        actuator[name.replace("__", ".")] = value
    actuator.step(0.0, H)
    return actuator


@axes
def test_a_positive_current_pulls_towards_positive_x(actuator, bearing, axis):
    actuator[f"{bearing}.i_{axis}"] = 1.0
    actuator.step(0.0, H)
    assert actuator[f"{bearing}.f_{axis}"] == pytest.approx(563.15, abs=0.005)


@axes
def test_a_displaced_rotor_is_pulled_further_away(actuator, bearing, axis):
    for x in (1e-4, -1e-4):
        actuator[f"{bearing}.{axis}"] = x
        actuator.step(0.0, H)
        assert actuator[f"{bearing}.f_{axis}"] == pytest.approx(2.376956e6 * x, rel=1e-6)
    assert actuator[f"{bearing}.k_{axis}{axis}"] > 0


@axes
def test_an_axis_answers_to_its_own_inputs_alone(actuator, bearing, axis):
    before = actuator.values.copy()
    actuator[f"{bearing}.i_{axis}"] = 7.0
    actuator[f"{bearing}.{axis}"] = 3e-4
    actuator.step(0.0, H)
    changed = {name for name, old, new in zip(NAMES, before, actuator.values, strict=True) if old != new}
    b, a = bearing, axis
    assert changed == {
        *(f"{b}.i_{a}", f"{b}.{a}", f"{b}.f_{a}", f"{b}.{a}_ref"),
        *(f"{b}.i_upper_{a}", f"{b}.i_lower_{a}", f"{b}.clipped_{a}"),
    }


@axes
def test_an_axis_answers_to_its_own_parameters_alone(bearing, axis):
    changed = Instance(MODEL, np.zeros(1))
    plain = Instance(MODEL, np.zeros(1))
    for made in (changed, plain):
        for b, a in AXES:
            made[f"{b}.i_{a}"] = 1.0
    changed[f"{bearing}.turns_{axis}"] = 100.0
    for made in (changed, plain):
        made.initialise()
    differing = {n for n, p, c in zip(NAMES, plain.values, changed.values, strict=True) if p != c}
    assert differing == {f"{bearing}.{v}_{axis}" for v in ("turns", "f")} | {f"{bearing}.k_{axis}{axis}"}


@axes
def test_extrapolating_with_the_gradient_gives_the_force_elsewhere(actuator, bearing, axis):
    b, a = bearing, axis
    actuator[f"{b}.i_{a}"], actuator[f"{b}.{a}"] = 0.8, 2e-4
    actuator.step(0.0, H)
    force, gradient, x_0 = (actuator[f"{b}.{n}"] for n in (f"f_{a}", f"k_{a}{a}", f"{a}_ref"))
    assert x_0 == 2e-4
    actuator[f"{b}.{a}"] = -3e-4
    actuator.step(H, H)
    assert actuator[f"{b}.f_{a}"] == pytest.approx(force + gradient * (-3e-4 - x_0), rel=1e-14)


@pytest.mark.parametrize(
    ("demand", "upper", "lower", "clipped"),
    [
        (0.0, 5.57, 4.43, 0.0),
        (4.4, 9.97, 0.03, 0.0),
        (4.5, 10.0, 0.0, 1.0),
        (100.0, 10.0, 0.0, 1.0),
        (-5.5, 0.07, 9.93, 0.0),
        (-5.6, 0.0, 10.0, 1.0),
        (-100.0, 0.0, 10.0, 1.0),
    ],
)
def test_coil_currents_stay_between_zero_and_ten_ampere(actuator, demand, upper, lower, clipped):
    after_step(actuator, mb1__i_x=demand)
    assert actuator["mb1.i_upper_x"] == pytest.approx(upper, abs=1e-12)
    assert actuator["mb1.i_lower_x"] == pytest.approx(lower, abs=1e-12)
    assert actuator["mb1.clipped_x"] == clipped


def test_the_force_of_a_cut_demand_is_that_of_the_limit(actuator):
    at_limit = after_step(actuator, mb2__i_y=4.43)["mb2.f_y"]
    assert after_step(actuator, mb2__i_y=50.0)["mb2.f_y"] == pytest.approx(at_limit, rel=1e-12)


@pytest.mark.parametrize("bearing", ["mb1", "mb2"])
def test_the_measured_constants_are_those_of_figure_2_5(bearing):
    made = Instance(MODEL, np.zeros(1))
    made["force_law"] = MEASURED
    made[f"{bearing}.i_x"] = 1.0
    made.initialise()
    assert made[f"{bearing}.k_xx"] == THESIS["k_s_measured_N_per_m"][bearing]
    assert made[f"{bearing}.f_x"] == THESIS["k_i_measured_N_per_A"][bearing]


@axes
@pytest.mark.parametrize("sign", [1, -1])
def test_a_rotor_beyond_the_air_gap_is_a_fault_that_names_axis_value_and_limit(actuator, bearing, axis, sign):
    actuator[f"{bearing}.{axis}"] = sign * 1.3e-3
    with pytest.raises(Fault) as caught:
        actuator.step(0.0, H)
    name = f"{bearing}.{axis}"
    assert str(caught.value) == (
        f"{name} = {sign * 0.0013:g} m is not allowed; the rotor must stay within the air gap, |{name}| < 0.0012 m"
    )


def test_every_axis_has_its_own_fault_codes():
    codes = set()
    for bearing, axis in AXES:
        for name, value in ((f"{bearing}.{axis}", 1.2e-3), (f"{bearing}.bias_current_{axis}", 9.0)):
            made = Instance(MODEL, np.zeros(1))
            made[name] = value
            with pytest.raises(Fault) as caught:
                made.initialise()
            assert f"{name} = {value:g}" in str(caught.value)
            assert made["fault_code"] == caught.value.code
            codes.add(caught.value.code)
    assert codes == set(MODEL.faults)


def test_a_bias_above_the_coil_limit_is_a_fault_that_gives_both_currents_and_the_limit():
    made = Instance(MODEL, np.zeros(1))
    made["mb2.bias_current_y"] = 9.0
    with pytest.raises(Fault) as caught:
        made.initialise()
    assert str(caught.value) == (
        "mb2.bias_current_y = 9 A plus mb2.static_current_y = 1.14 A is not allowed; the sum must be <= 10 A"
    )


def test_outputs_do_not_depend_on_what_the_scratch_arrays_held(actuator):
    after_step(actuator, mb1__x=1e-4, mb2__i_y=2.0)
    expected = actuator.outputs.copy()
    actuator.work[:] = np.nan
    actuator._next_outputs[:-1] = np.nan
    actuator.step(H, H)
    np.testing.assert_array_equal(actuator.outputs, expected)


def test_a_step_size_has_no_influence_because_the_bearing_has_no_memory(actuator):
    forces = []
    for n, h in enumerate((1e-6, 250e-6, 1.0)):
        actuator["mb1.i_x"] = 0.7
        actuator.step(float(n), h)
        forces.append(actuator["mb1.f_x"])
    assert len(set(forces)) == 1
