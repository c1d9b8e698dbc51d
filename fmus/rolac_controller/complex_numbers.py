"""Complex arithmetic that gives the same bits in compiled code and in plain Python.

Products and sums of Python's complex numbers always give the same bits. Quotients do not, because numba, C and Python
divide complex numbers differently.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from fmi_export.jit import kernel

Complex = NDArray[np.complex128]
COMPLEX, REAL = np.dtype(np.complex128), np.dtype(np.float64)


@kernel
def phasor(angle: float) -> complex:
    """Return exp(j angle) for an angle in rad."""
    return complex(math.cos(angle), math.sin(angle))


@kernel
def squared_magnitude(z: complex) -> float:
    """Return |z|^2."""
    return z.real * z.real + z.imag * z.imag


@kernel
def scaled(z: complex, factor: float) -> complex:
    """Return z times a real factor, computed with two products; z * factor takes four."""
    return complex(z.real * factor, z.imag * factor)


@kernel
def divided(z: complex, divisor: float) -> complex:
    """Return z divided by a real divisor."""
    return complex(z.real / divisor, z.imag / divisor)


@kernel
def quotient(a: complex, b: complex) -> complex:
    """Return a/b, computed as a conj(b)/|b|^2."""
    return divided(a * b.conjugate(), squared_magnitude(b))
