"""Noise of a hammer's force: how it moves a response, and intervals of parameters from noisy blows."""

from __future__ import annotations

import numpy as np
import pytest

from amb_analysis.measured.estimates import estimate
from amb_analysis.measured.force_noise import ForceNoise, shared_scatter
from amb_analysis.measured.least_squares import FreeParameter
from amb_analysis.measured.records import Channel, TimeRecord
from amb_analysis.measured.response_fit import fit_responses

RATE, LASTS, AT, PULSE = 2048, 6.0, 0.05, 0.004  # Hz, s, s, s
N = round(LASTS * RATE)
FORCE, PLACES = Channel("fan.f_x", "N"), (Channel("a.x", "m/s2"), Channel("b.x", "m/s2"))
SHAPES = ((1.0, 0.7), (1.0, -0.9))  # of rigid motion and one mode
FREE = (FreeParameter("mass", 3.0, 6.0), FreeParameter("damping", 0.002, 0.02))
TRUE, START = np.array([4.2, 0.006]), (4.0, 0.008)


def responses(p, f):
    """Accelerances of a body with the mass p_0 and of one mode with the damping ratio p_1."""
    s, omega = 2j * np.pi * f, 2.0 * np.pi * 130.0 * np.sqrt(4.0 / p[0])
    mode = s**2 / (s**2 + 2.0 * p[1] * omega * s + omega**2)
    return [(rigid + shape * mode) / p[0] for rigid, shape in SHAPES]


def struck(seed, level, blows=1):
    """Return a record of blows, with noise in proportion to the largest value of each channel."""
    rng, t, parts = np.random.default_rng(seed), np.arange(N) / RATE, []
    for _ in range(blows):
        size = 200.0 * (1.0 + 0.2 * rng.standard_normal())
        acts = (t >= AT) & (t < AT + PULSE)
        u = np.where(acts, size * np.sin(np.pi * (t - AT) / PULSE), 0.0)
        H = responses(TRUE, np.arange(1, N // 2 + 1) * RATE / N)
        parts.append([u, *(np.fft.irfft(np.concatenate([[0.0], h]) * np.fft.rfft(u), N) for h in H)])
    rows = np.concatenate(parts, axis=1)
    rows = rows + level * np.abs(rows).max(axis=1, keepdims=True) * rng.standard_normal(rows.shape)
    return TimeRecord(1.0 / RATE, dict(zip((FORCE, *PLACES), rows, strict=True)))


@pytest.mark.parametrize("blows", [1, 3])
def test_a_change_of_a_force_sample_changes_the_response_as_stated(blows):
    """Against the estimate of a record in which one sample of the force is larger by a ten-thousandth."""
    record = struck(0, 1e-5, blows)
    before, step = estimate(record, [FORCE.name])[0], 0.02  # N
    noise, low = before.force_noise, before.frequencies < 100.0
    k = int(np.flatnonzero(noise.blows == blows - 1)[6])
    stated = noise.changes(before.frequencies)[low, k] / noise.sizes[k] * step
    errors = []
    for shift in range(-10, 11):  # the block begins some samples before the blow
        force = record.signals[FORCE].copy()
        force[round((blows - 1) * LASTS * RATE + AT * RATE) + shift] += step
        after = estimate(TimeRecord(1.0 / RATE, record.signals | {FORCE: force}), [FORCE.name])[0]
        seen = (after.values / before.values - 1.0)[low]
        errors.append(float(np.abs(seen - stated).max() / np.abs(stated).max()))
    assert min(errors) < 0.02
    assert sorted(errors)[1] > 0.1  # another sample has another phase


def test_residuals_that_share_noise_become_independent():
    """W (I + A A^T) W^T = I, for two responses to one series of blows and a third one to another."""
    rng = np.random.default_rng(0)
    noises = [ForceNoise(np.arange(m) * 1.0, np.ones(m), np.zeros(m, int), np.ones((1, 1))) for m in (3, 2)]
    columns = [(n, rng.standard_normal((4, len(n.times)))) for n in (noises[0], noises[0], noises[1])]
    A = np.zeros((12, 5))
    A[:4, :3], A[4:8, :3], A[8:, 3:] = (changes for _, changes in columns)
    shared = shared_scatter([*columns, (None, np.empty((2, 0)))])
    W = np.stack([shared.independent(row) for row in np.eye(14)], axis=1)
    covariance = np.eye(14)
    covariance[:12, :12] += A @ A.T
    np.testing.assert_allclose(W @ covariance @ W.T, np.eye(14), atol=1e-12)
    r = rng.standard_normal(14)
    noise = np.linalg.solve(np.eye(5) + A.T @ A, A.T @ r[:12])  # the most likely one
    np.testing.assert_allclose(shared.rest(r)[:12], r[:12] - A @ noise, atol=1e-12)


def held(seeds, level, blows):
    """Return how many intervals of each parameter hold it, and how many fits are reported."""
    count, alarms = np.zeros(2), 0
    for seed in seeds:
        curves = [curve.between(2.0, 300.0) for curve in estimate(struck(seed, level, blows), [FORCE.name])]
        result, warnings = fit_responses(lambda p: responses(p, curves[0].frequencies), curves, FREE, START)  # noqa: B023
        count += [p.lower <= true <= p.upper for p, true in zip(result.parameters.values(), TRUE, strict=True)]
        alarms += bool(warnings)
    return count, alarms


@pytest.mark.parametrize(("level", "blows"), [(1e-3, 1), (1e-2, 1), (1e-2, 4)])
def test_intervals_from_noisy_blows_hold_the_parameters(level, blows):
    """Of 20 intervals that hold with 95 %, 15 or fewer hold with a chance of 0.3 %."""
    count, alarms = held(range(20), level, blows)
    assert (count >= 16).all()
    assert alarms <= 2


@pytest.mark.slow
@pytest.mark.parametrize(("level", "blows"), [(1e-3, 1), (1e-3, 4), (1e-2, 1), (1e-2, 4)])
def test_intervals_from_noisy_blows_hold_in_95_of_100(level, blows):
    count, alarms = held(range(200), level, blows)
    assert ((count >= 180) & (count <= 198)).all(), count
    assert alarms <= 8
