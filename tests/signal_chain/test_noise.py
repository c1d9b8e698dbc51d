"""Random numbers: the published generator, its statistics, its seeds."""

import numpy as np
import pytest

from fmi_export.jit import kernel
from signal_chain.noise import STREAM, normal_pair, start_stream, uniform


def reference(state, count):
    """MRG32k3a as published, in integer arithmetic."""
    m_1, m_2 = 4294967087, 4294944443
    x, y = list(state[:3]), list(state[3:])
    numbers = []
    for _ in range(count):
        x = [*x[1:], (1403580 * x[1] - 810728 * x[0]) % m_1]
        y = [*y[1:], (527612 * y[2] - 1370589 * y[0]) % m_2]
        numbers.append(((x[2] - y[2]) % m_1 or m_1) / (m_1 + 1))
    return numbers


@pytest.mark.parametrize("state", [[12345] * 6, [1, 2, 3, 4, 5, 6], [4294967086] * 3 + [4294944442] * 3])
def test_uniform_numbers_match_the_published_generator(state):
    stream = np.array(state, dtype=float).view(STREAM)[0]
    assert [uniform(stream) for _ in range(5000)] == reference(state, 5000)


def test_first_numbers_match_the_published_package():
    """The default seed of the package, 12345 six times: its documentation shows 0.127011, 0.318528, 0.309186."""
    stream = np.full(6, 12345.0).view(STREAM)[0]
    np.testing.assert_allclose([uniform(stream) for _ in range(3)], [0.127011, 0.318528, 0.309186], atol=5e-7)


@kernel
def normals(stream, numbers):
    for i in range(0, len(numbers), 2):
        numbers[i], numbers[i + 1] = normal_pair(stream)


@pytest.fixture
def sequence():
    def make(number, count=200_000):
        stream, numbers = np.zeros(1, dtype=STREAM)[0], np.empty(count)
        start_stream(stream, float(number))
        normals(stream, numbers)
        return numbers

    return make


@pytest.mark.parametrize("number", [0, 1, 2, 2**31 - 1])
def test_normal_numbers_have_the_moments_of_the_normal_distribution(sequence, number):
    """Deviations of the sample moments: 1/sqrt(n), sqrt(2/n), sqrt(6/n), sqrt(24/n)."""
    x = sequence(number)
    unit = 1.0 / np.sqrt(len(x))
    assert abs(x.mean()) < 4.5 * unit
    assert abs(x.var() - 1.0) < 4.5 * np.sqrt(2.0) * unit
    assert abs((x**3).mean()) < 4.5 * np.sqrt(15.0) * unit
    assert abs((x**4).mean() - 3.0) < 4.5 * np.sqrt(96.0) * unit


def test_normal_numbers_are_uncorrelated_in_time_and_within_a_pair(sequence):
    x = sequence(3)
    for lag in (1, 2, 3, 8, 16):
        assert abs((x[lag:] * x[:-lag]).mean()) < 4.5 / np.sqrt(len(x))
        assert abs((x[lag:] ** 2 * x[:-lag] ** 2).mean() - 1.0) < 4.5 * 3.0 / np.sqrt(len(x))


def test_sequences_of_neighbouring_seeds_are_uncorrelated(sequence):
    a, b = sequence(1), sequence(2)
    assert abs((a * b).mean()) < 4.5 / np.sqrt(len(a))
    np.testing.assert_array_equal(a, sequence(1))
