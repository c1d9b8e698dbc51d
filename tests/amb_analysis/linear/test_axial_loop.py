"""The sampled axial loop against python-control, and its signs."""

import math
from types import SimpleNamespace

import control
import numpy as np
import pytest

from amb_actuator.eddy_currents import LAG
from amb_actuator.interface import DYNAMIC, interface_of
from amb_analysis.linear.axial_loop import AxialControl, AxialLoop, AxialPlant
from amb_analysis.linear.components import frequency_response, zoh
from amb_analysis.linear.rotor_and_magnets import actuator_component, bearing_slopes
from amb_cosim.controllers.laws import Law, static
from tests.support.messages import raises_naming

T = 50e-6
MASS, K_I, K_S, OMEGA_B = 6.0, 150.0, 1e6, 2.0 * math.pi * 2000.0
CORNER = 2.0 * math.pi * 300.0
NOTHING = static(np.zeros((1, 1)))  # a controller
PD = (-2.5e4, -30.0, 2.0 * math.pi * 3000.0)


def pd(kp, kd, roll_off):
    """kp + kd s/(1 + s/roll_off), by Tustin's rule, as python-control has it."""
    return control.c2d(control.tf([kp / roll_off + kd, kp], [1.0 / roll_off, 1.0]), T, "tustin")


def loop(delay=0.0, corner=CORNER, gains=PD, k_s=K_S):
    K = control.ss(pd(*gains))
    return AxialLoop(AxialPlant(MASS, K_I, k_s, OMEGA_B, corner), Law(K.A, K.B, K.C, K.D), T, delay)


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_loop_without_lag_agrees_with_python_control(delay):
    """Frequency and damping of the closed loop from transfer functions: hold, z^-delay, Tustin."""
    rotor = control.tf([K_I], [MASS, 0.0, -K_S]) * control.tf([OMEGA_B], [1.0, OMEGA_B])
    plant = control.c2d(rotor, T, "zoh")
    waiting = control.tf([1.0], np.eye(1, delay + 1)[0], T)
    closed = control.feedback(1, plant * waiting * pd(*PD), sign=1)
    theirs = np.log(np.array([z for z in closed.poles() if z.imag > 0.0])) / T
    ours = loop(delay, None).vibrations
    for s in ours:
        near = theirs[np.abs(theirs - s).argmin()]
        assert abs(s) == pytest.approx(abs(near), rel=1e-6)
        assert -s.real / abs(s) == pytest.approx(-near.real / abs(near), rel=1e-6)
    assert len(ours) == len(theirs)


def test_poles_that_vanish_within_a_sample_are_no_vibrations():
    """Rounding may give fast lags, with |z| of 1e-17, an imaginary part: their damping ratio is above 0.996."""
    with_lag = loop()
    rounding = 1e-17 * np.exp([1.0j, -1.0j, 3.1j, -3.1j])
    replaced = SimpleNamespace(poles=np.append(with_lag.poles, rounding), sample_time=with_lag.sample_time)
    np.testing.assert_allclose(AxialLoop.vibrations.fget(replaced), with_lag.vibrations, rtol=1e-12)


def test_loop_with_lag_agrees_with_python_control():
    """With state spaces of lag, rotor and amplifier that python-control connects."""
    poles = CORNER * np.array(LAG.poles)
    lag = control.ss(np.diag(-poles), poles[:, None], np.array([LAG.weights]), 0.0, inputs="drive", outputs="force")
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
    law, x = loop(delay, None), np.array([1e-5, 0.0, 0.0])
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


@pytest.mark.parametrize(
    ("make", "facts"),
    [
        (lambda: loop(-1.0), ("delay", "-1 samples", ">= 0 samples")),
        (lambda: loop(k_s=0.0), ("k_s", "0 N/m", "> 0 N/m")),
        (
            lambda: AxialLoop(AxialPlant(MASS, K_I, K_S, OMEGA_B), static(np.ones((1, 2))), T),
            ("controller", "(1, 2)"),
        ),
    ],
)
def test_an_invalid_loop_is_refused(make, facts):
    with raises_naming(ValueError, *facts):
        make()


def test_magnets_with_eddy_currents_have_the_lag_of_the_axial_loop():
    """Force over demand and displacement of the linear actuator: K_i B(s) G_n(s) and K_s G_n(s)."""
    interface = interface_of(("b",), "thrust")
    parameters = {v.name: v.start for v in interface.of("parameter")}
    parameters |= {"amplifier": float(DYNAMIC), "thrust.eddy_current_corner": CORNER / (2.0 * math.pi)}
    layout = {"bearings": ["b"], "thrust": "thrust"}
    part = actuator_component("magnets", layout, parameters)
    k_s, k_i = bearing_slopes("thrust", "z", parameters)
    magnets = part.selected(["magnets.thrust.i_z", "magnets.thrust.z"], ["magnets.thrust.f_z", "magnets.b.f_x"])
    poles, weights = CORNER * np.array(LAG.poles), np.array(LAG.weights)
    for s in 1j * np.geomspace(1.0, 1e5, 7):
        lag, omega_b = np.sum(weights * poles / (s + poles)), 2.0 * math.pi * parameters["thrust.bandwidth_z"]
        of_current, of_displacement = frequency_response(magnets.law, s)[0]
        assert of_current == pytest.approx(k_i * lag * omega_b / (s + omega_b), rel=1e-9)
        assert of_displacement == pytest.approx(k_s * lag, rel=1e-9)
        np.testing.assert_array_equal(frequency_response(magnets.law, s)[1], 0.0)


def test_a_delay_within_the_law_counts_as_a_delay():
    """A scenario's controller has its delay as a state of its law, and a thrust bearing's own file has it apart."""
    A, B, C, one, none = (np.array([[x]]) for x in (0.0, 1.0, 1.0, 1.0, 0.0))
    assert AxialControl(Law(A, B, C, none), 5e-5, 0.0).reacts_after == 1.0
    assert AxialControl(Law(A, B, C, one), 5e-5, 1.5).reacts_after == 1.5
