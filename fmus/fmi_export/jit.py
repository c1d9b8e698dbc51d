"""The one decorator of every model kernel: compiled by numba where numba is installed, plain Python elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])

try:
    import numba
except ImportError:  # the kernels are ordinary Python too, only slower
    numba = None

COMPILED = numba is not None


def kernel(function: F) -> F:
    """Compile `function` in numba's nopython mode, with IEEE division and an on-disk cache.

    A kernel takes flat float64 arrays and scalars, allocates nothing and raises nothing: the same source is
    later compiled into FMUs that need no Python.
    """
    if numba is None:
        return function
    compiled: F = numba.njit(cache=True, error_model="numpy")(function)
    return compiled
