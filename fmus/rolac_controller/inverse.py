"""Receptance to the matrix H of the adaptive law, by a singular value decomposition.

    H = -(R^H W R)^-1 R^H W = -(W^(1/2) R)^+ W^(1/2)                                    (5.10)

One-sided Jacobi rotations make the columns of A = W^(1/2) R orthogonal; then A V = B, B^H B = Sigma^2 and
A^+ = V Sigma^-2 B^H. Rotations do not lose what a product A^H A would: small singular values stay accurate.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.names import N_AXES, N_SENSORS
from rolac_controller.signals import LARGEST_CONDITION

N_MATRIX = 2 * N_AXES * N_SENSORS  # re, im of R (8 x 4) or H (4 x 8), row by row
N_SCRATCH = N_MATRIX + 2 * N_AXES * N_AXES + N_AXES
ROTATIONS = N_MATRIX
SINGULAR = ROTATIONS + 2 * N_AXES * N_AXES
SWEEPS = 30
ORTHOGONAL = 1e-15


@kernel
def rotate(columns: Array, rows: int, p: int, q: int, c: float, s: float, cos: float, sin: float) -> None:
    """Columns a_p, a_q of a matrix with N_AXES columns to c a_p - s b, s a_p + c b with b = (cos - j sin) a_q."""
    for i in range(rows):
        at_p, at_q = 2 * (i * N_AXES + p), 2 * (i * N_AXES + q)
        p_re, p_im = columns[at_p], columns[at_p + 1]
        b_re = cos * columns[at_q] + sin * columns[at_q + 1]
        b_im = cos * columns[at_q + 1] - sin * columns[at_q]
        columns[at_p], columns[at_p + 1] = c * p_re - s * b_re, c * p_im - s * b_im
        columns[at_q], columns[at_q + 1] = s * p_re + c * b_re, s * p_im + c * b_im


@kernel
def orthogonalise(a: Array, v: Array) -> None:
    """Turn the columns of `a` orthogonal by rotations, and turn `v` along (Hestenes)."""
    for _ in range(SWEEPS):
        largest = 0.0
        for p in range(N_AXES - 1):
            for q in range(p + 1, N_AXES):
                size_p = size_q = re = im = 0.0
                for i in range(N_SENSORS):
                    at_p, at_q = 2 * (i * N_AXES + p), 2 * (i * N_AXES + q)
                    size_p += a[at_p] * a[at_p] + a[at_p + 1] * a[at_p + 1]
                    size_q += a[at_q] * a[at_q] + a[at_q + 1] * a[at_q + 1]
                    re += a[at_p] * a[at_q] + a[at_p + 1] * a[at_q + 1]
                    im += a[at_p] * a[at_q + 1] - a[at_p + 1] * a[at_q]
                product = math.hypot(re, im)
                if product <= ORTHOGONAL * math.sqrt(size_p * size_q):
                    continue
                largest = max(largest, product / math.sqrt(size_p * size_q))
                zeta = (size_q - size_p) / (2.0 * product)
                t = math.copysign(1.0, zeta) / (abs(zeta) + math.sqrt(1.0 + zeta * zeta))
                c = 1.0 / math.sqrt(1.0 + t * t)
                rotate(a, N_SENSORS, p, q, c, c * t, re / product, im / product)
                rotate(v, N_AXES, p, q, c, c * t, re / product, im / product)
        if largest == 0.0:
            return


@kernel
def invert(receptance: Array, weights: Array, h: Array, scratch: Array) -> float:
    """Matrix H of a receptance, and the condition number of the weighted receptance.

    Parameters
    ----------
    receptance
        R, re and im row by row, shape (N_MATRIX,): 8 sensors by 4 forces (m/N).
    weights
        Diagonal of W, shape (N_SENSORS,), non-negative.
    h
        Receives H, re and im row by row, shape (N_MATRIX,): 4 forces by 8 sensors (N/m); zeros if R is singular.
    scratch
        Shape (N_SCRATCH,).

    Returns
    -------
    float
        Largest singular value over smallest, at most LARGEST_CONDITION.
    """
    a, v, singular = scratch[:N_MATRIX], scratch[ROTATIONS:SINGULAR], scratch[SINGULAR:N_SCRATCH]
    for i in range(N_SENSORS):
        root = math.sqrt(weights[i])
        for j in range(2 * N_AXES):
            a[2 * N_AXES * i + j] = root * receptance[2 * N_AXES * i + j]
    v[:] = 0.0
    for j in range(N_AXES):
        v[2 * (j * N_AXES + j)] = 1.0
    orthogonalise(a, v)
    largest, smallest = 0.0, math.inf
    for j in range(N_AXES):
        total = 0.0
        for i in range(N_SENSORS):
            at = 2 * (i * N_AXES + j)
            total += a[at] * a[at] + a[at + 1] * a[at + 1]
        singular[j] = total
        largest, smallest = max(largest, total), min(smallest, total)
    h[:] = 0.0
    if smallest <= 0.0 or largest > smallest * LARGEST_CONDITION * LARGEST_CONDITION:
        return LARGEST_CONDITION
    for axis in range(N_AXES):
        for s in range(N_SENSORS):
            root = math.sqrt(weights[s])
            re = im = 0.0
            for j in range(N_AXES):
                at_v, at_a = 2 * (axis * N_AXES + j), 2 * (s * N_AXES + j)
                re += (v[at_v] * a[at_a] + v[at_v + 1] * a[at_a + 1]) / singular[j]
                im += (v[at_v + 1] * a[at_a] - v[at_v] * a[at_a + 1]) / singular[j]
            at = 2 * (axis * N_SENSORS + s)
            h[at], h[at + 1] = -root * re, -root * im
    return math.sqrt(largest / smallest)
