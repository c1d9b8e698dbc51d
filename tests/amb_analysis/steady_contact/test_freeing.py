"""The smallest currents that keep orbits within limits, against closed forms and linear programming."""

import numpy as np
import pytest
from scipy.optimize import linprog

from amb_analysis.steady_contact.freeing import _searched, _smallest_currents

DIRECTIONS = 720


def by_linear_programming(r, S, limits):
    """Return the smallest largest |I|, with polygons of 720 sides about the circles; None if infeasible.

    min t,  Re(e^(-i a) I_k) <= t,  Re(e^(-i a) (r_j + S_j I)) <= limit_j, for all directions a.
    """
    n, turns = S.shape[1], np.exp(-2j * np.pi * np.arange(DIRECTIONS) / DIRECTIONS)

    def rows(A):
        turned = (turns[:, None, None] * A).reshape(-1, n)
        return np.hstack([turned.real, -turned.imag])

    sizes, orbits = rows(np.eye(n)), rows(S)
    A = np.vstack([np.c_[sizes, -np.ones(len(sizes))], np.c_[orbits, np.zeros(len(orbits))]])
    b = np.concatenate([np.zeros(len(sizes)), (np.tile(limits, (DIRECTIONS, 1)) - (turns[:, None] * r).real).ravel()])
    found = linprog(np.eye(2 * n + 1)[-1], A, b, bounds=[*[(None, None)] * (2 * n), (0.0, None)])
    return found.x[-1] if found.success else None


@pytest.mark.parametrize(("magnets", "sites"), [(1, 1), (2, 2), (3, 3), (2, 3), (3, 2)])
def test_smallest_currents_are_those_of_linear_programming(magnets, sites):
    """Receptances, orbits and limits differ by up to three decades, as of sites near and far from the magnets."""
    random = np.random.default_rng(magnets + 10 * sites)
    outcomes = set()
    for _ in range(12):
        S, r = (random.normal(size=shape) + 1j * random.normal(size=shape) for shape in ((sites, magnets), (sites,)))
        S *= 10.0 ** random.uniform(-3.0, 0.0, (sites, 1))
        limits = 10.0 ** random.uniform(-1.5, 0.0, sites) * np.abs(r)
        expected, found = by_linear_programming(r, S, limits), _smallest_currents(r, S, limits)
        outcomes.add(found is not None)
        assert (found is None) == (expected is None)
        if found is not None:
            assert np.abs(found).max() == pytest.approx(expected, rel=2e-4)
            assert (np.abs(r + S @ found) <= limits * (1.0 + 1e-6)).all()
    assert outcomes == ({True} if magnets >= sites else {True, False})


def test_a_magnet_holds_the_orbits_of_two_sites_within_their_limits():
    """|1 + I| <= 0.2 and |I - 0.1| <= 0.95: I = -0.8. The mean of both orbits is smaller at -0.45."""
    found = _smallest_currents(np.array([1.0, -0.1]), np.ones((2, 1)), np.array([0.2, 0.95]))
    assert found == pytest.approx([-0.8], rel=1e-6)


@pytest.mark.parametrize(
    ("are_free", "start", "expected"),
    [
        (lambda J: np.abs(1.0 + J.sum(axis=1)) <= 0.2, [-0.8, 0.0], 0.4),  # both halves of what one gives
        (lambda J: np.abs(J).prod(axis=1) >= 0.04, [1.0, 1.0j], 0.2),  # whose set is not convex
        (lambda J: np.abs(J[:, 0] + 0.3) <= 0.1, [-0.25, 0.9], 0.2),  # the second does nothing
        (lambda J: np.abs(J[:, 0] - 0.5j) + np.abs(J[:, 1] + 0.5) <= 0.2, [0.5j, -0.5], 0.4),
    ],
)
def test_the_search_finds_the_smallest_free_point(are_free, start, expected):
    found = _searched(np.array(start, dtype=complex), are_free)
    assert are_free(found[None])[0]
    assert np.abs(found).max() == pytest.approx(expected, rel=5e-3)


def test_the_search_keeps_a_free_rotor_as_it_is():
    assert not _searched(np.zeros(2, dtype=complex), lambda J: np.ones(len(J), dtype=bool)).any()
