"""Recursive Fourier transform: exactness, leakage, rejection, drift, validity of the window."""

import math

import numpy as np
import pytest
from code_blocks import example_of

from fmi_export.jit import kernel
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.fourier import (
    CAPACITY,
    add_sample,
    angle_between,
    angle_jump,
    last_delta_theta,
    samples_of_revolution,
    transform,
    window_of,
    window_size,
)
from rolac_controller.records import HARMONIC

N_SENSORS = 8

AMPLITUDES = 1e-4 * np.arange(1, 9)
PHASES = np.linspace(-3.0, 3.0, 8)


def tone(theta):
    return AMPLITUDES * np.cos(theta + PHASES)


def harmonics_of(orders):
    """Harmonics of these orders, for the kernels."""
    harmonics = np.zeros(N_HARMONICS, dtype=HARMONIC)
    harmonics["order"][: len(orders)] = orders
    return harmonics


def empty_window():
    return window_of(np.zeros(window_size(N_SENSORS)), 0, N_SENSORS)


def first_sensor(signal, delta, samples, start=0.0, orders=(1,)):
    """Q of the first sensor in each harmonic after driving it with `signal` of the angle."""
    window, sensors = empty_window(), np.zeros(N_SENSORS)
    Q, harmonics = np.zeros((N_HARMONICS, N_SENSORS), dtype=complex), harmonics_of(orders)
    for n in range(samples):
        theta = start + n * delta
        sensors[0] = signal(theta)
        add_sample(window, harmonics, theta, sensors)
    assert samples_of_revolution(window) == pytest.approx(2.0 * math.pi / delta, abs=1e-6)
    transform(window, harmonics, Q)
    return Q[: len(orders), 0]


@pytest.mark.parametrize("samples", [12, 40, 250, 800])
def test_tone_gives_its_amplitude_and_phase(bench, speed_of, samples):
    b = bench(Omega=speed_of(samples))
    b.follow(tone, 2 * samples + 3)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("harmonic", [0, 1, 2, 3])
def test_leakage_stays_within_its_bound_and_the_bound_is_tight(harmonic, order):
    """The bound is to leading order; at 60 samples per revolution and more it holds within a quarter."""
    ratios = []
    for samples in np.linspace(60.0, 260.0, 79) + 0.1 * (order > 1):
        delta = 2.0 * math.pi / samples
        bound = (harmonic**2 + order**2) * delta**3 * math.sqrt(3.0) / (216.0 * math.pi)
        for phase in (0.3, 1.9):
            (result,) = first_sensor(
                lambda theta, phase=phase: math.cos(harmonic * theta + phase),
                delta,
                int(samples) + 3,
                start=0.1 * samples,
                orders=(order,),
            )
            expected = np.exp(1j * phase) if harmonic == order else 0.0
            size = math.cos(phase) if harmonic == 0 else 1.0
            ratios.append(abs(result - expected) / (bound * abs(size)))
    assert 0.8 < max(ratios) < 1.25


def test_harmonics_are_separated_exactly_over_whole_revolutions():
    amplitudes = {1: 1e-4, 2: -3e-5j, 5: 2e-5 + 1e-5j, 7: 4e-6}

    def signal(theta):
        others = 1e-3 + 5e-5 * math.cos(3 * theta)
        return others + sum((q * np.exp(1j * n * theta)).real for n, q in amplitudes.items())

    result = first_sensor(signal, 2.0 * math.pi / 64.0, 200, orders=tuple(amplitudes))
    np.testing.assert_allclose(result, list(amplitudes.values()), atol=1e-18, rtol=1e-12)


def test_harmonic_with_fewer_than_four_samples_in_a_period_is_left_out():
    result = first_sensor(lambda theta: math.cos(9 * theta), 2.0 * math.pi / 40.0, 100, orders=(9, 11))
    assert abs(result[0]) == pytest.approx(1.0, abs=1e-12)
    assert result[1] == 0.0


def test_controller_shows_each_harmonic_by_its_number(bench, speed_of):
    b = bench(Omega=speed_of(80), harmonic2__order=3)

    def signal(theta):
        return tone(theta) + 0.1 * AMPLITUDES * np.cos(3 * theta - PHASES)

    b.follow(signal, 200)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-12)
    b["shown_harmonic"] = 2
    b.follow(signal, 1)
    np.testing.assert_allclose(b.components(), 0.1 * AMPLITUDES * np.exp(-1j * PHASES), rtol=1e-11)
    norms = [b["harmonic1.displacement"], b["harmonic2.displacement"], b["harmonic3.displacement"]]
    whole = np.sqrt(np.sum(AMPLITUDES**2))
    np.testing.assert_allclose(norms, [whole, 0.1 * whole, 0.0], rtol=1e-11)


def test_amplitude_is_that_of_the_last_revolution_alone(bench, speed_of):
    b = bench(Omega=speed_of(50))
    b.follow(lambda theta: np.full(8, 0.05), 500)
    b.follow(tone, 51)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-10)


@pytest.mark.parametrize("rate", [25.0, -25.0, 250.0])
def test_amplitude_of_a_tone_is_exact_while_the_speed_changes(bench, rate):
    """The window is a revolution of angle: a tone that turns with the rotor stays orthogonal to everything else."""
    b = bench(Omega=2.0 * math.pi * (10.0 if rate > 0 else 60.0))
    for _ in range(int(50.0 / abs(rate) / b.h)):  # between 10 and 60 Hz
        b["Omega"] = b["Omega"] + 2.0 * math.pi * rate * b.h
        b.sense(tone(b.theta))
        b.sample()
        if b["window_valid"]:
            np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-4)
    assert b["window_valid"] == 1.0


def test_harmonics_and_constants_do_not_leak_while_the_speed_changes(bench):
    b = bench(Omega=2.0 * math.pi * 10.0)
    worst = 0.0
    for _ in range(8000):
        b["Omega"] = b["Omega"] + 2.0 * math.pi * 25.0 * b.h
        theta = b.theta
        b.sense(np.array([1e-3, *(1e-3 * math.cos(m * theta) for m in range(2, 9))]))
        b.sample()
        worst = max(worst, np.abs(b.components()[:4]).max())
    assert 0.0 < worst < 1e-3 * 1e-3


def test_growing_amplitude_is_shown_as_its_mean_over_the_revolution(bench, speed_of):
    """Half a revolution late: a = a_0 (1 + r theta) gives a_0 (1 + r (theta - pi)), to first order in r."""
    b = bench(Omega=speed_of(200))
    rate = 1e-3
    b.follow(lambda theta: np.full(8, 1e-4 * (1.0 + rate * theta) * math.cos(theta)), 3000)
    theta = b.theta - b["Omega"] * b.h
    assert abs(b.components()[0]) == pytest.approx(1e-4 * (1.0 + rate * (theta - math.pi)), rel=rate)


@kernel
def run_long(window, harmonics, Q, sensors, delta, samples):
    """A large signal until the last revolutions, then a small tone; the whole run in one call."""
    theta = 0.0
    for n in range(samples):
        size = 0.05 if n < samples - 500 else 1e-6
        for s in range(N_SENSORS):
            sensors[s] = size * math.cos(theta + 0.1 * s)
        add_sample(window, harmonics, theta, sensors)
        theta = (theta + delta) % (2.0 * math.pi)
    transform(window, harmonics, Q)
    return samples_of_revolution(window)


@pytest.mark.parametrize("samples", [1_000_000, pytest.param(10_000_000, marks=pytest.mark.slow)])
def test_millions_of_samples_leave_no_drift(samples):
    window, Q = empty_window(), np.zeros((N_HARMONICS, N_SENSORS), dtype=complex)
    revolution = run_long(window, harmonics_of((1, 3)), Q, np.zeros(N_SENSORS), 2.0 * math.pi / 125.0, samples)
    assert revolution == pytest.approx(125.0, abs=1e-9)
    expected = 1e-6 * np.exp(0.1j * np.arange(N_SENSORS))
    # Sums of the large signal rounded to 1e-17 m would show here; a refreshed sum does not know it any more.
    np.testing.assert_allclose(Q[0], expected, atol=1e-19, rtol=1e-12)
    assert np.abs(Q[1]).max() < 1e-19


def test_a_signal_that_has_left_the_window_has_no_effect():
    """No rounding error of the large signal remains in the small one, even after a jump of the angle."""
    window, sensors, harmonics = empty_window(), np.zeros(N_SENSORS), harmonics_of((1, 3))
    Q = np.ones((N_HARMONICS, N_SENSORS), dtype=complex)
    for n in range(700):
        theta = 2.0 * math.pi / 100.0 * n + (2.0 if n > 150 else 0.0)
        sensors[:] = (1e6 if n < 400 else 1e-6) * math.cos(theta + 0.3)
        add_sample(window, harmonics, theta, sensors)
    transform(window, harmonics, Q)
    np.testing.assert_allclose(Q[0], 1e-6 * np.exp(0.3j), rtol=1e-9)
    np.testing.assert_allclose(Q[1], 0.0, atol=1e-15)


def test_window_recovers_after_a_jump_of_the_angle():
    used, new, harmonics = empty_window(), empty_window(), harmonics_of((1, 3))
    for n in range(130):
        add_sample(used, harmonics, 0.063 * n, np.full(N_SENSORS, 1e6 * math.cos(0.063 * n)))
    assert samples_of_revolution(used) > 0.0
    result = np.zeros((2, N_HARMONICS, N_SENSORS), dtype=complex)
    for n in range(130):
        for window, Q in zip((used, new), result, strict=True):
            add_sample(window, harmonics, 0.063 * n + 4.0, tone(0.063 * n))
            transform(window, harmonics, Q)
        assert samples_of_revolution(used) == samples_of_revolution(new)
        np.testing.assert_array_equal(result[0], result[1])
    assert np.all(result[0, :2] != 0.0)


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 3])
def test_change_of_angle_does_not_depend_on_whole_turns(turns):
    for earlier in np.linspace(-7.0, 7.0, 29):
        for change in (-3.1, -1.0, 0.0, 0.5, 3.1):
            later = earlier + change + 2.0 * math.pi * turns
            assert angle_between(earlier, later) == pytest.approx(change, abs=1e-12)


def test_angle_jumps_and_turns_are_detected_from_the_second_sample_on():
    window, result = empty_window(), []
    assert angle_jump(window, 3.0) == 0.0
    for theta in (3.0, 3.1, 3.3):
        add_sample(window, harmonics_of((1,)), theta, np.zeros(N_SENSORS))
        result.append(last_delta_theta(window))
    np.testing.assert_allclose(result, [0.0, 0.1, 0.2], atol=1e-15)
    jumps = [angle_jump(window, 3.3 + change) for change in (1.5, 1.6, -1.5, -1.6)]
    np.testing.assert_allclose(jumps, [0.0, 1.6, 0.0, -1.6], atol=1e-15)
    add_sample(window, harmonics_of((1,)), 5.3, np.zeros(N_SENSORS))
    assert last_delta_theta(window) == 0.0, "the window starts again"


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


def test_angle_after_days_of_rotation_is_accurate_enough(bench, speed_of):
    b = bench(Omega=speed_of(100))
    b.theta = 0.99e9
    b.follow(tone, 300)
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-6)


def test_noise_on_the_angle_of_a_slow_rotor_does_not_break_the_window(bench, speed_of):
    """The angle may even step back between samples; the length of the revolution is unchanged."""
    rng = np.random.default_rng(3)
    b = bench(Omega=speed_of(700))
    for n in range(3000):
        b.theta = b["Omega"] * n * b.h + rng.normal(scale=0.01)
        b.sense(tone(b.theta))
        b.sample()
    assert b["window_valid"] == 1.0
    np.testing.assert_allclose(b.components(), AMPLITUDES * np.exp(1j * PHASES), rtol=1e-3)


def test_example_in_the_readme_recovers_its_vibration(run_python, tmp_path):
    code = example_of("rolac_controller")
    amplitude, phase = run_python(code + "\nresult = [float(amplitude), float(phase)]", cwd=tmp_path)
    assert amplitude == pytest.approx(1e-4, rel=1e-6)
    assert phase == pytest.approx(-1.0471975511965976, abs=1e-6)
