"""Intervals of parameters from noisy responses, and the warning that a model does not explain its data.

Noise is in proportion to the response, in its amplitude, its phase or both, or a floor, or that of averaged spectra.
"""

from __future__ import annotations

import numpy as np
import pytest

from amb_analysis.measured.least_squares import FreeParameter
from amb_analysis.measured.records import Channel, FrequencyResponse
from amb_analysis.measured.response_fit import fit_responses
from amb_analysis.measured.scatter import scatter_of
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


def scattered(seed, amplitude=0.0, phase=0.0, floor=0.0, averages=0, exact=EXACT):
    """Return responses with relative scatter of amplitude and phase, and a floor in medians of the first response.

    With a number of averages, a hammer whose force falls with frequency gives spectra with the floor in its output.
    """
    rng, result, size = np.random.default_rng(seed), [], floor * np.median(np.abs(exact[0]))
    for k, H in enumerate(exact):
        shape = (max(averages, 1), len(F))
        noise = size * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))
        a, b = rng.standard_normal((2, len(F)))
        blow = np.exp(-F / 400.0) if averages else np.ones(len(F))
        y = H * (1.0 + amplitude * a) * np.exp(1j * phase * b) * blow + noise
        mean, power = y.mean(axis=0), np.mean(np.abs(y) ** 2, axis=0)
        coherence = np.abs(mean) ** 2 / power if averages else None
        result.append(FrequencyResponse(Channel(f"p{k}.x", "m/s2"), Channel("fan.f_x", "N"), F, mean / blow, coherence))
    return result


SCATTER = {
    "amplitude": {"amplitude": 0.02},
    "phase": {"phase": 0.02},
    "both": {"amplitude": 0.02, "phase": 0.005},
    "equal": {"amplitude": 0.02, "phase": 0.02},
    "amplitude and floor": {"amplitude": 0.02, "floor": 0.02},
    "floor": {"floor": 0.02},
    "three averages": {"floor": 0.05, "averages": 3},
    "ten averages": {"floor": 0.05, "averages": 10},
}


@pytest.mark.parametrize("noise", SCATTER)
def test_a_right_model_is_not_reported(noise):
    """With scatter of amplitude alone, 28 of 60 draws were reported, with three averages 59."""
    for seed in range(8):
        assert fit_responses(model, scattered(seed, **SCATTER[noise]), FREE, START)[1] == ()


@pytest.mark.slow
@pytest.mark.parametrize("noise", SCATTER)
def test_a_right_model_is_reported_in_one_draw_of_a_hundred_at_most(noise):
    """Of 200 draws with a chance of 0.01 each, more than 6 are reported with a probability of 0.4 %."""
    count, alarms = np.zeros(2), 0
    for seed in range(200):
        fit, warnings = fit_responses(model, scattered(seed, **SCATTER[noise]), FREE, START)
        count += [p.lower <= true <= p.upper for p, true in zip(fit.parameters.values(), TRUE, strict=True)]
        alarms += len(warnings)
    print(noise, alarms, count)
    assert alarms <= 6
    assert (count >= 180).all()


@pytest.mark.parametrize("noise", SCATTER)
@pytest.mark.parametrize("lacking", ["stiffness", "mode", "suspension"])
def test_a_wrong_model_is_reported_with_any_noise(noise, lacking):
    """The stiffness of a mode 2 % off, a mode that the model lacks, and a suspension that it lacks."""
    exact = model(TRUE, suspension=9.0 if lacking == "suspension" else 0.0)
    if lacking == "mode":
        omega = 2 * np.pi * 550.0
        exact = [H + 0.05 * S**2 / (S**2 + 0.02 * omega * S + omega**2) for H in exact]

    def softer(p):
        pairs = zip(model(p), second_mode(p, 1.0), second_mode(p, 0.99), strict=True)
        return [H - right + wrong for H, right, wrong in pairs]

    def second_mode(p, factor):
        omega = 2 * np.pi * factor * MODES[1][0] * (p[0] / 4.0) ** MODES[1][1]
        return [S**2 * shape[2] * 0.32 / p[0] / (S**2 + 2 * p[1] * omega * S + omega**2) for shape in SHAPES]

    curves = scattered(0, exact=exact, **SCATTER[noise])
    (warning,) = fit_responses(softer if lacking == "stiffness" else model, curves, FREE, START)[1]
    assert_names(warning, "does not explain the data", "intervals")


def test_scatter_of_amplitude_and_phase_is_told_apart():
    """v = 2 s^2 |H|^2 with the standard deviation s of each part."""
    curves = scattered(0, amplitude=0.02, phase=0.005)
    for H, curve in zip(EXACT, curves, strict=True):
        scatter, _ = scatter_of(H, curve, H - curve.values, np.zeros(2 * len(F)))
        along, across = np.sqrt(0.5 * scatter.variances.reshape(2, -1)) / np.abs(H)
        assert along[np.abs(H) > 0.3] == pytest.approx(0.02, rel=0.15)
        assert across[np.abs(H) > 0.3] == pytest.approx(0.005, rel=0.15)


@pytest.mark.parametrize("averages", [3, 5, 10])
def test_the_coherence_of_few_averages_states_how_uncertain_it_is(averages):
    """The sum of N - 1 squares of complex noise has the relative variance 1/(N - 1)."""
    for H, curve in zip(EXACT, scattered(0, floor=0.05, averages=averages), strict=True):
        scatter, _ = scatter_of(H, curve, H - curve.values, np.zeros(2 * len(F)))
        assert scatter.uncertainty == pytest.approx(1.0 / (averages - 1), rel=0.3)
