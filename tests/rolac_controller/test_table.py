"""The matrix H and its table."""

from __future__ import annotations

import numpy as np
import pytest

from rolac_controller.rolac import adapt
from rolac_controller.table import inverse_receptance, pack


def h_at(table, speed):
    """H that the adaptive law uses, column by column."""
    h = np.empty((4, 8), dtype=complex)
    for s in range(8):
        q, force = np.zeros(16), np.zeros(8)
        q[2 * s] = 1.0
        adapt(table, speed, 1.0, q, force)
        h[:, s] = force[::2] + 1j * force[1::2]
    return h


def test_h_is_the_negative_left_inverse_of_the_receptance(receptance):
    np.testing.assert_allclose(inverse_receptance(receptance) @ receptance, -np.eye(4), atol=1e-12)


def test_h_with_weights_solves_the_normal_equations(receptance):
    weights = np.array([1.0, 2.0, 0.0, 4.0, 0.5, 3.0, 1.0, 1.0])
    w = np.diag(weights)
    adjoint = receptance.conj().T
    expected = -np.linalg.solve(adjoint @ w @ receptance, adjoint @ w)
    np.testing.assert_allclose(inverse_receptance(receptance, weights), expected, rtol=1e-10, atol=1e-3)


def test_an_unweighted_sensor_does_not_count(receptance):
    h = inverse_receptance(receptance, [1, 1, 1, 0, 1, 1, 1, 1])
    assert not h[:, 3].any()


def test_singular_receptance_is_refused_by_its_condition_number(receptance):
    receptance[:, 3] = receptance[:, 2]
    with pytest.raises(ValueError, match="condition number"):
        inverse_receptance(receptance)


def test_ill_conditioned_receptance_is_refused_with_the_number(receptance):
    u, s, v = np.linalg.svd(receptance, full_matrices=False)
    s[-1] = s[0] / 3e5
    with pytest.raises(ValueError, match=r"condition number 3e\+05"):
        inverse_receptance(u * s @ v)


def test_receptance_of_wrong_shape_is_refused(receptance):
    with pytest.raises(ValueError, match=r"\(4, 8\)"):
        inverse_receptance(receptance.T)


@pytest.mark.parametrize("weights", [np.ones(4), [1, 1, 1, 1, 1, 1, 1, -1], [1, 1, 1, 1, 1, 1, 1, np.nan]])
def test_bad_weights_are_refused(receptance, weights):
    with pytest.raises(ValueError, match="weights"):
        inverse_receptance(receptance, weights)


@pytest.mark.parametrize("speeds", [[2.0, 1.0], [1.0, 1.0], [0.0, 1.0], [1.0, np.nan]])
def test_speeds_that_do_not_ascend_are_refused(receptance, speeds):
    with pytest.raises(ValueError, match="ascending"):
        pack(speeds, [receptance, receptance])


def test_number_of_receptances_must_match_the_speeds(receptance):
    with pytest.raises(ValueError, match="2 speeds need"):
        pack([1.0, 2.0], [receptance])


def test_a_receptance_that_cannot_be_inverted_names_its_speed(receptance):
    with pytest.raises(ValueError, match=r"at 62\.5 rad/s.*condition"):
        pack([30.0, 62.5], [receptance, 0.0 * receptance])


def test_table_gives_h_at_its_speeds_exactly_and_linearly_between(receptance):
    speeds = np.array([31.4, 62.8, 157.0])
    receptances = np.array([receptance, 1j * receptance + 1e-7, 0.3 * receptance - 2e-7j])
    table = pack(speeds, receptances)
    h = [inverse_receptance(r) for r in receptances]
    for k in range(3):
        np.testing.assert_array_equal(h_at(table, speeds[k]), h[k])
    np.testing.assert_allclose(h_at(table, 62.8 + 0.25 * 94.2), 0.75 * h[1] + 0.25 * h[2], rtol=1e-12)


def test_table_is_constant_beyond_its_ends(receptance):
    table = pack([50.0, 100.0], [receptance, 2.0 * receptance])
    np.testing.assert_array_equal(h_at(table, 10.0), h_at(table, 50.0))
    np.testing.assert_array_equal(h_at(table, 500.0), h_at(table, 100.0))


def test_table_of_one_speed_serves_all(receptance):
    table = pack([50.0], [receptance])
    for speed in (1.0, 50.0, 300.0):
        np.testing.assert_array_equal(h_at(table, speed), inverse_receptance(receptance))
