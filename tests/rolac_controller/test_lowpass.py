"""Anti-aliasing filter: exact between samples, at rest at the start, its response."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from amb_cosim.design.sampled_loop import filter_response
from rolac_controller.lowpass import FILTER, coefficients, filter_sample, start_at_rest

H = 250e-6


def passed(signal, cutoff, h=H):
    memory = np.zeros(1, dtype=FILTER)[0]
    step = coefficients(cutoff, h)
    start_at_rest(memory, signal[0])
    return np.array([signal[0], *(filter_sample(memory, x, *step) for x in signal[1:])])


@pytest.mark.parametrize("cutoff", [0.5, 300.0, 2000.0, 1e5])
def test_samples_are_those_of_the_continuous_filter_for_a_polygon_input(cutoff):
    rng = np.random.default_rng(1)
    signal = rng.normal(size=12)
    times = H * np.arange(12)
    omega = 2.0 * math.pi * cutoff
    exact = [signal[0]]
    for k in range(11):
        ends = times[k : k + 2]
        solution = solve_ivp(
            lambda t, y, ends=ends, k=k: omega * (np.interp(t, ends, signal[k : k + 2]) - y),
            ends,
            [exact[-1]],
            rtol=1e-11,
            atol=1e-13,
            method="Radau" if cutoff > 1e4 else "RK45",
        )
        exact.append(solution.y[0, -1])
    np.testing.assert_allclose(passed(signal, cutoff), exact, rtol=1e-7, atol=1e-8)


def test_constant_passes_from_the_first_sample_on():
    np.testing.assert_allclose(passed(np.full(50, 3e-4), 2000.0), 3e-4, rtol=1e-14)


@pytest.mark.parametrize("frequency", [5.0, 50.0, 500.0, 1500.0])
def test_vibration_is_attenuated_and_delayed_by_the_stated_response(frequency):
    omega = 2.0 * math.pi * frequency
    out = passed(np.cos(omega * H * np.arange(4000)), 700.0)[2000:]
    turn = np.exp(1j * omega * H * np.arange(2000, 4000))
    (re, im), *_ = np.linalg.lstsq(np.array([turn.real, -turn.imag]).T, out, rcond=None)
    assert complex(re, im) == pytest.approx(filter_response(700.0, omega, H), rel=1e-10)


def test_slow_vibration_sees_the_continuous_filter():
    """F = 1/(1 + j omega/omega_c), apart from what the polygon costs, (omega h)^2/12."""
    omega = 2.0 * math.pi * 35.0
    expected = 1.0 / (1.0 + 1j * 35.0 / 2000.0)
    assert filter_response(2000.0, omega, H) == pytest.approx(expected, rel=(omega * H) ** 2 / 10.0)
