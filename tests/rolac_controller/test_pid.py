"""PID: signs, equivalence with a spring and a damper, limits, start."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from rolac_controller.controller import BEARING_K_I, BEARING_K_S

AXES = [("mb1", "x", "s5"), ("mb1", "y", "s6"), ("mb2", "x", "s3"), ("mb2", "y", "s4")]
MASS = 50.0  # kg, half the rotor


def levitate(bench, h, duration, x0=0.0, load=0.0):
    """Displacements of a mass in one bearing axis at each sample; its motion between them is exact."""
    b = bench(sample_time=h)
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
def test_positive_displacement_gives_negative_current_on_its_own_axis_alone(bench, bearing, axis, sensor):
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


def test_current_leaves_the_limit_at_the_first_sample_after_the_sign_changes(bench):
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
