"""Products with matrices that were interpolated between two speeds have the bits of those that interpolate."""

import numpy as np
import pytest

from rotor_contact.shaft.products import (
    combination,
    combination_between,
    interpolate,
    isotropic_combination,
    isotropic_combination_between,
    isotropic_dots,
    isotropic_dots_between,
)

ROWS, COLUMNS = 30, 24


@pytest.fixture
def case():
    """Rows of responses to x and y, the latter those to x turned by a right angle."""
    rng = np.random.default_rng(3)
    matrices = rng.normal(size=(2, ROWS, COLUMNS))
    for A in matrices:
        for j in range(0, ROWS, 2):
            A[j + 1, ::2], A[j + 1, 1::2] = -A[j, 1::2], A[j, ::2]
    return rng.normal(size=ROWS), *matrices, 0.3


def interpolated(low, high, share):
    result = np.empty_like(low)
    interpolate(low.ravel(), high.ravel(), share, result.ravel(), low.size)
    return result


@pytest.mark.parametrize("first", [0, 6])
def test_combinations_of_interpolated_rows_have_the_bits_of_both(case, first):
    x, low, high, share = case
    size, A = COLUMNS - first, interpolated(*case[1:])
    general, between, turned = np.empty((3, size))
    combination(x, A, general, first, size)
    combination_between(x, low, high, share, between, first, size)
    np.testing.assert_array_equal(general, between)
    np.testing.assert_allclose(general, x @ A[:, first:], rtol=1e-12, atol=1e-12)
    isotropic, isotropic_between = np.empty((2, size))
    isotropic_combination(x, A, isotropic, turned, first, size)
    isotropic_combination_between(x, low, high, share, isotropic_between, turned, first, size)
    np.testing.assert_array_equal(isotropic, isotropic_between)
    np.testing.assert_allclose(isotropic, x @ A[:, first:], rtol=1e-12, atol=1e-12)


def test_dots_of_turned_pairs_follow_from_one_row(case):
    x, low, high, share = case
    A = interpolated(low, high, share)
    for y, of_low, of_high in zip(A[:8, :22], low, high, strict=False):
        turned = np.empty(22)
        turned[::2], turned[1::2] = x[1:22:2], -x[0:22:2]
        dots = isotropic_dots(y, x[:22])
        assert dots == pytest.approx(complex(y @ x[:22], y @ turned), abs=1e-12)
        assert dots == isotropic_dots_between(of_low[:22], of_high[:22], share, x[:22])
