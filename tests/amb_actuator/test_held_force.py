"""A mass under one axis, moved after the actuator over the same step: what the held force costs.

The reference is the whole system m x'' = K_s x + K_i i, i' = omega (I_c - i), by the matrix exponential. The mass makes
its own step exactly, so that the error is that of the coupling alone.
"""

import math

import numpy as np
import pytest
from scipy.linalg import expm

from amb_actuator.interface import DYNAMIC

MASS, SAMPLE, SAMPLES = 50.0, 250e-6, 80
K_S, K_I, OMEGA = 1.944e6, 544.0, 2 * math.pi * 1400.0


def demand(n):
    """Control current during sample n (A); steps small enough for the voltage limit."""
    return 0.1 * math.sin(0.3 * n)


def whole_system(amplifier):
    """Displacement (m) after the last sample; unknowns x, x', i and the constant command."""
    A = np.array([[0, 1, 0, 0], [K_S / MASS, 0, K_I / MASS, 0], [0, 0, -OMEGA, OMEGA], [0, 0, 0, 0]])
    if amplifier != DYNAMIC:
        A[1] = K_S / MASS, 0, 0, K_I / MASS
    z = np.zeros(4)
    for n in range(SAMPLES):
        z[3] = demand(n)
        z = expm(A * SAMPLE) @ z
    return z[0]


def coupled(make, amplifier, mean, parts, gradient=True):
    """The same with `parts` communication steps to a sample."""
    h = SAMPLE / parts
    actuator = make(force_law=1, amplifier=amplifier, mean_current=mean)
    x, v = 0.0, 0.0
    for n in range(SAMPLES * parts):
        actuator["mb1.i_x"], actuator["mb1.x"] = demand(n // parts), x
        actuator.step(n * h, h)
        force, k = actuator["mb1.f_x"], actuator["mb1.k_xx"] if gradient else 0.0
        a = np.array([[0, 1, 0], [k / MASS, 0, (force - k * actuator["mb1.x_ref"]) / MASS], [0, 0, 0]])
        x, v, _ = expm(a * h) @ (x, v, 1.0)
    assert actuator["mb1.voltage_limited_x"] == 0.0
    return x


def errors(make, amplifier, mean, gradient=True):
    exact = whole_system(amplifier)
    return [abs(coupled(make, amplifier, mean, parts, gradient) / exact - 1.0) for parts in (1, 2, 4)]


def test_ideal_amplifier_with_gradient_is_followed_exactly(bearing):
    assert max(errors(bearing, 0, 0)) < 1e-10


@pytest.mark.parametrize(
    ("amplifier", "gradient"), [(0, False), (DYNAMIC, True)], ids=["force", "current at the end of the step"]
)
def test_force_held_over_a_step_converges_with_first_order(bearing, amplifier, gradient):
    result = errors(bearing, amplifier, 0, gradient)
    assert result[0] > 1e-3
    assert math.log2(result[1] / result[2]) == pytest.approx(1.0, abs=0.15)


def test_mean_current_converges_with_second_order(bearing):
    result = errors(bearing, DYNAMIC, 1)
    assert result[0] < 0.02 * errors(bearing, DYNAMIC, 0)[0]
    assert math.log2(result[1] / result[2]) == pytest.approx(2.0, abs=0.15)


def test_mean_current_changes_nothing_for_an_ideal_amplifier(bearing):
    assert coupled(bearing, 0, 1, 1) == coupled(bearing, 0, 0, 1)
