"""Sampling instants of the controller, for any communication step."""

from fractions import Fraction

import numpy as np
import pytest
from controller_bench import Bench
from hypothesis import given, settings
from hypothesis import strategies as st

from signal_chain.sampling import aligned, is_due, is_too_long

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


def counted(h, n):
    """Times of a host that counts its steps, from 0 to n."""
    return np.arange(n + 1) * h


def summed(h, n):
    """The same of one that adds them up; after 300,000 steps of 0.1 ms, the sum has drifted by 1e-6 of a step."""
    return np.cumsum(np.r_[0.0, np.full(n, h)])


def rounded(h, n):
    """The same of one with a step in single precision, which differs from the sample time by up to 6e-8."""
    return np.arange(n + 1) * float(np.float32(h))


def uneven(h, n):
    """The same of one whose times have errors of half a millionth of the shortest sample time."""
    return np.arange(n + 1) * h + np.random.default_rng(1).uniform(-5e-11, 5e-11, n + 1)


def since_1970(h, n):
    """The same of one that counts from 1970, by which its times are rounded to 0.24 us."""
    return 1.7e9 + np.arange(n + 1) * h


HOSTS = [counted, summed, rounded, uneven, since_1970]


def steps_that_sample(times, h, sample_time):
    """Return the numbers of the steps that take a sample, from 0."""
    begin, found = 0.0, []
    for n, t in enumerate(times.tolist()):
        begin = aligned(begin, len(found), t, h, sample_time)
        if is_due(begin + len(found) * sample_time, t, h, sample_time):
            found.append(n)
    return np.array(found)


@pytest.mark.parametrize(("sample_time", "parts"), [(T, 1), (T, 10), (1.0 / 3000.0, 7), (1e-4, 3)])
@pytest.mark.parametrize("host", HOSTS)
def test_no_sample_is_lost_or_moved_in_a_long_run(sample_time, parts, host):
    h, n = sample_time / parts, 100_000
    np.testing.assert_array_equal(steps_that_sample(host(h, n - 1), h, sample_time), np.arange(0, n, parts))


@pytest.mark.parametrize("host", HOSTS)
@pytest.mark.parametrize(("numerator", "denominator"), [(2, 5), (7, 10), (1, 500)])
def test_the_times_of_a_host_move_no_sample_between_its_steps(numerator, denominator, host):
    """Instants in integers of T/denominator; the sample belongs to the step that contains it."""
    h, n = numerator * T / denominator, 30_000
    ends = numerator * np.arange(1, n + 1)
    exact = np.flatnonzero(-(-ends // denominator) > -(-(ends - numerator) // denominator))
    np.testing.assert_array_equal(steps_that_sample(host(h, n - 1), h, T), exact)


def test_a_drift_of_more_than_the_tolerance_moves_no_sample():
    """After 1000 s in steps of 50 us, a sum of the steps is 0.215 us late, 0.4 % of a step."""
    h, n = 5e-5, 20_000
    late = np.linspace(0.0, 2.15e-7, n)
    np.testing.assert_array_equal(steps_that_sample(np.arange(n) * h + late, h, T), np.arange(0, n, 5))
    np.testing.assert_array_equal(steps_that_sample(np.arange(n) * h - late, h, T), np.arange(0, n, 5))


def test_accumulated_time_with_drift_takes_a_sample_in_each_step():
    """A step of a sample whose time runs ahead of the count by a hundredth of a sample."""
    assert [is_due(n * T, n * T + 0.01 * T, T, T) for n in range(5)] == [True] * 5


def test_steps_far_below_the_rounding_take_a_first_sample_at_once():
    h = 1e-8 * T
    assert steps_that_sample(counted(h, 20), h, T).tolist() == [0]


@pytest.mark.parametrize("n", [0, 1, 12345, 4 * 3600 * 4000, 365 * 24 * 3600 * 4000])
def test_a_step_size_from_subtracted_times_is_no_longer_than_a_sample(n):
    assert not is_too_long(n * T, (n + 1) * T - n * T, T)
    assert not is_too_long(0.0, float(np.float32(T)), T)
    exact = Fraction(T) * (1 + Fraction(1, 10**5))
    assert is_too_long(0.0, float(exact), T)
