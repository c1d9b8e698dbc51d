"""A reversed force or sensor, another time convention, and damping that lines do not resolve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.signal

from amb_analysis.measured.convention import contradictions, phase_offset
from amb_analysis.measured.deviation import mode_deviations
from amb_analysis.measured.estimates import estimate
from amb_analysis.measured.modal_fit import fitted_modes, is_conjugate, peak_frequencies
from amb_analysis.measured.records import Channel, FrequencyResponse, TimeRecord
from amb_analysis.studies.frequency_responses import laid_over
from tests.support.messages import assert_names

F = np.arange(2.0, 300.0, 0.5)
FORCE = Channel("fan.f_x", "N")
W = 2j * np.pi * F


def response(mass=1.0, zeta=0.004, name="fan.x"):
    """Accelerance of a free mass with two modes."""
    poles = (W**2 + 2 * zeta * w * W + w**2 for w in (2 * np.pi * f / np.sqrt(mass) for f in (62.0, 151.0)))
    values = W**2 * (1 / W**2 + sum(share / pole for share, pole in zip((1.0, 0.4), poles, strict=True))) / mass
    return FrequencyResponse(Channel(name, "m/s2"), FORCE, F, values)


def with_noise(curve, noise, seed=0):
    rng = np.random.default_rng(seed)
    spread = noise * np.median(np.abs(curve.values))
    return replace(
        curve, values=curve.values + spread * (rng.standard_normal(len(F)) + 1j * rng.standard_normal(len(F)))
    )


@pytest.mark.parametrize("mass", [0.9, 1.0, 1.1])
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_a_reversed_force_or_sensor_is_named(mass, noise):
    """FRAC, MAC and levels are those of a perfect model."""
    measured, computed = with_noise(response(), noise), response(mass).values
    turned = replace(measured, values=-measured.values)
    assert abs(phase_offset(measured.values, computed)) < 10.0
    assert abs(phase_offset(turned.values, computed)) > 170.0
    assert contradictions([measured], [computed]) == ()
    (sentence,) = contradictions([turned], [computed])
    assert_names(sentence, measured.name, "180 degrees", "reversed")


def test_only_the_reversed_one_of_two_sensors_is_named():
    first, second = response(), response(name="disc.x")
    turned = replace(second, values=-second.values)
    (sentence,) = contradictions([first, turned], [first.values, second.values])
    assert_names(sentence, second.name)
    assert first.name not in sentence


@pytest.mark.parametrize("sign", [1.0, -1.0, np.exp(1j * np.pi)])
def test_amplitudes_without_a_phase_are_named(sign):
    measured = response()
    amplitudes = replace(measured, values=sign * np.abs(measured.values) + 0j)
    (sentence,) = contradictions([amplitudes], [measured.values])
    assert_names(sentence, measured.name, "no phase", "complex")


def test_an_undamped_model_has_real_responses_too():
    measured = response(mass=1.01, zeta=0.0)
    assert contradictions([measured], [measured.values]) == ()


def test_a_velocity_that_is_read_as_an_acceleration_is_off_by_90_degrees():
    measured = response()
    (sentence,) = contradictions([replace(measured, values=measured.values / W)], [measured.values])
    assert_names(sentence, "90 degrees", "velocity")


@pytest.mark.parametrize("noise", [0.0, 0.1])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_other_time_convention_is_named(noise, sign):
    """The text was that no peak rises by 6 dB."""
    measured = with_noise(response(), noise)
    turned = replace(measured, values=sign * measured.values.conj())
    assert not is_conjugate([measured])
    assert is_conjugate([turned])
    result = laid_over("fan", "free", 0.0, [turned], [response().values])
    assert_names(str(result), measured.name, "exp(-j omega t)")
    assert "6 dB" not in str(result)


@pytest.mark.parametrize("step", [7.0, 20.0])
def test_the_other_time_convention_shows_on_coarse_lines_beside_the_model(step):
    curves = [response(mass, 0.01).at(np.arange(0, len(F), int(step / 0.5))) for mass in (1.0, 1.02)]
    measured, computed = curves
    turned = replace(measured, values=measured.values.conj())
    assert not is_conjugate([turned])
    (sentence,) = contradictions([turned], [computed.values])
    assert_names(sentence, "exp(-j omega t)")
    assert contradictions([measured], [computed.values]) == ()
    late = replace(measured, values=measured.values * np.exp(-2j * np.pi * measured.frequencies * 2e-4))
    assert contradictions([late], [computed.values]) == ()


def test_noise_has_no_time_convention():
    rng = np.random.default_rng(3)
    noise = rng.standard_normal((2, 2, len(F)))
    curves = [replace(response(), values=a + 1j * b) for a, b in noise.swapaxes(0, 1)]
    assert not any(is_conjugate([curve]) for curve in curves)


def test_a_curve_without_a_peak_says_so():
    flat = replace(response(), values=np.full(len(F), 1.0 + 0.1j))
    assert_names(str(laid_over("fan", "free", 0.0, [flat], [response().values])), "6 dB")


RATE, HERTZ = 4096.0, 300.0


def record(zeta, seconds, noise=0.0):
    """A sampled oscillator that vibrates for 16 s before its record."""
    omega, rng = 2 * np.pi * HERTZ, np.random.default_rng(5)
    b, a, _ = scipy.signal.cont2discrete(([1.0], [1.0, 2 * zeta * omega, omega**2]), 1 / RATE, "foh")
    force = rng.standard_normal(int((seconds + 16) * RATE))
    place = scipy.signal.lfilter(b.ravel(), a, force)
    place += noise * np.std(place) * rng.standard_normal(len(place))
    start = int(16 * RATE)
    return TimeRecord(1 / RATE, {FORCE: force[start:], Channel("fan.x", "m"): place[start:]})


def test_damping_below_the_resolution_is_not_given_as_damping():
    """A ratio of 0.001 was printed as 0.0025."""
    (curve,) = estimate(record(0.001, 8.0), [FORCE.name])
    (mode,) = fitted_modes([curve.between(200.0, 400.0)])
    assert (mode.is_resolved, mode.lines) == (False, pytest.approx(1.6, abs=0.3))
    (pair,) = mode_deviations([mode], [mode])
    assert (pair.measured_damping, pair.computed_damping) == (None, mode.damping_ratio)
    text = str(laid_over("fan", "free", 0.0, [curve.between(200.0, 400.0)], [np.ones(201, complex)]))
    assert_names(text, "299.80 Hz", "not resolved", "lines")


@pytest.mark.parametrize(("zeta", "segment"), [(0.001, 16.0), (0.004, 4.0), (0.02, 1.0)])
def test_damping_above_the_resolution_is_that_of_the_vibration(zeta, segment):
    (curve,) = estimate(record(zeta, 8 * segment), [FORCE.name], segment=segment)
    (mode,) = fitted_modes([curve.between(200.0, 400.0)])
    assert mode.is_resolved
    assert mode.damping_ratio == pytest.approx(zeta, rel=0.15)


def test_a_narrow_peak_between_two_measured_lines_has_no_damping():
    curve = response(zeta=1e-4)
    assert [mode.is_resolved for mode in fitted_modes([curve])] == [False, False]


@pytest.mark.slow
def test_peaks_of_low_coherence_are_no_modes():
    (curve,) = estimate(record(0.004, 16.0, noise=0.5), [FORCE.name])
    assert [round(mode.frequency) for mode in fitted_modes([curve])] == [300]
    assert len(peak_frequencies([replace(curve, coherence=None)])) > 5


def test_noise_at_uncertain_coherence_has_no_modes():
    """Hammers excite up to a frequency, and above it the coherence falls slowly: 44 of 48 modes were noise."""
    coherence, averages = np.where(F < 100.0, 0.999, 0.65), 5
    relative = np.sqrt((1.0 - coherence) / (2.0 * averages * coherence))
    exact, noise, peaks = response(zeta=0.01), 0, 0
    for seed in range(4):
        a, b = np.random.default_rng(seed).standard_normal((2, len(F)))
        curve = replace(exact, values=exact.values * (1.0 + relative * (a + 1j * b)), coherence=coherence)
        modes = [round(mode.frequency) for mode in fitted_modes([curve])]
        assert 62 in modes
        noise += len(set(modes) - {62, 151})
        peaks += len(peak_frequencies([replace(curve, coherence=None)]))
    assert peaks > 30
    assert noise <= 2


def test_peaks_that_their_coherence_leaves_out_are_named():
    """A rig's authors saw seven modes of which two were listed, without a word about the others."""
    exact = response(zeta=0.01)
    curve = replace(exact, coherence=np.where(F < 100.0, 0.999, 0.4))
    assert [round(mode.frequency) for mode in fitted_modes([curve])] == [62]
    result = laid_over("fan", "free", 0.0, [curve], [exact.values])
    (warning,) = (text for text in result.warnings if "not listed" in text)
    assert_names(warning, "151", "0.40")
    assert not any("not listed" in text for text in laid_over("fan", "free", 0.0, [exact], [exact.values]).warnings)


def test_modes_without_resolved_damping_share_a_warning():
    curve = replace(response(zeta=1e-4), resolution=0.5)
    result = laid_over("fan", "free", 0.0, [curve], [response().values])
    (warning,) = [line for line in result.warnings if "resolved" in line]
    assert_names(warning, *(f"{mode.frequency:.2f} Hz" for mode in fitted_modes([curve])))
