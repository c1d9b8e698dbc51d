"""PID: signs, equivalence with a spring and a damper, limits, start, setpoint, what the DAC makes of it."""

from __future__ import annotations

import cmath

import numpy as np
import pytest
from rig import given_parameters
from scipy.linalg import expm

from rolac_controller.parameters import BEARING_K_I, BEARING_K_S
from rolac_controller.pid import response

AXES = [("mb1", "x", "s5"), ("mb1", "y", "s6"), ("mb2", "x", "s3"), ("mb2", "y", "s4")]
MASS = 50.0  # kg, half the rotor


def levitate(bench, h, duration, x0=0.0, load=0.0, setpoint=0.0):
    """Displacements of a mass in one bearing axis at each sample; its motion between them is exact."""
    b = bench(sample_time=h)
    b["mb1.set_x"] = setpoint
    a = np.zeros((3, 3))
    a[0, 1] = 1.0
    a[1] = [BEARING_K_S / MASS, 0.0, 1.0 / MASS]
    transition = expm(a * h)
    state = np.array([x0, 0.0, 0.0])
    history = []
    for _ in range(round(duration / h)):
        history.append(state[0])
        b["s5"] = state[0]
        b.sample()
        state[2] = BEARING_K_I * b["mb1.i_x"] + load
        state = transition @ state
    return np.array(history)


@pytest.mark.parametrize(("bearing", "axis", "sensor"), AXES)
def test_positive_displacement_gives_negative_current_on_its_axis_alone(bench, bearing, axis, sensor):
    b = bench()
    b[sensor] = 1e-5
    b.sample()
    for other, a, _ in AXES:
        expected = -(1e6 + BEARING_K_S) * 1e-5 / BEARING_K_I if (other, a) == (bearing, axis) else 0.0
        assert b[f"{other}.i_{a}"] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("sensor", ["s1", "s2", "s7", "s8"])
def test_sensors_at_the_rotor_ends_do_not_reach_the_pid(bench, sensor):
    b = bench()
    b[sensor] = 1e-4
    b.sample()
    assert [b[f"{bearing}.i_{axis}"] for bearing, axis, _ in AXES] == [0.0] * 4


def test_rising_displacement_adds_damping_current(bench):
    b = bench()
    b.sample()
    b["s5"] = 1e-6
    b.sample()
    expected = -((1e6 + BEARING_K_S) * 1e-6 + 5000.0 * 1e-6 / 250e-6) / BEARING_K_I
    assert b["mb1.i_x"] == pytest.approx(expected, rel=1e-13)


def test_filtered_derivative_of_a_ramp_settles_with_its_time_constant(bench):
    slope, tau, h = 1e-3, 2e-3, 250e-6
    b = bench(derivative_time=tau, mb1__k_b_x=-BEARING_K_S)  # no proportional part
    for n in range(200):
        b["s5"] = slope * n * h
        b.sample()
        expected = slope * (1.0 - (tau / (tau + h)) ** n)
        assert -b["mb1.i_x"] * BEARING_K_I / 5000.0 == pytest.approx(expected, rel=1e-9, abs=1e-15)


def test_static_stiffness_of_the_closed_bearing_is_k_b(bench):
    x = levitate(bench, 250e-6, 0.6, load=100.0)
    assert x[-1] == pytest.approx(100.0 / 1e6, rel=1e-8)


def test_closed_bearing_moves_like_a_spring_and_a_damper(bench):
    def error(h):
        x = levitate(bench, h, 0.1, x0=1e-4)
        t = h * np.arange(len(x))
        root = np.roots([MASS, 5000.0, 1e6])[0]
        exact = 1e-4 * np.exp(root.real * t) * (np.cos(root.imag * t) - root.real / root.imag * np.sin(root.imag * t))
        return np.abs(x - exact).max() / 1e-4

    assert error(1e-5) < 5e-3
    assert error(2e-5) / error(1e-5) == pytest.approx(2.0, rel=0.1)  # sampling costs first order in h


def test_closed_bearing_is_stable_at_4_khz(bench):
    x = levitate(bench, 250e-6, 1.0, x0=1e-4)
    assert np.abs(x[-100:]).max() < 1e-12


def test_integral_removes_the_deflection_under_a_load(bench):
    def make(**parameters):
        return bench(mb1__k_integral_x=2e7, **parameters)

    x = levitate(make, 250e-6, 2.0, load=100.0)
    assert x.max() > 5e-5
    assert abs(x[-1]) < 1e-10


def test_current_stays_within_its_limits(bench):
    b = bench()
    for displacement, limit in [(1e-2, -5.57), (-1e-2, 4.43)]:
        b["s5"] = displacement
        b.sample()
        assert b["mb1.i_x"] == limit


def test_integral_does_not_wind_up_at_the_limit(bench):
    b = bench(mb1__k_integral_x=1e8, mb1__c_b_x=0.0)
    for sign in (1.0, -1.0):
        b["s5"] = sign * 2e-3
        for _ in range(4000):
            b.sample()
        b["s5"] = 0.0
        b.sample()
        assert b["mb1.i_x"] == 0.0


def test_current_leaves_the_limit_at_the_sample_after_the_sign_changes(bench):
    b = bench(mb1__k_integral_x=1e8, mb1__c_b_x=0.0)
    b["s5"] = 1e-4
    for _ in range(4000):  # the integral alone drives the current to its limit and would go on
        b.sample()
    assert b["mb1.i_x"] == -5.57
    b["s5"] = -1e-5
    b.sample()
    assert b["mb1.i_x"] > -5.57


def test_start_off_centre_has_no_derivative_kick(bench):
    b = bench()
    b["s5"] = 5e-5
    b.instance.initialise()
    proportional = -(1e6 + BEARING_K_S) * 5e-5 / BEARING_K_I
    assert b["mb1.i_x"] == pytest.approx(proportional, rel=1e-14)
    for _ in range(3):
        b.sample()
        assert b["mb1.i_x"] == pytest.approx(proportional, rel=1e-14)


def test_change_of_the_integral_gain_makes_no_bump(bench):
    b = bench(mb1__k_integral_x=1e7)
    b["s5"] = 1e-5
    for _ in range(1000):
        b.sample()
    b["s5"] = 0.0
    b.sample()
    b.sample()
    before = b["mb1.i_x"]
    assert before < -0.01
    b["mb1.k_integral_x"] = 5e7
    b.sample()
    assert b["mb1.i_x"] == before


def test_direct_gains_give_the_same_current_as_equal_net_gains(bench):
    net = bench(mb1__k_integral_x=1e6, derivative_time=1e-3)
    direct = bench(
        pid__direct=1, mb1__k_p_x=1e6 + BEARING_K_S, mb1__k_d_x=5e3, mb1__k_integral_x=1e6, derivative_time=1e-3
    )
    rng = np.random.default_rng(2)
    for x in 1e-5 * rng.normal(size=200):
        for b in (net, direct):
            b["s5"] = x
            b.sample()
        assert direct["mb1.i_x"] == pytest.approx(net["mb1.i_x"], rel=1e-13, abs=1e-15)
    assert abs(net["mb1.i_x"]) > 1e-3


def test_direct_gains_leave_the_net_ones_out(bench):
    b = bench(pid__direct=1, mb1__k_p_x=2.7e6, mb1__k_d_x=0.0, mb1__k_b_x=5e6, mb1__c_b_x=1e5)
    b.sample()
    b["s5"] = 1e-5
    b.sample()
    assert b["mb1.i_x"] == pytest.approx(-2.7e6 * 1e-5 / BEARING_K_I, rel=1e-14)


def test_rotor_goes_to_its_setpoint_without_an_integral(bench):
    """The compensation of K_s holds it there: no force is needed to stay off the centre."""
    assert levitate(bench, 250e-6, 0.6, setpoint=1e-4)[-1] == pytest.approx(1e-4, rel=1e-8)


def test_integral_removes_the_deviation_from_a_setpoint_under_a_load(bench):
    def make(**parameters):
        return bench(mb1__k_integral_x=2e7, **parameters)

    x = levitate(make, 250e-6, 2.0, load=100.0, setpoint=-5e-5)
    assert abs(x[-1] + 5e-5) < 1e-10


def test_integral_balances_the_negative_stiffness_with_direct_gains(bench):
    def make(**parameters):
        return bench(pid__direct=1, mb1__k_p_x=1e6 + BEARING_K_S, mb1__k_integral_x=2e7, **parameters)

    assert levitate(make, 250e-6, 2.0, setpoint=1e-4)[-1] == pytest.approx(1e-4, rel=1e-5)


def test_step_of_the_setpoint_has_no_derivative_kick(bench):
    b = bench(mb1__c_b_x=1e5)
    b.sample()
    b["mb1.set_x"] = 1e-5
    b.sample()
    assert b["mb1.i_x"] == pytest.approx(1e6 * 1e-5 / BEARING_K_I, rel=1e-14)


@pytest.mark.parametrize(("bearing", "axis", "_"), AXES)
def test_each_axis_has_its_own_setpoint(bench, bearing, axis, _):
    b = bench()
    b[f"{bearing}.set_{axis}"] = 1e-5
    b.sample()
    moved = [other for other in AXES if b[f"{other[0]}.i_{other[1]}"] != 0.0]
    assert [other[:2] for other in moved] == [(bearing, axis)]


@pytest.mark.parametrize("integral", [0.0, 3e6])
@pytest.mark.parametrize("tau", [0.0, 2e-3])
@pytest.mark.parametrize("frequency", [5.0, 35.0, 400.0])
def test_stated_response_is_what_a_vibration_gets(bench, frequency, tau, integral):
    h, omega = 250e-6, 2.0 * np.pi * frequency
    b = bench(mb1__k_integral_x=integral, derivative_time=tau)
    samples = 2 * round(max(4.0 / frequency, 0.1) / h)  # the second half is settled
    x = 1e-5 * np.cos(omega * h * np.arange(samples))
    force = []
    for value in x:
        b["s5"] = value
        b.sample()
        force.append(-BEARING_K_I * b["mb1.i_x"])
    turn = np.exp(1j * omega * h * np.arange(samples))[samples // 2 :]
    basis = np.array([turn.real, -turn.imag, np.ones(len(turn))]).T
    (re, im, _), *_ = np.linalg.lstsq(basis, np.array(force)[samples // 2 :], rcond=None)
    gains = given_parameters({"mb1.k_integral_x": integral}).axes[0]
    stated = response(gains, 0.0, tau, h, omega) * 1e-5
    assert complex(re, im) == pytest.approx(stated, rel=1e-7)


def test_slow_vibration_meets_a_spring_and_a_damper():
    gains = given_parameters({}).axes[0]
    omega = 2.0 * np.pi * 10.0
    stated = response(gains, 0.0, 0.0, 250e-6, omega)
    assert cmath.isclose(stated, 1e6 + BEARING_K_S + 5e3j * omega, rel_tol=5e-3)
    assert gains.i_min < 0.0 < gains.i_max


@pytest.mark.parametrize("x", [1e-4, -1e-4])
def test_dac_steps_are_0_61_ma(bench, x):
    b = bench(chain__preset=2, chain__dac=1)
    step = 20.0 / 2**14 * 0.5
    exact = -(1e6 + BEARING_K_S) * x / BEARING_K_I
    b["s5"] = x
    b.sample()
    assert b["mb1.i_x"] / step == pytest.approx(round(b["mb1.i_x"] / step), abs=1e-9)
    assert 0.0 < abs(b["mb1.i_x"] - exact) <= 0.5001 * step
    assert step == pytest.approx(0.61e-3, rel=1e-2)


def test_dac_range_limits_the_current_where_it_is_narrower_than_the_coils(bench):
    b = bench(chain__preset=2, chain__dac=1)
    b["s5"] = 1e-3
    b.sample()
    assert b["mb1.i_x"] == -5.0
    assert b["current_limited"] == 1.0
    b["s5"] = 0.0
    b.sample()
    b.sample()
    assert b["current_limited"] == 0.0


def test_integral_does_not_wind_up_at_the_range_of_the_dac(bench):
    """An integral alone, 4.4 mA a sample: it stops at 5 A, and not at the 5.57 A of the coils, 130 samples later."""
    b = bench(chain__preset=2, chain__dac=1, mb1__k_integral_x=1e8, mb1__c_b_x=0.0, mb1__k_b_x=-BEARING_K_S)
    b["s5"] = 1e-4
    for _ in range(4000):
        b.sample()
    assert b["mb1.i_x"] == -5.0
    b["s5"] = -1e-4
    for _ in range(4):
        b.sample()
    assert b["mb1.i_x"] > -5.0
    assert b["current_limited"] == 0.0


def test_delay_is_one_sample(bench):
    prompt, late = bench(), bench(chain__preset=2, chain__delay=1)
    rng = np.random.default_rng(0)
    currents = []
    for x in 1e-5 * rng.normal(size=30):
        for b in (prompt, late):
            b["s5"] = x
            b.sample()
        currents.append((prompt["mb1.i_x"], late["mb1.i_x"]))
    now, then = np.array(currents).T
    np.testing.assert_array_equal(then[1:], now[:-1])


def test_delayed_controller_starts_with_the_current_of_its_initialisation(bench):
    b = bench(chain__preset=2, chain__delay=1)
    b["s5"] = 2e-5
    b.instance.initialise()
    initial = b["mb1.i_x"]
    b["s5"] = 0.0
    b.sample()
    assert b["mb1.i_x"] == initial == pytest.approx(-(1e6 + BEARING_K_S) * 2e-5 / BEARING_K_I, rel=1e-14)
    b.sample()
    assert b["mb1.i_x"] == 0.0


def test_filtered_and_delayed_start_off_centre_has_no_kick(bench):
    b = bench(chain__preset=2, chain__delay=1, chain__filter=1)
    b["s5"] = 2e-5
    b.instance.initialise()
    currents = []
    for _ in range(20):
        b.sample()
        currents.append(b["mb1.i_x"])
    np.testing.assert_allclose(currents, currents[0], rtol=1e-12)
