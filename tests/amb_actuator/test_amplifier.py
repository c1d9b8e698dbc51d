"""Amplifier and coil: closed forms, an independent integration, and independence of the communication step.

Currents are looked at on MB1, x axis; at rest its coil pairs carry 5.57 A and 4.43 A.
"""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from amb_actuator.amplifier import CoilPair, course_at_voltage, end_and_mean, regulated, response
from amb_actuator.interface import DYNAMIC
from amb_analysis.machine.axis_capability import current_amplitude
from amb_cosim.model_constants.magnetic_bearing import axis_parameters

pytestmark = pytest.mark.gate

R, L, V, BAND = 0.365, 0.0732, 150.0, 1400.0
OMEGA = 2 * math.pi * BAND
SMALLEST_LIMITED = (V - R * 5.57) / (L * OMEGA)  # a step of the command that requires just V (A), 0.23 A
RIG = axis_parameters()


def regulated_response(p, i, target, h):
    """The response of a coil with the current i (A): with the operating point at 0 A, currents are deviations."""
    return response(regulated(p, CoilPair(0.0, 1.0, i), target, h), h)


def mean_and_end(p, i, v, h):
    """The average and the last current of a coil under a constant voltage v (V)."""
    end, mean = end_and_mean(course_at_voltage(p, CoilPair(0.0, 1.0, i), v, h))
    return mean, end


def run(actuator, h, steps, demand, names=("mb1.i_upper_x", "mb1.i_lower_x")):
    """Outputs after each step; `demand` (A) is a number or a function of time (s)."""
    rows = np.empty((steps, len(names)))
    for n in range(steps):
        actuator["mb1.i_x"] = demand(n * h) if callable(demand) else demand
        actuator.step(n * h, h)
        rows[n] = [actuator[name] for name in names]
    return rows


@pytest.fixture
def dynamic(bearing):
    return lambda **values: bearing(amplifier=DYNAMIC, **values)


@pytest.mark.parametrize("h", [1e-6, 250e-6, 1e-3])
def test_current_follows_a_small_step_of_the_command_exponentially(dynamic, h):
    size = 0.9 * SMALLEST_LIMITED
    i = run(dynamic(), h, 20, size)
    t = h * np.arange(1, 21)
    np.testing.assert_allclose(i[:, 0], 5.57 + size * (1 - np.exp(-OMEGA * t)), rtol=1e-13)
    np.testing.assert_allclose(i[:, 1], 4.43 - size * (1 - np.exp(-OMEGA * t)), rtol=1e-13)


def test_voltage_of_a_small_step_is_that_of_coil_and_resistance(dynamic):
    h, size = 1e-6, 0.9 * SMALLEST_LIMITED
    record = run(dynamic(), h, 50, size, ("mb1.i_upper_x", "mb1.v_upper_x"))
    rate = OMEGA * (5.57 + size - record[:, 0])
    np.testing.assert_allclose(record[:, 1], L * rate + R * record[:, 0], rtol=1e-12)


def test_frequency_response_is_that_of_the_transfer_function(dynamic):
    """A sampled and held sine against the transfer function, sampled the same way by python-control."""
    h, amplitude = 20e-6, 0.05
    sampled = control.sample_system(control.tf([OMEGA], [1.0, OMEGA]), h, method="zoh")
    for period in (20, 50, 200, 1000):
        omega = 2 * math.pi / (period * h)
        actuator = dynamic()
        run(actuator, h, 2 * period + 200, lambda t, w=omega: amplitude * math.sin(w * t))
        start = 2 * period + 200
        t = h * (start + np.arange(period))
        d = np.empty(period)
        for n in range(period):
            actuator["mb1.i_x"] = amplitude * math.sin(omega * t[n])
            actuator.step(t[n], h)
            d[n] = actuator["mb1.i_upper_x"] - 5.57
        result = 2j / period * np.sum(d * np.exp(-1j * omega * (t + h))) / amplitude
        assert result == pytest.approx(complex(sampled(np.exp(1j * omega * h))), rel=1e-9)


@pytest.mark.parametrize("demand", [4.43, -5.57, 1.0])
def test_large_step_of_the_command_runs_at_the_voltage_limit(dynamic, demand):
    """L di/dt = +-V - R i from the first instant."""
    h, sign = 10e-6, math.copysign(1.0, demand)
    names = ("mb1.i_upper_x", "mb1.i_lower_x", "mb1.voltage_limited_x", "mb1.v_upper_x", "mb1.v_lower_x")
    record = run(dynamic(), h, 30, demand, names)
    t = h * np.arange(1, 31)
    for k, (i_0, v) in enumerate(((5.57, sign * V), (4.43, -sign * V))):
        np.testing.assert_allclose(record[:, k], v / R + (i_0 - v / R) * np.exp(-R / L * t), rtol=1e-11)
        np.testing.assert_array_equal(record[:, 3 + k], v)
    assert np.all(record[:, 2] == 1.0)


def test_voltage_leaves_its_limit_when_the_regulator_demands_less(dynamic):
    """I_leave = (L omega I_ref - V)/(L omega - R), reached after -L/R ln((V/R - I_leave)/(V/R - I_0))."""
    target = 5.57 + 2.0
    leave = (L * OMEGA * target - V) / (L * OMEGA - R)
    after = -L / R * math.log((V / R - leave) / (V / R - 5.57))
    names = ("mb1.i_upper_x", "mb1.v_upper_x")
    for length, still_limited in ((0.99 * after, True), (1.01 * after, False)):
        i, v = run(dynamic(), length, 1, 2.0, names)[0]
        assert (i < leave, v == V) == (still_limited, still_limited)
    i, v = run(dynamic(), after, 1, 2.0, names)[0]
    assert (i, v) == (pytest.approx(leave, rel=1e-12), pytest.approx(V, rel=1e-9))
    later = run(dynamic(), after + 100e-6, 1, 2.0)[0, 0]
    assert later == pytest.approx(target + (leave - target) * math.exp(-OMEGA * 100e-6), rel=1e-12)


def test_either_coil_pair_at_the_limit_raises_the_flag(dynamic):
    """For a falling command the lower pair requires more: L omega d + R I_b against L omega d - R (I_s + I_b)."""
    lower_only = -(0.5 * (V - R * 4.43) + 0.5 * (V + R * 5.57)) / (L * OMEGA)
    names = ("mb1.v_upper_x", "mb1.v_lower_x", "mb1.voltage_limited_x")
    for demand, flag in ((0.9 * lower_only, 0.0), (lower_only, 1.0)):
        upper, lower, raised = run(dynamic(), 1e-9, 1, demand, names)[0]
        assert raised == flag
        assert -V < upper < 0.0 < lower <= V


def clipped_regulator(target):
    """Rates of the current and of its integral."""

    def rates(_, z):
        v = np.clip(L * OMEGA * (target - z[0]) + R * z[0], -V, V)
        return [(v - R * z[0]) / L, z[0]]

    return rates


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:invalid value:RuntimeWarning")  # scipy, where nothing changes any more
@pytest.mark.parametrize(("start", "target"), [(5.57, 7.0), (5.57, 0.0), (0.0, 10.0), (9.0, 8.9), (3.0, 3.0)])
@pytest.mark.parametrize("h", [5e-5, 1e-3, 6e-3, 0.5])
def test_one_step_agrees_with_an_eighth_order_integration(start, target, h):
    result = regulated_response(RIG, start, target, h)
    short = max(1e-4, 2e-3 * h)  # so that no step passes over the end of the limit
    exact = solve_ivp(clipped_regulator(target), (0, h), [start, 0.0], "DOP853", rtol=1e-11, atol=1e-13, max_step=short)
    assert result.current == pytest.approx(exact.y[0, -1], abs=1e-8)
    assert result.mean == pytest.approx(exact.y[1, -1] / h, abs=1e-8)


inside = st.floats(0.0, 10.0)


@given(inside, inside, st.floats(1e-6, 2e-2), st.integers(2, 12))
def test_one_step_equals_many_short_ones(start, target, h, parts):
    """Currents and averages, in and out of the voltage limit and through the switch between them."""
    whole = regulated_response(RIG, start, target, h)
    i, charge, limited = start, 0.0, 0.0
    for _ in range(parts):
        part = regulated_response(RIG, i, target, h / parts)
        i, charge, limited = part.current, charge + part.mean * h / parts, max(limited, part.limited)
    assert i == pytest.approx(whole.current, rel=1e-12, abs=1e-12)
    assert charge / h == pytest.approx(whole.mean, rel=1e-11, abs=1e-11)
    assert part.voltage == pytest.approx(whole.voltage, rel=1e-9, abs=1e-9)
    if abs(abs(L * OMEGA * (target - start) + R * start) - V) > 1e-9:
        assert limited == whole.limited


@given(inside, inside, st.floats(1e-9, 10.0))
def test_current_moves_towards_its_command_and_never_past_it(start, target, h):
    result = regulated_response(RIG, start, target, h)
    low, high = sorted((start, target))
    slack = 1e-13
    assert low - slack <= result.current <= high + slack
    assert low - 1e-11 <= result.mean <= high + 1e-11
    assert abs(result.current - start) >= abs(result.mean - start) - 1e-11
    assert abs(result.voltage) <= V * (1 + 1e-12)


amplifiers = st.builds(
    lambda r, inductance, bandwidth, v: axis_parameters(
        resistance=r, inductance=inductance, bandwidth=bandwidth, voltage_limit=v
    ),
    st.floats(1e-3, 1e3),
    st.floats(1e-6, 10.0),
    st.floats(1e-3, 1e6),
    st.floats(0.1, 1e4),
)


@given(amplifiers, st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(1e-9, 1e3))
def test_any_amplifier_stays_between_start_and_command(p, start, target, h):
    """Slow and fast regulators, and commands up to all that the voltage can hold."""
    largest = min(10.0, p.voltage_limit / p.resistance)
    i, goal = start * largest, target * largest
    result = regulated_response(p, i, goal, h)
    low, high = sorted((i, goal))
    assert np.all(np.isfinite(result))
    assert low - 1e-9 <= result.current <= high + 1e-9
    assert low - 1e-7 <= result.mean <= high + 1e-7


@pytest.mark.parametrize("slower", [1.0, 0.5])
def test_slow_regulator_holds_the_current_of_the_voltage_limit(slower):
    """L omega <= R. The required voltage is V, up to rounding either way."""
    for v in np.linspace(1.0, 9.0, 200):
        p = axis_parameters(resistance=2 * math.pi, inductance=1.0, bandwidth=slower, voltage_limit=v)
        result = regulated_response(p, v / p.resistance, v / p.resistance, 1e-3)
        assert (result.current, result.mean) == (pytest.approx(v / p.resistance), pytest.approx(v / p.resistance))
        assert result.limited == 0.0


def test_large_sine_becomes_a_triangle_of_the_slew_rate(dynamic):
    """Far above the amplitude that the voltage allows the current rises and falls by V/L: amplitude V/(4 f L)."""
    h, f = 20e-6, 500.0
    i = run(dynamic(), h, 2000, lambda t: 4.43 * math.sin(2 * math.pi * f * t))[-200:, 0]
    swing = 0.5 * (i.max() - i.min())
    assert swing == pytest.approx(V / (4 * f * L), rel=0.03)
    assert swing < 4.43 / 3


@pytest.mark.parametrize("f", [50.0, 200.0, 800.0])
def test_sine_stays_a_sine_up_to_the_amplitude_that_the_voltage_allows(dynamic, f):
    """The coil follows the command by omega_b/(omega_b + j omega), so the command may be larger by that."""
    h = 1e-6
    allowed = min(float(current_amplitude(RIG, f)), 4.4) * math.hypot(1.0, f / BAND)
    steps = round(2 / f / h)
    for share, limited in ((0.99, 0.0), (1.05, 1.0)):
        if share * allowed > 4.43:
            continue
        names = ("mb1.voltage_limited_x", "mb1.clipped_x")
        record = run(dynamic(), h, steps, lambda t, a=share * allowed: a * math.sin(2 * math.pi * f * t), names)
        assert np.all(record[:, 1] == 0.0)
        assert np.max(record[steps // 2 :, 0]) == limited  # the first period has the transient


@given(st.floats(1e-9, 1e-2), st.floats(-1.0, 1.0))
def test_short_steps_keep_the_digits_of_their_average(h, v):
    """Half way to the end but for z/6 of the way: three terms of the series are enough below z = R h/L = 1e-4."""
    mean, end = mean_and_end(RIG, 1.0, 1e3 * v, h)
    z = R * h / L
    if z < 1e-4:
        rise = (1e3 * v / R - 1.0) * z
        assert mean - 1.0 == pytest.approx(rise * (1 / 2 - z / 6 + z * z / 24), rel=1e-9, abs=1e-15)
        assert end - 1.0 == pytest.approx(rise * (1 - z / 2 + z * z / 6), rel=1e-9, abs=1e-15)
    assert abs(mean - 1.0) <= abs(end - 1.0)


def test_voltage_command_drives_half_an_ampere_per_volt(bearing):
    assert bearing(mb1__command_voltage_x=2.0)["mb1.f_x"] == pytest.approx(563.15, abs=0.005)
    assert bearing(mb1__command_voltage_x=2.0, mb1__i_x=-1.0)["mb1.f_x"] == 0.0
    assert bearing(mb1__command_voltage_x=2.0, mb1__amplifier_gain_x=-0.25)["mb1.i_upper_x"] == pytest.approx(5.07)
    assert bearing(mb1__command_voltage_x=100.0)["mb1.clipped_x"] == 1.0


def test_command_is_limited_to_the_current_that_the_voltage_can_hold(dynamic, bearing):
    """3 V through 0.365 Ohm is 8.22 A."""
    actuator = dynamic(mb1__voltage_limit_x=3.0, mb1__i_x=4.0)
    assert actuator["mb1.i_upper_x"] == pytest.approx(3.0 / R)
    assert actuator["mb1.clipped_x"] == 1.0
    run(actuator, 10.0, 1, 4.0)
    assert actuator["mb1.i_upper_x"] == pytest.approx(3.0 / R)
    assert bearing(mb1__voltage_limit_x=3.0, mb1__i_x=4.0)["mb1.clipped_x"] == 0.0, "the ideal amplifier knows no volts"


def test_ideal_amplifier_reaches_its_command_at_once(bearing):
    actuator = bearing()
    for i_c in (4.0, -5.0, 0.3):
        run(actuator, 1e-6, 1, i_c)
        assert actuator["mb1.i_upper_x"] == pytest.approx(5.57 + i_c, abs=1e-12)
        assert actuator["mb1.voltage_limited_x"] == 0.0
        assert actuator["mb1.v_upper_x"] == pytest.approx(R * (5.57 + i_c))


def test_dynamic_amplifier_starts_in_the_steady_state_of_its_command(dynamic):
    actuator = dynamic(mb1__i_x=2.0)
    before = [actuator[f"mb1.{n}_x"] for n in ("f", "i_upper", "i_lower", "v_upper", "v_lower", "copper_loss")]
    run(actuator, 250e-6, 10, 2.0)
    after = [actuator[f"mb1.{n}_x"] for n in ("f", "i_upper", "i_lower", "v_upper", "v_lower", "copper_loss")]
    np.testing.assert_allclose(after, before, rtol=1e-12)


def test_supply_pays_for_copper_and_field():
    """The integral of v i - R i^2 is the gain of L i^2/2, through the voltage limit and after it."""
    i, h, target = 5.57, 2e-7, 7.5
    supplied, heat = 0.0, 0.0
    first = i
    for _ in range(8000):
        coil = regulated_response(RIG, i, target, h)
        voltage = L * (coil.current - i) / h + R * coil.mean
        assert abs(voltage) <= V * (1 + 1e-6)
        supplied += voltage * coil.mean * h
        heat += R * coil.mean**2 * h
        i = coil.current
    assert i == pytest.approx(target, abs=1e-2)
    assert supplied - heat == pytest.approx(0.5 * L * (i**2 - first**2), rel=1e-6)


def test_switched_off_coil_turns_its_field_into_heat():
    i, h, heat = 5.57, 1e-4, 0.0
    for _ in range(30_000):
        mean, i = mean_and_end(RIG, i, 0.0, h)
        heat += R * mean**2 * h
    assert i < 1e-5
    assert heat == pytest.approx(0.5 * L * 5.57**2, rel=1e-5)


@pytest.mark.parametrize("i_c", [0.0, 2.0, -5.57])
def test_copper_loss_is_that_of_both_coil_pairs(bearing, i_c):
    expected = R * ((5.57 + i_c) ** 2 + (4.43 - i_c) ** 2)
    assert bearing(mb1__i_x=i_c)["mb1.copper_loss_x"] == pytest.approx(expected, rel=1e-12)
