"""Responses and coherence from records, against the system that made them."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.signal

from amb_analysis.measured.estimates import estimate, responses
from amb_analysis.measured.records import Channel, TimeRecord
from tests.support.messages import raises_naming

STEP = 1e-3
FORCE, OTHER, PLACE = Channel("fan.f_x", "N"), Channel("fan.f_y", "N"), Channel("fan.x", "m")


def oscillator(rng, n=60000, noise_out=0.0, noise_in=0.0):
    """A sampled oscillator of 40 Hz under white noise, its true response beside it."""
    b, a = scipy.signal.iirpeak(40.0, 8.0, 1.0 / STEP)
    force = rng.standard_normal(n)
    place = scipy.signal.lfilter(b, a, force)
    record = TimeRecord(
        STEP, {FORCE: force + noise_in * rng.standard_normal(n), PLACE: place + noise_out * rng.standard_normal(n)}
    )
    return record, lambda f: scipy.signal.freqz(b, a, f, fs=1.0 / STEP)[1]


def test_h1_is_the_response_with_its_phase():
    record, exact = oscillator(np.random.default_rng(1))
    (result,) = estimate(record, ["fan.f_x"], segment=2.0)
    error = np.abs(result.values - exact(result.frequencies))
    assert error.max() < 0.05
    assert result.coherence is not None
    within = (result.frequencies > 10.0) & (result.frequencies < 300.0)
    assert result.coherence[within].min() > 0.98
    assert result.unit == "m/N"


def test_a_delay_has_a_negative_phase():
    rng = np.random.default_rng(2)
    force = rng.standard_normal(20000)
    late = np.concatenate([np.zeros(5), force[:-5]])
    (result,) = estimate(TimeRecord(STEP, {FORCE: force, PLACE: late}), ["fan.f_x"], segment=0.5)
    k = np.searchsorted(result.frequencies, 20.0)
    assert np.angle(result.values[k]) == pytest.approx(-2 * np.pi * result.frequencies[k] * 5 * STEP, abs=0.02)


def test_noise_at_the_input_lowers_h1_and_not_h2():
    record, exact = oscillator(np.random.default_rng(3), n=200000, noise_in=1.0)
    (h1,), (h2,) = (estimate(record, ["fan.f_x"], segment=1.0, estimator=e) for e in ("H1", "H2"))
    k = np.argmin(np.abs(h1.frequencies - 40.0))
    true = abs(exact(h1.frequencies[[k]])[0])
    assert abs(h1.values[k]) == pytest.approx(0.5 * true, rel=0.1)  # S_uu has twice the power
    assert abs(h2.values[k]) == pytest.approx(true, rel=0.1)
    assert h1.coherence[k] == pytest.approx(0.5, abs=0.1)


def test_two_correlated_inputs_are_separated():
    rng = np.random.default_rng(4)
    first, second = rng.standard_normal((2, 100000))
    second += 0.7 * first
    place = 2.0 * first - 3.0 * second
    result = estimate(TimeRecord(STEP, {FORCE: first, OTHER: second, PLACE: place}), ["fan.f_x", "fan.f_y"])
    assert [item.input for item in result] == [FORCE, OTHER]
    np.testing.assert_allclose(result[0].values, 2.0, atol=1e-6)
    np.testing.assert_allclose(result[1].values, -3.0, atol=1e-6)


def test_linearly_dependent_inputs_are_refused():
    S = np.ones((4, 3, 3), dtype=complex)
    with raises_naming(ValueError, "separated"):
        responses(S, 2)


@pytest.mark.parametrize(
    ("options", "facts"),
    [
        ({"inputs": []}, ("input",)),
        ({"inputs": ["fan.f_z"]}, ("'fan.f_z'",)),
        ({"inputs": ["fan.f_x"], "segment": 1000.0}, ("segment", "1000 s")),
        ({"inputs": ["fan.f_x"], "window": "house"}, ("window", "'house'")),
        ({"inputs": ["fan.f_x", "fan.x"]}, ("output",)),
    ],
)
def test_errors_name_the_invalid_argument(options, facts):
    record, _ = oscillator(np.random.default_rng(5), n=4000)
    with raises_naming(ValueError, *facts):
        estimate(record, **options)
