"""The sampled axial loop against python-control, and its signs."""

import math

import control
import numpy as np
import pytest

from amb_analysis.linear.axial_loop import AxialLoop, AxialPlant
from amb_analysis.linear.components import zoh
from amb_cosim.controllers.laws import Law, static
from tests.support.messages import raises_naming
from thrust_bearings.rational_lag import NO_LAG, rational_lag

T = 50e-6
MASS, K_I, K_S, OMEGA_B = 6.0, 150.0, 1e6, 2.0 * math.pi * 2000.0
LAG = rational_lag(2.0 * math.pi * 300.0, (2.0 * math.pi * 0.1, 2.0 * math.pi / T), 1e-2)
NOTHING = static(np.zeros((1, 1)))  # a controller
PD = (-2.5e4, -30.0, 2.0 * math.pi * 3000.0)


def pd(kp, kd, roll_off):
    """kp + kd s/(1 + s/roll_off), by Tustin's rule, as python-control has it."""
    return control.c2d(control.tf([kp / roll_off + kd, kp], [1.0 / roll_off, 1.0]), T, "tustin")


def loop(delay=0.0, lag=LAG, gains=PD, k_s=K_S):
    K = control.ss(pd(*gains))
    return AxialLoop(AxialPlant(MASS, K_I, k_s, OMEGA_B, lag), Law(K.A, K.B, K.C, K.D), T, delay)


def transfer_of_plant(lag, k_s=K_S):
    """Rotor and lag as transfer functions: G K_i/(m s^2 - G K_s), G = num/den, times the amplifier."""
    num, den = np.zeros(len(lag.poles) + 1), np.poly(-lag.poles) if len(lag.poles) else np.ones(1)
    num = num + lag.feedthrough * den
    for p, c in zip(lag.poles, lag.weights, strict=True):
        rest = np.poly(-lag.poles[lag.poles != p]) if len(lag.poles) > 1 else np.ones(1)
        num = np.polyadd(num, c * p * rest)
    rotor = control.tf(K_I * num, np.polysub(MASS * np.polymul([1.0, 0.0, 0.0], den), k_s * num))
    return rotor * control.tf([OMEGA_B], [1.0, OMEGA_B])


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_loop_without_lag_agrees_with_python_control(delay):
    """Frequency and damping of the closed loop from transfer functions: hold, z^-delay, Tustin."""
    plant = control.c2d(transfer_of_plant(NO_LAG), T, "zoh")
    waiting = control.tf([1.0], np.eye(1, delay + 1)[0], T)
    closed = control.feedback(1, plant * waiting * pd(*PD), sign=1)
    theirs = np.log(np.array([z for z in closed.poles() if z.imag > 0.0])) / T
    ours = loop(delay, NO_LAG).vibrations
    for s in ours:
        near = theirs[np.abs(theirs - s).argmin()]
        assert abs(s) == pytest.approx(abs(near), rel=1e-6)
        assert -s.real / abs(s) == pytest.approx(-near.real / abs(near), rel=1e-6)
    assert len(ours) == len(theirs)


def test_loop_with_lag_agrees_with_python_control():
    """With state spaces of lag, rotor and amplifier that python-control connects."""
    A, B, C, D = LAG.state_space()
    lag = control.ss(A, B, C, D, inputs="drive", outputs="force")
    rotor = control.ss([[0, 1], [0, 0]], [[0], [1 / MASS]], [[1, 0]], [[0]], inputs="force", outputs="z")
    amplifier = control.ss(control.tf([OMEGA_B], [1.0, OMEGA_B]), inputs="demand", outputs="current")
    pull = control.ss([], [], [], [[K_I, K_S]], inputs=["current", "z"], outputs="drive")
    plant = control.interconnect([lag, rotor, amplifier, pull], inputs=["demand"], outputs=["z"])
    closed = control.feedback(control.c2d(plant, T, "zoh"), control.ss(pd(*PD)), sign=1)
    theirs = np.log(np.array([z for z in closed.poles() if z.imag > 1e-9])) / T
    (ours,) = loop().vibrations
    near = theirs[np.abs(theirs - ours).argmin()]
    assert abs(ours) == pytest.approx(abs(near), rel=1e-6)
    assert -ours.real / abs(ours) == pytest.approx(-near.real / abs(near), rel=1e-6)
    frequencies = np.geomspace(1.0, 9e3, 40)
    L = closed.dt and control.c2d(plant, T, "zoh") * control.ss(pd(*PD))
    S = control.feedback(control.ss([], [], [], [[1.0]], T), L, sign=1)
    theirs = [abs(S(np.exp(2j * np.pi * hz * T))) for hz in frequencies]
    np.testing.assert_allclose(np.abs(loop().sensitivity(frequencies)), theirs, rtol=1e-6)


@pytest.mark.parametrize("delay", [0.25, 1.0, 2.6])
def test_fraction_of_a_sample_is_a_hold_of_finer_steps(delay):
    """A delay of d samples is a demand that changes d T later: simulated in twentieths of a sample."""
    fine = 20
    plant = AxialPlant(MASS, K_I, K_S, OMEGA_B).law
    A, B = zoh(plant.A, plant.B, T / fine)
    law, x = loop(delay, NO_LAG), np.array([1e-5, 0.0, 0.0])
    K_A, K_B, K_C, K_D = (getattr(law.controller, name) for name in "ABCD")
    k, demands = np.zeros(len(K_A)), [0.0] * 200
    shift = round(delay * fine)
    ours = np.zeros(len(law.whole.A))
    ours[:3] = x
    for step in range(100 * fine):
        if step % fine == 0:
            np.testing.assert_allclose(ours[:3], x, rtol=1e-8, atol=1e-18)
            u = float((K_C @ k)[0] + K_D[0, 0] * x[0])
            k = K_A @ k + K_B[:, 0] * x[0]
            demands.append(u)
            ours = law.whole.A @ ours
        newest = (step - shift) // fine  # the newest demand that acts
        x = A @ x + B[:, 0] * demands[200 + newest]


def test_uncontrolled_bearing_diverges_faster_with_more_k_s():
    for k_s in (1e5, 1e6):
        free = AxialLoop(AxialPlant(MASS, K_I, k_s, OMEGA_B), NOTHING, T)
        growth = np.log(np.abs(free.poles).max()) / T
        assert growth == pytest.approx(math.sqrt(k_s / MASS), rel=1e-9)


def test_feedback_of_the_wrong_sign_is_unstable():
    assert np.abs(loop().poles).max() < 1.0
    assert np.abs(loop(gains=(-PD[0], -PD[1], PD[2])).poles).max() > 1.0


def test_slow_loop_has_the_stiffness_and_damping_of_its_gains():
    """m s^2 + (K_i |kd| - K_i |kp| tau) s + K_i |kp| - K_s = 0, with the delay tau of amplifier and hold."""
    (s,) = loop(lag=NO_LAG, gains=(-1.02e4, -3.0, 2e5), k_s=1.5e6).vibrations
    tau = 1.0 / OMEGA_B + 0.5 * T
    exact = np.roots([MASS, K_I * 3.0 - K_I * 1.02e4 * tau, K_I * 1.02e4 - 1.5e6])
    (near,) = exact[exact.imag > 0.0]
    assert s.imag == pytest.approx(near.imag, rel=0.02)
    assert s.real == pytest.approx(near.real, rel=0.02)


def test_eddy_currents_and_delay_reduce_damping_and_margin():
    frequencies = np.geomspace(1.0, 9e3, 500)
    peaks = [np.abs(of.sensitivity(frequencies)).max() for of in (loop(lag=NO_LAG), loop(), loop(1.5))]
    assert peaks == sorted(peaks)
    damping = [-of.vibrations[0].real for of in (loop(lag=NO_LAG), loop(), loop(1.5))]
    assert damping == sorted(damping, reverse=True)


@pytest.mark.parametrize(
    ("change", "facts"),
    [({"delay": -1.0}, ("delay", "-1 samples", ">= 0 samples")), ({"k_s": 0.0}, ("k_s", "0 N/m", "> 0 N/m"))],
)
def test_an_invalid_loop_is_refused(change, facts):
    with raises_naming(ValueError, *facts):
        loop(**change)


def test_a_controller_of_several_signals_is_refused():
    plant = AxialPlant(MASS, K_I, K_S, OMEGA_B)
    two = static(np.ones((1, 2)))
    with raises_naming(ValueError, "controller", "(1, 2)"):
        AxialLoop(plant, two, T)
