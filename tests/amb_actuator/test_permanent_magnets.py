"""Bias by permanent magnets: the coils carry the rest of the current, and the magnets still pull without power."""

import math

import pytest

from amb_actuator.flux import MU_0
from amb_actuator.interface import DYNAMIC, LINEAR, MEASURED, NONLINEAR

LAWS = (LINEAR, MEASURED, NONLINEAR)
BIAS, LIMIT, LOAD = 4.43, 10.0, 1.14  # A, as the start values; the last carries the static load
TURNS, AREA, GAP, ANGLE = 158.0, 1399e-6, 1.2e-3, math.radians(22.5)


def axis(bearing, permanent=BIAS, **values):
    """MB1 with this bias (A) of permanent magnets on its x axis."""
    of_axis = {f"mb1.{name}_x": value for name, value in values.items() if name in ("i", "amplifier_off")}
    rest = {name: value for name, value in values.items() if name not in ("i", "amplifier_off")}
    return bearing(values={"mb1.permanent_bias_x": permanent} | of_axis, **rest)


def pulls(upper, lower, x=0.0):
    """(2.6) of the currents (A) of both pairs, permanent magnets included."""
    scale = MU_0 * TURNS**2 * AREA * math.cos(ANGLE)
    return scale * ((upper / (GAP - x)) ** 2 - (lower / (GAP + x)) ** 2)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("permanent", [2.0, BIAS, 6.0])
def test_force_under_power_is_that_of_coils_with_the_same_bias(bearing, law, permanent):
    of_coils = axis(bearing, 0.0, i=0.7, force_law=law)
    of_magnets = axis(bearing, permanent, i=0.7, force_law=law)
    for name in ("mb1.f_x", "mb1.k_xx"):
        assert of_magnets[name] == of_coils[name]


def test_magnets_replace_the_bias_in_the_coils_and_its_heat(bearing):
    made = axis(bearing, i=0.7, force_law=NONLINEAR)
    assert made["mb1.i_upper_x"] == pytest.approx(LOAD + 0.7, rel=1e-12)
    assert made["mb1.i_lower_x"] == pytest.approx(-0.7, rel=1e-12)
    assert made["mb1.copper_loss_x"] == pytest.approx(0.365 * ((LOAD + 0.7) ** 2 + 0.7**2), rel=1e-12)


@pytest.mark.parametrize("x", [0.0, 2e-4, -2e-4])
def test_a_lost_amplifier_leaves_the_pull_of_the_magnets(bearing, x):
    """Without power both pairs have I_m: the centre is an unstable rest, and coils alone pull nothing."""
    kept = axis(bearing, i=0.7, amplifier_off=1.0, force_law=NONLINEAR, total_force=1.0)
    kept["mb1.x"] = x
    kept.initialise()
    assert kept["mb1.f_x"] == pytest.approx(pulls(BIAS, BIAS, x), rel=1e-9, abs=1e-9)
    coils = axis(bearing, 0.0, i=0.7, amplifier_off=1.0, force_law=NONLINEAR, total_force=1.0)
    coils["mb1.x"] = x
    coils.initialise()
    assert coils["mb1.f_x"] == 0.0
    assert kept["mb1.i_upper_x"] == kept["mb1.i_lower_x"] == 0.0


@pytest.mark.parametrize("law", [LINEAR, MEASURED])
def test_linear_laws_keep_the_stiffness_of_the_magnets_alone(bearing, law):
    """K_s is that of the remaining bias: (2 I_m^2)/((I_s + I_b)^2 + I_b^2) of the whole one."""
    under_power = axis(bearing, force_law=law)["mb1.k_xx"]
    without = axis(bearing, amplifier_off=1.0, force_law=law)["mb1.k_xx"]
    share = 2.0 * BIAS**2 / ((LOAD + BIAS) ** 2 + BIAS**2)
    level = (2.0 * BIAS / (LOAD + 2.0 * BIAS)) ** 2
    assert without == pytest.approx(under_power * level, rel=1e-12)
    assert level == pytest.approx(share, rel=0.02)


def test_coil_currents_of_both_signs_decay_without_power(bearing):
    """A negative current decays as a positive one does."""
    made = axis(bearing, i=2.0, force_law=NONLINEAR, amplifier=DYNAMIC)
    made["mb1.amplifier_off_x"], h = 1.0, 1e-3
    made.step(0.0, h)
    decay = math.exp(-0.365 / 0.0732 * h)
    assert made["mb1.i_upper_x"] == pytest.approx((LOAD + 2.0) * decay, rel=1e-9)
    assert made["mb1.i_lower_x"] == pytest.approx(-2.0 * decay, rel=1e-9)


def test_a_supply_empties_a_negative_current_in_its_time(bearing):
    made = bearing(
        values={"mb1.permanent_bias_x": BIAS, "mb1.i_x": 2.0, "mb1.discharge_voltage_x": 50.0}, amplifier=DYNAMIC
    )
    made["mb1.amplifier_off_x"] = 1.0
    to_zero = 0.0732 / 0.365 * math.log1p(0.365 * 2.0 / 50.0)
    made.step(0.0, 0.5 * to_zero)
    assert -2.0 < made["mb1.i_lower_x"] < 0.0
    made.step(0.5 * to_zero, 0.6 * to_zero)
    assert made["mb1.i_lower_x"] == 0.0


@pytest.mark.parametrize(("demand", "upper", "lower"), [(50.0, LOAD + BIAS, -BIAS), (-50.0, -BIAS, BIAS + LOAD)])
def test_coils_reverse_their_current_but_not_the_flux(bearing, demand, upper, lower):
    """The control current ends where one pair has no flux left."""
    made = axis(bearing, i=demand, force_law=NONLINEAR)
    assert made["mb1.i_upper_x"] == pytest.approx(upper if demand > 0.0 else -BIAS, abs=1e-12)
    assert made["mb1.i_lower_x"] == pytest.approx(lower, abs=1e-12)
    assert made["mb1.clipped_x"] == 1.0


def test_lost_turns_take_nothing_from_the_magnets(bearing):
    made = axis(bearing, i=1.0, force_law=NONLINEAR, total_force=1.0)
    made["mb1.coil_loss_upper_x"] = 0.5
    made.initialise()
    assert made["mb1.f_x"] == pytest.approx(pulls(BIAS + 0.5 * (LOAD + 1.0), BIAS - 1.0), rel=1e-9)


def test_a_voltage_limit_concerns_the_coils_alone(bearing):
    """5 V drive 13.7 A through 0.365 Ohm: enough for the coils beside magnets of 20 A, not for 20 A in them."""
    values = {"mb1.bias_current_x": 20.0, "mb1.permanent_bias_x": 20.0, "mb1.voltage_limit_x": 5.0}
    made = bearing(values=values, amplifier=DYNAMIC)
    assert made["mb1.i_upper_x"] == pytest.approx(LOAD)
    with pytest.raises(Exception, match=r"mb1.bias_current_x"):
        bearing(values=values | {"mb1.permanent_bias_x": 0.0}, amplifier=DYNAMIC)
