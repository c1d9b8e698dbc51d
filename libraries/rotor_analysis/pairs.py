"""Coordinates in pairs, x and y of each plane, as complex numbers x + i y."""

from __future__ import annotations

import numpy as np

from array_types import Array

# Multiplication by -i on (x, y): the gyroscopic term of M r'' - i Omega G_1 r' + K r = f in real form.
MINUS_I = np.array([[0.0, 1.0], [-1.0, 0.0]])


def turned(size: int) -> Array:
    """Return J, which turns each pair x, y of `size` coordinates by a right angle (multiplies x + i y by i)."""
    return np.kron(np.eye(size // 2), -MINUS_I)


def times_turned(A: Array) -> Array:
    """Return A J with J from `turned`, by exchanging the columns of each pair and negating the second."""
    result = np.empty_like(A)
    result[:, ::2], result[:, 1::2] = A[:, 1::2], 0.0 - A[:, ::2]  # no -0.0
    return result
