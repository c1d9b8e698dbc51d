"""Copies and comparisons of numbers and flat arrays in kernels."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.parts import part

BITS = np.dtype(np.int64)


@kernel
def is_near(value: float, reference: float, tolerance: float) -> bool:
    """Return whether a value differs from a reference by at most the relative `tolerance`; false for NaN."""
    return abs(value - reference) <= tolerance * abs(reference)


@kernel
def copy(source: Array, target: Array) -> None:
    """Copy `source` to the beginning of `target`; the two arrays must not overlap.

    An assignment to a slice would do the same, but numba would allocate memory for it in case the arrays overlap.
    """
    for i in range(source.shape[0]):
        target[i] = source[i]


@kernel
def same_bits(a: Array, b: Array) -> bool:
    """Return whether two flat arrays of the same size are equal in every bit.

    The loop makes four independent comparisons at a time.
    """
    size = a.shape[0]
    p = q = r = s = np.int64(0)
    i = 0
    while i + 4 <= size:
        u, v = part(a, i, BITS, 4), part(b, i, BITS, 4)
        p |= u[0] ^ v[0]
        q |= u[1] ^ v[1]
        r |= u[2] ^ v[2]
        s |= u[3] ^ v[3]
        i += 4
    while i < size:
        p |= part(a, i, BITS, 1)[0] ^ part(b, i, BITS, 1)[0]
        i += 1
    return (p | q | r | s) == 0
