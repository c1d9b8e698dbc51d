"""Recursive Fourier transform: exactness, leakage, rejection, drift, validity of the window."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fmi_export.jit import kernel
from rolac_controller.fourier import CAPACITY, N_SENSORS, N_WINDOW, record, synchronous

AMPLITUDES = 1e-4 * np.arange(1, 9)
PHASES = np.linspace(-3.0, 3.0, 8)


def tone(theta):
    return AMPLITUDES * np.cos(theta + PHASES)


def transform(signal, delta, samples, start=0.0):
    """Q of the first sensor after driving it with `signal` of the angle."""
    window, q, sensors = np.zeros(N_WINDOW), np.zeros(2 * N_SENSORS), np.zeros(N_SENSORS)
    for n in range(samples):
        theta = start + n * delta
        sensors[0] = signal(theta)
        record(window, theta, sensors)
    assert synchronous(window, q) == pytest.approx(2.0 * math.pi / delta, abs=1e-6)
    return complex(q[0], q[1])


@pytest.mark.parametrize("samples", [12, 40, 250, 800])
def test_tone_gives_its_amplitude_and_phase(bench, speed_of, samples):
    b = bench(Omega=speed_of(samples))
    b.follow(tone, 2 * samples + 3)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-12)


@pytest.mark.parametrize("samples", [40, 250, 133.37])
def test_wrapped_and_continuous_angle_agree(bench, speed_of, samples):
    speed = speed_of(samples)
    wrapped, continuous = bench(Omega=speed), bench(Omega=speed)
    continuous.theta = 1e3
    wrapped.theta = 1e3 % (2.0 * math.pi)
    for _ in range(int(3 * samples)):
        for b in (wrapped, continuous):
            b.sense(tone(b.theta))
            b.sample()
        wrapped.theta %= 2.0 * math.pi
    np.testing.assert_allclose(wrapped.components(), continuous.components(), rtol=1e-9)
    assert wrapped["window_valid"] == continuous["window_valid"] == 1.0


def test_harmonics_and_constants_are_rejected_over_whole_revolutions(bench, speed_of):
    b = bench(Omega=speed_of(80))

    def signal(theta):
        return np.array([1e-3, *(1e-3 * np.cos(m * theta + 0.4 * m) for m in range(2, 9))])

    b.follow(signal, 200)
    assert np.abs(b.components()).max() < 1e-15


@pytest.mark.parametrize("harmonic", [0, 1, 2, 3])
def test_leakage_stays_within_its_bound_and_the_bound_is_tight(harmonic):
    """The bound is to leading order; at 60 samples per revolution and more it holds within a tenth."""
    ratios = []
    for samples in np.linspace(60.0, 260.0, 317):
        delta = 2.0 * math.pi / samples
        bound = (harmonic**2 + 1) * delta**3 * math.sqrt(3.0) / (216.0 * math.pi)
        for phase in (0.3, 1.9):
            found = transform(
                lambda theta, phase=phase: math.cos(harmonic * theta + phase),
                delta,
                int(samples) + 3,
                start=0.1 * samples,
            )
            expected = np.exp(1j * phase) if harmonic == 1 else 0.0
            size = math.cos(phase) if harmonic == 0 else 1.0
            ratios.append(abs(found - expected) / (bound * abs(size)))
    assert 0.95 < max(ratios) < 1.1


def test_leakage_vanishes_with_the_third_power_of_the_step():
    def worst(samples):
        fractions = np.linspace(0.05, 0.95, 19)
        return max(abs(transform(math.cos, 2.0 * math.pi / (samples + f), samples + 4) - 1.0) for f in fractions)

    order = math.log(worst(60) / worst(240)) / math.log(4.0)
    assert order == pytest.approx(3.0, abs=0.1)


def test_amplitude_is_that_of_the_last_revolution_alone(bench, speed_of):
    b = bench(Omega=speed_of(50))
    b.follow(lambda theta: np.full(8, 0.05), 500)
    b.follow(tone, 51)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-10)


def test_tone_is_found_while_the_speed_changes(bench):
    b = bench(Omega=2.0 * math.pi * 10.0)
    for _ in range(8000):  # 10 to 60 Hz in 2 s
        b["Omega"] = b["Omega"] + 2.0 * math.pi * 25.0 * b.h
        b.sense(tone(b.theta))
        b.sample()
        if b["window_valid"]:
            np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-4)
    assert b["window_valid"] == 1.0


@kernel
def run_long(window, q, delta, samples, large):
    """A large signal for all but the last revolutions, then a small tone; whole run in one call."""
    sensors = np.zeros(N_SENSORS)
    theta = 0.0
    for n in range(samples):
        size = large if n < samples - 500 else 1e-6
        for s in range(N_SENSORS):
            sensors[s] = size * math.cos(theta + 0.1 * s)
        record(window, theta, sensors)
        theta = (theta + delta) % (2.0 * math.pi)
    return synchronous(window, q)


def test_a_million_samples_leave_no_drift():
    window, q = np.zeros(N_WINDOW), np.zeros(2 * N_SENSORS)
    turn = run_long(window, q, 2.0 * math.pi / 125.0, 1_000_000, 0.05)
    assert turn == pytest.approx(125.0, abs=1e-9)
    expected = 1e-6 * np.exp(0.1j * np.arange(N_SENSORS))
    # Sums of the large signal rounded to 1e-17 m would show here; a refreshed sum does not know it any more.
    np.testing.assert_allclose(q[::2] + 1j * q[1::2], expected, atol=1e-19, rtol=1e-12)


def test_window_is_valid_after_one_revolution_and_not_before(bench, speed_of):
    b = bench(Omega=speed_of(100))
    b.follow(tone, 100)
    assert b["window_valid"] == 0.0
    assert not b.components().any()
    b.follow(tone, 1)
    assert b["window_valid"] == 1.0


def test_no_synchronous_signal_below_the_least_speed(bench):
    b = bench(Omega=2.0 * math.pi * 5.01)
    b.follow(tone, 900)
    assert b["window_valid"] == 1.0
    b["Omega"] = 2.0 * math.pi * 4.99
    b.follow(tone, 1)
    assert b["window_valid"] == 0.0
    assert not b.components().any()


def test_revolution_longer_than_the_window_is_not_valid_and_recovers(bench, speed_of):
    b = bench(Omega=speed_of(CAPACITY), rolac__min_speed=0.1)  # takes one sample more than there are
    b.follow(tone, 2 * CAPACITY)
    assert b["window_valid"] == 0.0
    b["Omega"] = speed_of(CAPACITY - 2)
    b.follow(tone, CAPACITY)
    assert b["window_valid"] == 1.0
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-7)


def test_angle_that_does_not_turn_with_the_speed_is_never_valid(bench, speed_of):
    b = bench(Omega=speed_of(100))
    b.follow(tone, 300)
    assert b["window_valid"] == 1.0
    stuck = b.theta
    for n in range(300):
        b.theta = stuck
        b.sense(tone(stuck))
        b.sample()
        assert b["window_valid"] == 0.0 or n < 100


def test_large_change_of_speed_is_not_valid_until_a_revolution_has_passed(bench, speed_of):
    b = bench(Omega=speed_of(200))
    b.follow(tone, 300)
    b["Omega"] = speed_of(50)
    b.follow(tone, 1)
    assert b["window_valid"] == 0.0
    b.follow(tone, 50)
    assert b["window_valid"] == 1.0
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-10)


def test_jump_of_the_angle_starts_the_window_again(bench, speed_of):
    b = bench(Omega=speed_of(100))
    b.follow(tone, 150)
    b.theta += 2.0
    b.follow(tone, 1)
    assert b["window_valid"] == 0.0
    b.follow(tone, 100)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-10)


def test_angle_of_a_rotor_that_ran_for_days_is_good_enough(bench, speed_of):
    b = bench(Omega=speed_of(100))
    b.theta = 0.99e9
    b.follow(tone, 300)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-6)


def test_noise_on_the_angle_of_a_slow_rotor_does_not_break_the_window(bench, speed_of):
    """The angle may even step back between samples; the revolution stays one revolution."""
    rng = np.random.default_rng(3)
    b = bench(Omega=speed_of(700))
    for n in range(3000):
        b.theta = b["Omega"] * n * b.h + rng.normal(scale=0.01)
        b.sense(tone(b.theta))
        b.sample()
    assert b["window_valid"] == 1.0
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-3)
