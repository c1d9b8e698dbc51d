"""PID: signs, equivalence with a spring and a damper, limits, start, setpoint, DAC levels."""

import numpy as np
import pytest
from rig import LOOP, SENSOR_NAMES, given_parameters
from scipy.linalg import expm

from rolac_controller.parameters import BEARING_K_I, BEARING_K_S
from rolac_controller.pid import response

AXES = [(axis.bearing, axis.direction, axis.sensor) for axis in LOOP.axes]
MASS = 50.0  # kg, half the rotor


def levitate(bench, h, duration, x0=0.0, load=0.0, setpoint=0.0, **parameters):
    """Displacements of a mass in one bearing axis at each sample; its motion between them is exact."""
    b = bench(sample_time=h, mb1__set_x=setpoint, **parameters)
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


@pytest.mark.parametrize("sensor", SENSOR_NAMES)
def test_positive_displacement_gives_negative_current_on_its_axis_alone(bench, sensor):
    """Sensors at the rotor's ends do not reach the PID."""
    b = bench()
    b[sensor] = 1e-5
    b.sample()
    for other, a, local in AXES:
        expected = -(1e6 + BEARING_K_S) * 1e-5 / BEARING_K_I if sensor == local else 0.0
        assert b[f"{other}.i_{a}"] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("tau", [0.0, 2e-3])
def test_derivative_of_a_ramp_settles_with_its_filter_time_constant(bench, tau):
    slope, h = 1e-3, 250e-6
    b = bench(derivative_time=tau, mb1__k_b_x=-BEARING_K_S)  # no proportional part
    for n in range(200):
        b["s5"] = slope * n * h
        b.sample()
        expected = slope * (1.0 - (tau / (tau + h)) ** n)
        assert -b["mb1.i_x"] * BEARING_K_I / 5000.0 == pytest.approx(expected, rel=1e-9, abs=1e-15)


INTEGRAL = {"mb1__k_integral_x": 2e7}
DIRECT = {"pid__direct": 1, "mb1__k_p_x": 1e6 + BEARING_K_S}


@pytest.mark.parametrize(
    ("parameters", "load", "setpoint", "rests_at"),
    [
        ({}, 100.0, 0.0, pytest.approx(100.0 / 1e6, rel=1e-8)),
        ({}, 0.0, 1e-4, pytest.approx(1e-4, rel=1e-8)),
        (INTEGRAL, 100.0, 0.0, pytest.approx(0.0, abs=1e-10)),
        (INTEGRAL, 100.0, -5e-5, pytest.approx(-5e-5, abs=1e-10)),
        (INTEGRAL | DIRECT, 0.0, 1e-4, pytest.approx(1e-4, rel=1e-5)),
    ],
    ids=["K_b", "setpoint", "integral", "integral and setpoint", "direct gains"],
)
def test_closed_bearing_deflects_by_load_over_net_stiffness(bench, parameters, load, setpoint, rests_at):
    """The compensation of K_s, or the integral, holds a rotor off its centre."""
    x = levitate(bench, 250e-6, 2.0 if parameters else 0.6, load=load, setpoint=setpoint, **parameters)
    assert x[-1] == rests_at
    assert np.ptp(x) > 5e-5


def test_closed_bearing_moves_like_a_spring_and_a_damper(bench):
    def error(h):
        x = levitate(bench, h, 0.1, x0=1e-4)
        t = h * np.arange(len(x))
        root = np.roots([MASS, 5000.0, 1e6])[0]
        exact = 1e-4 * np.exp(root.real * t) * (np.cos(root.imag * t) - root.real / root.imag * np.sin(root.imag * t))
        return np.abs(x - exact).max() / 1e-4

    assert error(1e-5) < 5e-3
    assert error(2e-5) / error(1e-5) == pytest.approx(2.0, rel=0.1)  # sampling costs first order in h


@pytest.mark.parametrize(
    "chain", [{}, {"chain__preset": 2, "chain__delay": 1}, {"chain__preset": 2, "chain__delay": 1, "chain__filter": 1}]
)
def test_start_off_centre_has_no_kick(bench, chain):
    b = bench(s5=2e-5, **chain)
    proportional = -(1e6 + BEARING_K_S) * 2e-5 / BEARING_K_I
    assert b["mb1.i_x"] == pytest.approx(proportional, rel=1e-14)
    for _ in range(20):
        b.sample()
        assert b["mb1.i_x"] == pytest.approx(proportional, rel=1e-12)


def test_change_of_the_integral_gain_is_bumpless(bench):
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


@pytest.mark.parametrize(("bearing", "axis", "_"), AXES)
def test_step_of_the_setpoint_of_an_axis_has_no_derivative_kick(bench, bearing, axis, _):
    b = bench(mb1__c_b_x=1e5)
    b.sample()
    b[f"{bearing}.set_{axis}"] = 1e-5
    b.sample()
    for other, a, _ in AXES:
        expected = 1e6 * 1e-5 / BEARING_K_I if (other, a) == (bearing, axis) else 0.0
        assert b[f"{other}.i_{a}"] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("integral", [0.0, 3e6])
@pytest.mark.parametrize("tau", [0.0, 2e-3])
@pytest.mark.parametrize("frequency", [5.0, 35.0, 400.0])
def test_stated_response_is_that_to_a_vibration(bench, frequency, tau, integral):
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


@pytest.mark.parametrize(("chain", "limit"), [({}, -5.57), ({"chain__preset": 2, "chain__dac": 1}, -5.0)])
def test_integral_does_not_wind_up_at_the_narrower_limit(bench, chain, limit):
    """An integral alone, 4.4 mA a sample: it stops at 5 A of the DAC, and not at the 5.57 A of the coils."""
    b = bench(**chain, mb1__k_integral_x=1e8, mb1__c_b_x=0.0, mb1__k_b_x=-BEARING_K_S)
    b["s5"] = 1e-4
    for _ in range(4000):
        b.sample()
    assert (b["mb1.i_x"], b["current_limited"]) == (limit, 1.0)
    b["s5"] = -1e-4
    for _ in range(4):
        b.sample()
    assert b["mb1.i_x"] > limit
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
