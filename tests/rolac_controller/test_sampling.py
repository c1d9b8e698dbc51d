"""Sampling instants of the controller, for any communication step."""

from fractions import Fraction

import numpy as np
import pytest
from controller_bench import Bench
from hypothesis import given, settings
from hypothesis import strategies as st

from signal_chain.sampling import is_due, is_too_long

T = 250e-6


def times(h, steps, begin=0.0, summed=False):
    """Times of the steps of a master that counts its steps, or of one that sums them."""
    if not summed:
        return [begin + n * h for n in range(steps)]
    result = [begin]
    for _ in range(steps - 1):
        result.append(result[-1] + h)
    return result


def currents(bench, moments, h):
    """Currents of MB1 after each step; its displacement falls into another sixteenth of a sample at each of them."""
    b = bench(mb1__k_integral_x=1e6)
    result = []
    for t in moments:
        b["s5"] = 1e-5 * np.sin(300.0 * round(16 * (t - moments[0]) / T) * T / 16)
        b.instance.step(t, h)
        result.append(b["mb1.i_x"])
    return np.array(result)


@pytest.mark.parametrize("begin", [0.0, -0.0731, 1e4])
@pytest.mark.parametrize("summed", [False, True])
@pytest.mark.parametrize("parts", [2, 4, 16])
def test_steps_within_a_sample_hold_its_currents(bench, parts, summed, begin):
    samples = 60
    whole = currents(bench, times(T, samples, begin), T)
    result = currents(bench, times(T / parts, parts * samples, begin, summed), T / parts)
    assert len(set(whole.tolist())) == samples
    np.testing.assert_array_equal(result, np.repeat(whole, parts))


def steps_with_a_sample(lengths):
    """Return for each step, of these lengths (s), whether it takes a sample."""
    b = Bench()
    t, taken = 0.0, []
    for n, h in enumerate(lengths):
        b["s5"] = 1e-9 * (n + 1)
        before = b["mb1.i_x"]
        b.instance.step(t, h)
        t += h
        taken.append(b["mb1.i_x"] != before)
    return taken


@settings(max_examples=60)
@given(st.lists(st.integers(1, 97), min_size=1, max_size=80))
def test_a_step_takes_the_sample_whose_instant_it_contains(parts):
    """Steps of any length, in fractions of a sample; the instants are counted as integers."""
    ends = np.cumsum(parts)
    expected = [(end - 1) // 97 > (end - part - 1) // 97 for part, end in zip(parts, ends.tolist(), strict=True)]
    assert steps_with_a_sample([part * T / 97 for part in parts]) == expected


@pytest.mark.parametrize(("sample_time", "parts"), [(T, 1), (T, 10), (1.0 / 3000.0, 7), (1e-4, 3)])
@pytest.mark.parametrize("summed", [False, True])
def test_no_sample_is_lost_or_shifted_in_a_long_run(sample_time, parts, summed):
    """A sum of a million steps drifts by 2e-5 of a step."""
    h, t, samples, late = sample_time / parts, 0.0, 0, 0
    for n in range(300_000):
        if is_due(samples * sample_time, t, h):
            samples += 1
            late += n % parts
        t = t + h if summed else (n + 1) * h
    assert samples == -(-300_000 // parts)
    assert late == 0


def test_accumulated_time_with_drift_takes_a_sample_in_each_step():
    """A step of a sample whose time runs ahead of the count by a hundredth of a sample."""
    assert [is_due(n * T, n * T + 0.01 * T, T) for n in range(5)] == [True] * 5


@pytest.mark.parametrize("n", [0, 1, 12345, 4 * 3600 * 4000, 365 * 24 * 3600 * 4000])
def test_a_step_size_from_subtracted_times_is_no_longer_than_a_sample(n):
    assert not is_too_long(n * T, (n + 1) * T - n * T, T)
    exact = Fraction(T) * (1 + Fraction(1, 10**8))
    assert is_too_long(0.0, float(exact), T)
