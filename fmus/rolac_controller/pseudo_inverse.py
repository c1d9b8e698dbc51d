"""Computes the matrix H of the adaptive law from the receptance, by a singular value decomposition.

    H = -(R^H W R)^-1 R^H W = -(W^(1/2) R)^+ W^(1/2)                                    (5.10)

One-sided Jacobi rotations V make the columns of A = W^(1/2) R orthogonal; then A V = B, B^H B = Sigma^2 and A^+ = V
Sigma^-2 B^H. Rotations keep small singular values accurate; forming the product A^H A would not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rolac_controller.complex_numbers import COMPLEX, REAL, Complex, divided, squared_magnitude
from rolac_controller.signals import LARGEST_CONDITION
from rolac_controller.sizes import Sizes

MAX_SWEEPS = 30
ORTHOGONAL = 1e-15


class SvdWork(NamedTuple):
    """Scratch arrays of a decomposition: the product A V, shape (n_sensors, n_axes); V; the squares of the singular
    values.
    """

    B: Complex
    V: Complex
    sigma_squared: Array


@views
def svd_work_size(sizes: Sizes) -> int:
    """Return the size of a decomposition's scratch arrays."""
    return 2 * sizes.n_axes * (sizes.n_sensors + sizes.n_axes) + sizes.n_axes


@views
def svd_work_of(array: Array, start: int, sizes: Sizes) -> SvdWork:
    """Return a decomposition's scratch arrays as views into an array, beginning at `start`."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    V = start + 2 * n_sensors * n_axes
    return SvdWork(
        part(array, start, COMPLEX, (n_sensors, n_axes)),
        part(array, V, COMPLEX, (n_axes, n_axes)),
        part(array, V + 2 * n_axes * n_axes, REAL, n_axes),
    )


@kernel
def rotate(columns: Complex, p: int, q: int, cos: float, sin: float, direction: complex) -> None:
    """Replace columns a_p, a_q of a matrix by `cos` a_p - `sin` b, `sin` a_p + `cos` b; b = a_q conj(direction)."""
    for i in range(columns.shape[0]):
        a, b = columns[i, p], direction.conjugate() * columns[i, q]
        columns[i, p] = cos * a - sin * b
        columns[i, q] = sin * a + cos * b


@kernel
def orthogonalise(B: Complex, V: Complex) -> None:
    """Make the columns of B orthogonal by rotations, and apply the same rotations to V (Hestenes' method)."""
    n_sensors, n_axes = B.shape
    for _ in range(MAX_SWEEPS):
        largest = 0.0
        for p in range(n_axes - 1):
            for q in range(p + 1, n_axes):
                product, size_p, size_q = 0j, 0.0, 0.0
                for i in range(n_sensors):
                    size_p += squared_magnitude(B[i, p])
                    size_q += squared_magnitude(B[i, q])
                    product += B[i, p].conjugate() * B[i, q]
                size = abs(product)
                if size <= ORTHOGONAL * math.sqrt(size_p * size_q):
                    continue
                largest = max(largest, size / math.sqrt(size_p * size_q))
                zeta = (size_q - size_p) / (2.0 * size)
                tan = math.copysign(1.0, zeta) / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
                cos = 1.0 / math.sqrt(1.0 + tan * tan)
                direction = divided(product, size)
                rotate(B, p, q, cos, cos * tan, direction)
                rotate(V, p, q, cos, cos * tan, direction)
        if largest == 0.0:
            return


@kernel
def negative_pseudo_inverse(R: Complex, weights: Array, H: Complex, svd: SvdWork) -> float:
    """Compute the matrix H of a receptance; return the condition number of the weighted receptance.

    The condition number is the ratio of the largest to the smallest singular value, at most LARGEST_CONDITION.

    Parameters
    ----------
    R
        Receptance, shape (n_sensors, n_axes) (m/N).
    weights
        Diagonal of W, shape (n_sensors,), non-negative.
    H
        Receives the matrix H, shape (n_axes, n_sensors) (N/m); all zeros if R is singular.
    svd
        Overwritten.
    """
    n_sensors, n_axes = R.shape
    B, V, sigma_squared = svd.B, svd.V, svd.sigma_squared
    for s in range(n_sensors):
        for j in range(n_axes):
            B[s, j] = math.sqrt(weights[s]) * R[s, j]
    for i in range(n_axes):
        for j in range(n_axes):
            V[i, j] = 1.0 if i == j else 0.0
    orthogonalise(B, V)
    largest, smallest = 0.0, math.inf
    for j in range(n_axes):
        sigma_squared[j] = 0.0
        for s in range(n_sensors):
            sigma_squared[j] += squared_magnitude(B[s, j])
        largest, smallest = max(largest, sigma_squared[j]), min(smallest, sigma_squared[j])
    H[:] = 0.0
    if smallest <= 0.0 or largest > smallest * LARGEST_CONDITION * LARGEST_CONDITION:
        return LARGEST_CONDITION
    for axis in range(n_axes):
        for s in range(n_sensors):
            total = 0j
            for j in range(n_axes):
                total += divided(V[axis, j] * B[s, j].conjugate(), sigma_squared[j])
            H[axis, s] = -math.sqrt(weights[s]) * total
    return math.sqrt(largest / smallest)
