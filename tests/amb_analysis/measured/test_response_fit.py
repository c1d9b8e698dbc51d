"""Intervals of parameters from responses with noise in proportion, with a noise floor, and with both."""

from __future__ import annotations

import numpy as np
import pytest

from amb_analysis.measured.least_squares import FreeParameter
from amb_analysis.measured.records import Channel, FrequencyResponse
from amb_analysis.measured.response_fit import fit_responses
from tests.support.messages import assert_names

F = np.linspace(10.0, 1000.0, 300)
S = 2j * np.pi * F
SHAPES = ((1.0, 1.6, 0.7), (1.0, -0.9, -1.3))  # of rigid motion and two modes, at two places
MODES = ((303.0, -0.142), (775.0, -0.127))  # frequency (Hz) with a mass of 4 kg, and its power of the mass
FREE = (FreeParameter("mass", 3.0, 6.0), FreeParameter("damping", 0.001, 0.02))
TRUE, START = np.array([4.2, 0.004]), (4.0, 0.006)
AVERAGES = 10


def model(p, suspension=0.0):
    """Accelerances at two places of a rotor whose disc has the mass p_0, with the damping ratio p_1.

    A suspension is the natural frequency (Hz) of the rigid rotor on its soft suspension; at 0 the rotor is free.
    """
    result, omega_0 = [], 2 * np.pi * suspension
    for rigid, *shape in SHAPES:
        H = rigid / 8.0 * S**2 / (S**2 + 0.1j * omega_0 * S.imag + omega_0**2)
        for share, (hertz, power) in zip(shape, MODES, strict=True):
            omega = np.hypot(2 * np.pi * hertz * (p[0] / 4.0) ** power, omega_0)
            H += S**2 * share * 0.32 / p[0] / (S**2 + 2 * p[1] * omega * S + omega**2)
        result.append(H)
    return result


EXACT = model(TRUE)


def measured(seed, floor, proportional, coherence=False, correlation=0.0, exact=EXACT):
    rng, result = np.random.default_rng(seed), []
    for k, H in enumerate(exact):
        v = (floor * np.median(np.abs(H))) ** 2 + (proportional * np.abs(H)) ** 2
        unit = (rng.standard_normal(len(F)) + 1j * rng.standard_normal(len(F))) / np.sqrt(2)
        for n in range(1, len(F)):
            unit[n] = correlation * unit[n - 1] + np.sqrt(1 - correlation**2) * unit[n]
        gamma = np.abs(H) ** 2 / (np.abs(H) ** 2 + AVERAGES * v)
        gamma = np.clip(gamma * (1 + 0.05 * rng.standard_normal(len(F))), 0.01, 1.0) if coherence else None
        place, force = Channel(f"p{k}.x", "m/s2"), Channel("fan.f_x", "N")
        result.append(FrequencyResponse(place, force, F, H + np.sqrt(v) * unit, gamma))
    return result


def held(seeds, *noise, **options):
    """Return how many intervals of each parameter hold it."""
    count = np.zeros(2)
    for seed in seeds:
        fit, _ = fit_responses(model, measured(seed, *noise, **options), FREE, START)
        count += [p.lower <= true <= p.upper for p, true in zip(fit.parameters.values(), TRUE, strict=True)]
    return count


NOISES = {"proportional": (0.0, 0.02), "floor": (0.01, 0.0), "mixed": (0.05, 0.02), "strong": (0.2, 0.05)}


@pytest.mark.slow
@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("coherence", [False, True])
def test_intervals_hold_the_parameters_in_95_of_100_draws(noise, coherence):
    """With a noise floor, 24 of 30 held the mass and 11 the damping."""
    count = held(range(100), *NOISES[noise], coherence=coherence)
    print(noise, coherence, count)
    assert (count >= 90).all()
    assert (count <= 99).all()


@pytest.mark.parametrize("noise", ["floor", "mixed"])
def test_intervals_hold_the_parameters_with_a_noise_floor(noise):
    assert (held(range(20), *NOISES[noise]) >= 16).all()


@pytest.mark.slow
def test_intervals_allow_for_noise_that_neighbouring_lines_share():
    assert (held(range(100), 0.05, 0.02, correlation=0.5) >= 88).all()


@pytest.mark.parametrize("start", [(3.3, 0.002), (5.5, 0.015)])
def test_a_noise_floor_does_not_shift_the_fit(start):
    """Logarithms of a response below the noise are those of the noise."""
    curves = measured(1, 0.3, 0.0)
    fit, _ = fit_responses(model, curves, FREE, start)
    assert [p.value for p in fit.parameters.values()] == pytest.approx(TRUE, rel=1e-2)


def test_exact_responses_give_exact_parameters():
    fit, warnings = fit_responses(model, measured(0, 0.0, 0.0), FREE, START)
    assert [p.value for p in fit.parameters.values()] == pytest.approx(TRUE, rel=1e-6)
    assert fit.rms_after < 1e-6 < fit.rms_before
    assert warnings == ()


def test_residuals_that_are_not_noise_are_reported():
    """A measurement of other modal shares, which no mass and damping gives."""
    curves = measured(0, 0.0, 0.002)
    assert fit_responses(model, curves, FREE, START)[1] == ()
    lacking = [
        FrequencyResponse(c.output, c.input, F, c.values + 0.3 * np.median(np.abs(c.values)) * np.sin(F / 150.0))
        for c in curves
    ]
    (warning,) = fit_responses(model, lacking, FREE, START)[1]
    assert_names(warning, "does not explain the data", "correlation", "intervals")


@pytest.mark.parametrize("noise", [(0.0, 0.01), (0.01, 0.0)])
def test_a_suspension_that_the_model_lacks_is_reported(noise):
    """It changes a few lines, whose misfit is no correlation of all neighbours, and shifts the natural frequencies."""
    (warning,) = fit_responses(model, measured(0, *noise, exact=model(TRUE, suspension=4.0)), FREE, START)[1]
    assert_names(warning, "does not explain the data", "from 10 to", "Hz", "p1.x/fan.f_x", "intervals")
    assert "correlation" not in warning


def test_damping_that_the_model_lacks_is_reported():
    curves = measured(0, 0.0, 0.01, exact=model((4.2, 0.0044)))
    (warning,) = fit_responses(lambda p: model((p[0], 0.004)), curves, FREE[:1], START[:1])[1]
    assert_names(warning, "does not explain the data", "Hz", "intervals")
    assert fit_responses(lambda p: model((p[0], 0.0044)), curves, FREE[:1], START[:1])[1] == ()
