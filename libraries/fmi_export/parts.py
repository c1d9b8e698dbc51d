"""Views into flat arrays at positions known only at run time."""

from __future__ import annotations

import math
from typing import Any

from fmi_export.jit import COMPILED
from fmi_export.model import Array


def part(array: Array, start: int, dtype: Any, shape: Any) -> Any:
    """Return the numbers of a contiguous array, beginning at `start`, as a view of another type and shape.

    In kernels, the function does not check bounds, and costs nothing if its result is not used. Slices, `view` and
    `reshape` would do the same with divisions and branches, which take longer than a short kernel.

    Parameters
    ----------
    array
        Array of any shape, in row order.
    start
        Index of the first number, from 0.
    dtype
        A record type, complex128 or float64; it must be a global constant.
    shape
        An int, or a tuple of two or three ints.
    """
    sizes = shape if isinstance(shape, tuple) else (shape,)
    size = math.prod(sizes) * dtype.itemsize // 8
    return array.reshape(-1)[start : start + size].view(dtype).reshape(sizes)


def clear(array: Any) -> None:
    """Set all numbers of a contiguous array to zero."""
    array[...] = 0.0


def copy_all(source: Any, target: Any) -> None:
    """Copy a contiguous array to another of the same shape and type; the two arrays must not overlap."""
    target[...] = source


if COMPILED:
    from fmi_export.numba_internals import lower_array_functions

    lower_array_functions(part, clear, copy_all)
