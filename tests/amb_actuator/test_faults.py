"""Faults of the hardware, switched while the bearing runs: lost turns, amplifiers off, stuck currents."""

import math

import numpy as np
import pytest
from messages import raises_naming
from running_actuator import F_0, K

from amb_actuator.amplifier import CoilPair, discharge, response
from amb_actuator.interface import DYNAMIC, LAWS, LINEAR, NONLINEAR
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from fmi_export.model import Fault

R, L, H = 0.365, 0.0732, 250e-6
K_I = 2 * K * (5.57 + 4.43)

laws = pytest.mark.parametrize("law", range(len(LAWS)), ids=LAWS)
amplifiers = pytest.mark.parametrize("amplifier", [0, DYNAMIC], ids=["ideal", "dynamic"])


def step_until_settled(actuator, steps=40, **inputs):
    for name, value in inputs.items():
        actuator[name.replace("__", ".")] = value
    for n in range(steps):
        actuator.step(n * H, H)
    return actuator


@amplifiers
def test_switched_off_currents_decay_with_the_time_constant_of_the_coil(bearing, amplifier):
    actuator = bearing(amplifier=amplifier, mb1__i_x=0.5)
    for n in range(1, 2001):
        actuator["mb1.amplifier_off_x"] = 1.0
        actuator.step(n * H, H)
        if n in (1, 10, 2000):
            decay = math.exp(-R / L * n * H)
            assert actuator["mb1.i_upper_x"] == pytest.approx(6.07 * decay, rel=1e-10)
            assert actuator["mb1.i_lower_x"] == pytest.approx(3.93 * decay, rel=1e-10)
            assert (actuator["mb1.v_upper_x"], actuator["mb1.v_lower_x"]) == (0.0, 0.0)
            loss = R * (6.07**2 + 3.93**2) * decay**2
            assert actuator["mb1.copper_loss_x"] == pytest.approx(loss, rel=1e-10)


def test_supply_drives_currents_of_a_switched_off_amplifier_to_zero(bearing):
    """L di/dt = -V - R i: from 5.57 A to zero in L/R ln(1 + R i/V), 2.7 ms at 150 V, and not beyond."""
    voltage, h = 150.0, 1e-3
    actuator = bearing(mb1__discharge_voltage_x=voltage)
    time_to_zero = L / R * math.log1p(R * 5.57 / voltage)
    assert time_to_zero == pytest.approx(2.7e-3, rel=0.01)
    actuator["mb1.amplifier_off_x"] = 1.0
    for n in range(1, 5):
        actuator.step(n * h, h)
        current = (5.57 + voltage / R) * math.exp(-R / L * n * h) - voltage / R
        assert actuator["mb1.i_upper_x"] == pytest.approx(current if n * h < time_to_zero else 0.0, rel=1e-9)
        assert actuator["mb1.v_upper_x"] == (-voltage if n * h < time_to_zero else 0.0)
    assert actuator["mb1.i_lower_x"] == 0.0


def test_mean_of_a_current_that_reaches_zero_is_that_of_its_parts():
    p, i, mean = axis_parameters(discharge_voltage=150.0), 5.57, 0.0

    def discharge_response(i, h):
        return response(discharge(p, CoilPair(0.0, 1.0, i), h), h)

    for _ in range(50):
        part = discharge_response(i, 1e-4)
        i, mean = part.current, mean + part.mean / 50
    assert i == 0.0
    assert discharge_response(5.57, 5e-3).mean == pytest.approx(mean, rel=1e-12)


def test_amplifier_that_is_off_from_the_beginning_has_no_current(bearing):
    actuator = bearing(mb1__amplifier_off_x=1.0, mb1__i_x=2.0)
    assert (actuator["mb1.i_upper_x"], actuator["mb1.i_lower_x"]) == (0.0, 0.0)
    assert actuator["mb1.copper_loss_x"] == 0.0


def test_ideal_amplifier_recovers_at_once_a_dynamic_one_at_its_slew_rate(bearing):
    for amplifier in (0, DYNAMIC):
        actuator = bearing(amplifier=amplifier, mb1__amplifier_off_x=1.0)
        step_until_settled(actuator, steps=1, mb1__amplifier_off_x=0.0)
        expected = 5.57 if amplifier == 0 else 150.0 / R * (1 - math.exp(-R / L * H))
        assert actuator["mb1.i_upper_x"] == pytest.approx(expected, rel=1e-12)
        step_until_settled(actuator, steps=100)
        assert actuator["mb1.f_x"] == pytest.approx(0.0, abs=1e-9)


@amplifiers
def test_stuck_currents_stay_and_return_when_freed(bearing, amplifier):
    actuator = step_until_settled(bearing(amplifier=amplifier), mb1__i_x=1.0)
    step_until_settled(actuator, mb1__stuck_x=1.0, mb1__i_x=-2.0)
    assert actuator["mb1.i_upper_x"] == pytest.approx(6.57, rel=1e-12)
    assert actuator["mb1.i_lower_x"] == pytest.approx(3.43, rel=1e-12)
    assert actuator["mb1.f_x"] == pytest.approx(K_I, rel=1e-9)
    assert actuator["mb1.v_upper_x"] == pytest.approx(R * 6.57)
    step_until_settled(actuator, mb1__stuck_x=0.0)
    assert actuator["mb1.f_x"] == pytest.approx(-2 * K_I, rel=1e-9)


def test_current_sticks_in_the_middle_of_a_slew(bearing):
    actuator = step_until_settled(bearing(amplifier=DYNAMIC), steps=3, mb1__i_x=4.0)
    held = actuator["mb1.i_upper_x"]
    assert 5.57 < held < 9.0
    step_until_settled(actuator, mb1__stuck_x=1.0)
    assert actuator["mb1.i_upper_x"] == held


def test_amplifier_that_is_off_cannot_hold_a_stuck_current(bearing):
    actuator = step_until_settled(bearing(), steps=10, mb1__stuck_x=1.0, mb1__amplifier_off_x=1.0)
    assert actuator["mb1.i_upper_x"] == pytest.approx(5.57 * math.exp(-R / L * 10 * H), rel=1e-12)


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
@pytest.mark.parametrize("law", [LINEAR, NONLINEAR])
def test_lost_turns_cost_pull_with_their_square(bearing, law, share):
    upper = bearing(force_law=law, mb1__coil_loss_upper_x=share)
    lower = bearing(force_law=law, mb1__coil_loss_lower_x=share)
    both = bearing(force_law=law, mb1__coil_loss_upper_x=share, mb1__coil_loss_lower_x=share)
    retained = (1 - share) ** 2
    assert upper["mb1.f_x"] == pytest.approx(-(1 - retained) * K * 5.57**2, rel=1e-9)
    assert lower["mb1.f_x"] == pytest.approx((1 - retained) * K * 4.43**2, rel=1e-9)
    assert both["mb1.f_x"] == pytest.approx(-(1 - retained) * F_0, rel=1e-9)
    whole = 2 * K * (5.57**2 + 4.43**2) / 1.2e-3
    assert upper["mb1.k_xx"] == pytest.approx(whole - (1 - retained) * 2 * K * 5.57**2 / 1.2e-3, rel=1e-9)
    assert both["mb1.k_xx"] == pytest.approx(retained * whole, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("law", [LINEAR, NONLINEAR])
def test_control_current_of_a_half_lost_coil_acts_on_the_remaining_turns(bearing, law):
    """dF/dI_c = 2 K [n_u^2 (I_s + I_b) + n_l^2 I_b] at the centre."""
    forces = [bearing(force_law=law, mb1__coil_loss_upper_x=0.5, mb1__i_x=i_c)["mb1.f_x"] for i_c in (-1e-3, 1e-3)]
    assert (forces[1] - forces[0]) / 2e-3 == pytest.approx(2 * K * (0.25 * 5.57 + 4.43), rel=1e-9)


def test_turns_lost_in_part_leave_current_and_copper_loss_alone(bearing):
    faulty, sound = bearing(mb1__coil_loss_upper_x=0.7), bearing()
    for name in ("i_upper", "i_lower", "copper_loss", "v_upper"):
        assert faulty[f"mb1.{name}_x"] == sound[f"mb1.{name}_x"]


@amplifiers
@pytest.mark.parametrize(("lost", "left", "left_current"), [("upper", "lower", 4.43), ("lower", "upper", 5.57)])
def test_a_coil_pair_without_turns_has_no_current(bearing, amplifier, lost, left, left_current):
    """Neither at the start nor under a demand of 10 A, with which the controller tries to get its force back."""
    fault = {f"coil_loss_{lost}_x": 1.0}
    actuator = bearing({f"mb1.{name}": value for name, value in fault.items()}, amplifier=amplifier)
    for demand in (0.0, 10.0, -10.0):
        if demand:
            step_until_settled(actuator, mb1__i_x=demand)
        assert [actuator[f"mb1.{name}_{lost}_x"] for name in ("i", "v")] == [0.0, 0.0]
        current = actuator[f"mb1.i_{left}_x"]
        assert actuator["mb1.copper_loss_x"] == pytest.approx(R * current**2, rel=1e-12)
        assert demand or current == pytest.approx(left_current, rel=1e-12)


def test_no_demand_is_cut_while_the_amplifiers_are_off(bearing):
    actuator = step_until_settled(bearing(), 1, mb1__i_x=50.0)
    assert actuator["mb1.clipped_x"] == 1.0
    step_until_settled(actuator, 1, mb1__amplifier_off_x=1.0)
    assert actuator["mb1.clipped_x"] == 0.0
    assert bearing(mb1__i_x=50.0, mb1__amplifier_off_x=1.0)["mb1.clipped_x"] == 0.0


@laws
@amplifiers
def test_cured_faults_leave_no_trace(bearing, law, amplifier):
    actuator = bearing(force_law=law, amplifier=amplifier, mb1__x=1e-4)
    before = actuator.outputs.copy()
    faults = {"amplifier_off_x": 1.0, "stuck_x": 1.0, "coil_loss_upper_x": 0.7, "coil_loss_lower_x": 0.2}
    for fault, value in faults.items():
        step_until_settled(actuator, **{f"mb1__{fault}": value})
        assert not np.array_equal(actuator.outputs, before) or fault == "stuck_x"
        step_until_settled(actuator, steps=400, **{f"mb1__{fault}": 0.0})
    np.testing.assert_allclose(actuator.outputs, before, rtol=1e-12, atol=1e-9)


@laws
@pytest.mark.parametrize("sign", [1, -1])
def test_magnet_without_power_allows_contact_with_the_stator(bearing, law, sign):
    """Without currents the force is that without turns; while they decay, iron and air gap limit force and gradient."""
    share = np.array([0.99, 1.0, 1.05])
    dead = [bearing(force_law=law, total_force=1.0, mb1__amplifier_off_x=1.0) for _ in share]
    for actuator, x in zip(dead, sign * 1.2e-3 * share, strict=True):
        step_until_settled(actuator, steps=1, mb1__x=x)
        assert actuator["mb1.f_x"] == 0.0
    decaying = bearing(force_law=law, total_force=1.0)
    decaying["mb1.amplifier_off_x"] = 1.0
    step_until_settled(decaying, steps=1, mb1__x=sign * 1.2e-3)
    assert 0.0 < sign * decaying["mb1.f_x"] < (1700.0 if law == NONLINEAR else 8000.0) * 1.000001
    assert decaying["mb1.k_xx"] == 0.0


def test_rotor_beyond_the_stator_is_a_fault_without_power_too(bearing):
    actuator = bearing(mb1__amplifier_off_x=1.0)
    actuator["mb1.x"] = 1.1 * 1.2e-3
    with raises_naming(Fault, "mb1.x", "0.00132 m", "air gap"):
        actuator.step(0.0, H)


def test_contact_with_the_stator_is_a_fault_of_an_axis_with_power(bearing):
    actuator = bearing(mb1__amplifier_off_y=1.0)
    actuator["mb1.x"] = 1.2e-3
    with raises_naming(Fault, "mb1.x", "air gap"):
        actuator.step(0.0, H)
