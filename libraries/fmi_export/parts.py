"""Views into flat arrays at positions known only at run time."""

from __future__ import annotations

import math
from typing import Any

from fmi_export.jit import COMPILED
from fmi_export.model import Array


def part(array: Array, start: int, dtype: Any, shape: Any) -> Any:
    """Return the numbers of a contiguous array from `start` on as an array of another type and shape, without a copy.

    In kernels it costs nothing if the result is not used, and does not check bounds; slices, `view` and `reshape` would
    do the same with divisions and branches, which takes longer than a short kernel.

    Parameters
    ----------
    array
        Array of any shape, in row order.
    start
        Index of the first number, from 0.
    dtype
        A record type or complex128 or float64; a global constant.
    shape
        An int, or a tuple of two or three.
    """
    sizes = shape if isinstance(shape, tuple) else (shape,)
    size = math.prod(sizes) * dtype.itemsize // 8
    return array.reshape(-1)[start : start + size].view(dtype).reshape(sizes)


def clear(array: Any) -> None:
    """Set all numbers of a contiguous array to zero."""
    array[...] = 0.0


def copy_all(source: Any, target: Any) -> None:
    """Copy a contiguous array into another of the same shape and type; the two must not overlap."""
    target[...] = source


if COMPILED:
    from fmi_export.numba_internals import lower_array_functions

    lower_array_functions(part, clear, copy_all)
