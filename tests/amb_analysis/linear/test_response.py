"""Frequency responses of sampled systems in closed form."""

import control
import numpy as np
import pytest

from amb_analysis.linear.loop import response


@pytest.mark.parametrize("pole", [0.0, 0.7])
def test_a_response_of_equal_poles_is_that_of_its_chain(pole):
    """1/(z - p)^4, whose eigenvectors are one; of a delay line for p = 0. Different poles are in the tests below."""
    chain = control.ss(np.diag(np.full(4, pole)) + np.eye(4, k=1), np.eye(4)[:, 3:], np.eye(4)[:1], [[0.0]], 1e-3)
    frequencies = np.geomspace(1.0, 499.0, 200)
    z = np.exp(2j * np.pi * frequencies * 1e-3)
    np.testing.assert_allclose(response(chain, frequencies)[0, 0], (z - pole) ** -4, rtol=1e-6)


def test_a_response_by_eigenvectors_is_the_sum_of_its_poles():
    poles, gains = np.array([0.9, -0.5, 0.99 * np.exp(0.3j), 0.99 * np.exp(-0.3j)]), np.array([1.0, 2.0, 1j, -1j])
    A = np.zeros((4, 4))
    A[[0, 1], [0, 1]], A[2:, 2:] = (
        poles[:2].real,
        0.99 * np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]]),
    )
    system = control.ss(A, [[1.0], [2.0], [1.0], [0.0]], [[1.0, 1.0, 0.0, -2.0]], [[0.25]], 1e-3)
    frequencies = np.geomspace(1.0, 499.0, 200)
    z = np.exp(2j * np.pi * frequencies * 1e-3)
    expected = 0.25 + (gains[:, None] / (z - poles[:, None])).sum(axis=0)
    np.testing.assert_allclose(response(system, frequencies)[0, 0], expected, rtol=1e-9)
