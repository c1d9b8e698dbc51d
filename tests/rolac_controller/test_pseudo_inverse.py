"""H of a receptance in the controller itself, against NumPy's pseudo-inverse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rig import SIZES

from amb_cosim.model_constants.controller_data import condition_number, inverse_receptance
from rolac_controller.pseudo_inverse import negative_pseudo_inverse, svd_work_of, svd_work_size
from rolac_controller.signals import LARGEST_CONDITION


def inverted(r, weights=None):
    """H and the condition number that the kernel finds."""
    H, svd = np.full((4, 8), np.nan, dtype=complex), svd_work_of(np.full(svd_work_size(SIZES), np.nan), 0, SIZES)
    w = np.ones(8) if weights is None else np.asarray(weights, dtype=float)
    condition = negative_pseudo_inverse(np.ascontiguousarray(r, dtype=complex), w, H, svd)
    return H, condition


@given(st.integers(0, 10**6), st.floats(-9.0, 3.0), st.floats(0.0, 3.9))
def test_h_and_condition_number_agree_with_numpy(seed, size, spread):
    """Receptances of all sizes, with singular values over up to four decades, and weights."""
    rng = np.random.default_rng(seed)
    u, _, v = np.linalg.svd(rng.normal(size=(8, 4)) + 1j * rng.normal(size=(8, 4)), full_matrices=False)
    r = 10.0**size * u * 10.0 ** (-spread * np.linspace(0.0, 1.0, 4)) @ v
    weights = rng.uniform(0.8, 1.2, size=8)
    root = np.sqrt(weights)
    weighted = root[:, None] * r
    if condition_number(weighted) > 1e4:
        return
    h, condition = inverted(r, weights)
    expected = inverse_receptance(weighted) * root
    assert np.abs(h - expected).max() < 1e-14 * 10.0**spread * np.abs(expected).max() * 100.0
    assert condition == pytest.approx(condition_number(weighted), rel=1e-10)


def test_small_singular_values_keep_their_digits():
    """Rotations, unlike a product R^H R, lose no digits if columns differ greatly in size."""
    rng = np.random.default_rng(3)
    r = (rng.normal(size=(8, 4)) + 1j * rng.normal(size=(8, 4))) * [1.0, 1e-5, 1e-9, 1e-12]
    h, condition = inverted(r)
    np.testing.assert_allclose(h @ r, -np.eye(4), atol=1e-3)
    assert condition == pytest.approx(condition_number(r), rel=1e-6)


@pytest.mark.parametrize("columns", [[0, 0, 1, 2], [0, 1, 2, 2]])
def test_dependent_forces_are_singular(receptance, columns):
    h, condition = inverted(receptance[:, columns])
    assert condition > 1e14
    assert np.isfinite(h).all()


def test_no_response_at_all_is_singular():
    h, condition = inverted(np.zeros((8, 4)))
    assert condition == LARGEST_CONDITION
    assert not h.any()


def test_too_few_weighted_sensors_are_singular(receptance):
    assert inverted(receptance, [1, 1, 1, 0, 0, 0, 0, 0])[1] > 1e14
    assert inverted(receptance, [1, 1, 1, 1, 0, 0, 0, 0])[1] < 1e3


def test_real_orthogonal_columns_need_no_rotation():
    h, condition = inverted(2.0 * np.eye(8, 4))
    np.testing.assert_array_equal(h, -0.5 * np.eye(4, 8))
    assert condition == 1.0
