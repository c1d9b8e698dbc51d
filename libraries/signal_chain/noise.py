"""Machine-independent random numbers: L'Ecuyer's MRG32k3a, with a state of six whole numbers.

    x_n = (1403580 x_(n-2) - 810728 x_(n-3)) mod m_1,   m_1 = 2^32 - 209
    y_n = (527612 y_(n-1) - 1370589 y_(n-3)) mod m_2,   m_2 = 2^32 - 22853
    u_n = ((x_n - y_n) mod m_1) / (m_1 + 1)

Every product is below 2^53, so float64 represents it exactly. P. L'Ecuyer, "Good parameters and implementations for
combined multiple recursive random number generators", Operations Research 47 (1999).
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record

STREAM = record(("x", "f8", (3,)), ("y", "f8", (3,)))  # the last three of each, oldest first
M_1, M_2 = 4294967087.0, 4294944443.0
MULTIPLIER, MODULUS = 69069.0, 4294967296.0  # of the congruential generator that spreads a seed


@kernel
def start_stream(stream: np.record, seed: float) -> None:
    """Initialise a stream of random numbers, record STREAM, from a whole number."""
    value = seed
    for _ in range(8):
        value = (MULTIPLIER * value + 1.0) % MODULUS
    for i in range(3):
        value = (MULTIPLIER * value + 1.0) % MODULUS
        stream.x[i] = 1.0 + value % (M_2 - 1.0)
    for i in range(3):
        value = (MULTIPLIER * value + 1.0) % MODULUS
        stream.y[i] = 1.0 + value % (M_2 - 1.0)


@kernel
def remainder(value: float, modulus: float) -> float:
    """Return `value` modulo `modulus`, in [0, modulus); the result is exact for whole numbers below 2^53."""
    rest = value - math.floor(value / modulus) * modulus
    return rest + modulus if rest < 0.0 else rest


@kernel
def uniform(stream: np.record) -> float:
    """Return the next number of a stream, uniformly distributed in (0, 1)."""
    x, y = stream.x, stream.y
    next_x = remainder(1403580.0 * x[1] - 810728.0 * x[0], M_1)
    next_y = remainder(527612.0 * y[2] - 1370589.0 * y[0], M_2)
    x[0], x[1], x[2] = x[1], x[2], next_x
    y[0], y[1], y[2] = y[1], y[2], next_y
    difference = next_x - next_y if next_x > next_y else next_x - next_y + M_1
    u: float = difference / (M_1 + 1.0)
    return u


@kernel
def normal_pair(stream: np.record) -> tuple[float, float]:
    """Return two normally distributed numbers of a stream, with mean 0 and standard deviation 1 (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(uniform(stream)))
    angle = 2.0 * math.pi * uniform(stream)
    return radius * math.cos(angle), radius * math.sin(angle)
