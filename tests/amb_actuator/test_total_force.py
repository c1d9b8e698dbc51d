"""The total force of an axis, the pull of the static current included, and the static current for a load."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from running_actuator import F_0

from amb_actuator.force import Coils, force
from amb_actuator.interface import DYNAMIC, LAWS, LINEAR, MEASURED, NONLINEAR
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, operating_constants, static_current_for

AT_REST = Coils(0.0, 0.0, 1.0, 1.0)

laws = pytest.mark.parametrize("law", range(len(LAWS)), ids=LAWS)


def static_load(law):
    return 544.0 / 2.0 * 1.14 if law == MEASURED else F_0


@laws
def test_axis_at_rest_pulls_the_static_load_towards_positive_x(bearing, law):
    """321 N at Table 2.2, half the current stiffness times the static current: 1.14 A at 563 N/A."""
    force = bearing(force_law=law, total_force=1)["mb1.f_x"]
    assert force == pytest.approx(static_load(law), rel=1e-12)
    assert force == pytest.approx(operating_constants(axis_parameters(), law)[1] / 2.0 * 1.14, rel=1e-12)
    assert round(F_0) == 321


@laws
@pytest.mark.parametrize("amplifier", [0, DYNAMIC], ids=["ideal", "dynamic"])
def test_axis_without_power_pulls_nothing_wherever_the_rotor_is(bearing, law, amplifier):
    actuator = bearing(force_law=law, amplifier=amplifier, total_force=1, mb1__x=5e-4, mb1__amplifier_off_x=1.0)
    assert (actuator["mb1.f_x"], actuator["mb1.k_xx"]) == (0.0, 0.0)
    actuator = bearing(force_law=law, amplifier=amplifier, total_force=1, mb1__x=5e-4)
    actuator["mb1.amplifier_off_x"] = 1.0
    actuator.step(0.0, 20.0)  # a hundred time constants of the coil
    assert (actuator["mb1.f_x"], actuator["mb1.k_xx"]) == pytest.approx((0.0, 0.0), abs=1e-30)


@laws
def test_total_and_excess_force_differ_by_the_static_load_in_any_state(bearing, law):
    states = [{"i_x": 2.0, "x": 2e-4}, {"coil_loss_upper_x": 0.4}, {"coil_loss_lower_x": 1.0, "i_x": -1.0}]
    states.append({"amplifier_off_x": 1.0, "x": 3e-4})
    for state in states:
        values = {f"mb1.{name}": value for name, value in state.items()}
        excess = bearing(values, force_law=law)
        total = bearing(values, force_law=law, total_force=1)
        assert total["mb1.f_x"] - excess["mb1.f_x"] == pytest.approx(static_load(law), rel=1e-10)
        assert total["mb1.k_xx"] == excess["mb1.k_xx"]


@given(st.floats(-250.0, 900.0), st.sampled_from([LINEAR, MEASURED, NONLINEAR]), st.floats(3.5, 5.0))
def test_static_current_for_a_load_pulls_that_load(load, law, bias):
    static = static_current_for(load, axis_parameters(bias_current=bias), law)
    p = axis_parameters(bias_current=bias, static_current=static)
    assert force(law, p, 0.0, AT_REST, True)[0] == pytest.approx(load, rel=1e-9, abs=1e-9)


@laws
def test_load_that_the_coils_cannot_carry_is_refused(law):
    with pytest.raises(ValueError, match=r"load = 3000 N .* >= -\d+\.?\d* N .* <= \d+\.?\d* N"):
        static_current_for(3000.0, axis_parameters(), law)
