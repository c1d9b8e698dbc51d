"""Anti-aliasing filter: exact between samples, at rest at the start, its response."""

import math

import numpy as np
import pytest
from scipy.signal import lsim

from amb_analysis.linear.sampled_loop import filter_response
from signal_chain.lowpass import FILTER, coefficients, filter_sample, start_at_rest

H = 250e-6


def passed(signal, cutoff, h=H):
    memory = np.zeros(1, dtype=FILTER)[0]
    step = coefficients(cutoff, h)
    start_at_rest(memory, signal[0])
    return np.array([signal[0], *(filter_sample(memory, x, *step) for x in signal[1:])])


@pytest.mark.parametrize("cutoff", [0.5, 300.0, 2000.0, 1e5])
def test_samples_are_those_of_the_continuous_filter_for_a_polygon_input(cutoff):
    signal, omega = np.random.default_rng(1).normal(size=12), 2.0 * math.pi * cutoff
    _, exact, _ = lsim(([[-omega]], [[omega]], [[1.0]], [[0.0]]), signal, H * np.arange(12), signal[:1])
    np.testing.assert_allclose(passed(signal, cutoff), exact, rtol=1e-7, atol=1e-8)


@pytest.mark.parametrize("frequency", [5.0, 50.0, 500.0, 1500.0])
def test_vibration_is_attenuated_and_delayed_by_the_stated_response(frequency):
    omega = 2.0 * math.pi * frequency
    out = passed(np.cos(omega * H * np.arange(4000)), 700.0)[2000:]
    turn = np.exp(1j * omega * H * np.arange(2000, 4000))
    (re, im), *_ = np.linalg.lstsq(np.array([turn.real, -turn.imag]).T, out, rcond=None)
    assert complex(re, im) == pytest.approx(filter_response(700.0, omega, H), rel=1e-10)


def test_slow_vibration_sees_the_continuous_filter():
    """F = 1/(1 + j omega/omega_c), apart from the interpolation error of the polygon, (omega h)^2/12."""
    omega = 2.0 * math.pi * 35.0
    expected = 1.0 / (1.0 + 1j * 35.0 / 2000.0)
    assert filter_response(2000.0, omega, H) == pytest.approx(expected, rel=(omega * H) ** 2 / 10.0)
