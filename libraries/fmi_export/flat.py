"""Copies between flat arrays of kernels."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array


@kernel
def copy(source: Array, target: Array) -> None:
    """Write `source` into the beginning of `target`; the two must not overlap.

    An assignment to a slice would do the same, but numba prepares it for overlapping arrays by an allocation.
    """
    for i in range(source.shape[0]):
        target[i] = source[i]
