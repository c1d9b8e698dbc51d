"""Random numbers that are the same on every machine: L'Ecuyer's MRG32k3a, whose state is six whole numbers.

    x_n = (1403580 x_(n-2) - 810728 x_(n-3)) mod m_1,   m_1 = 2^32 - 209
    y_n = (527612 y_(n-1) - 1370589 y_(n-3)) mod m_2,   m_2 = 2^32 - 22853
    u_n = ((x_n - y_n) mod m_1) / (m_1 + 1)

Every product is below 2^53, so float64 holds it exactly. P. L'Ecuyer, "Good parameters and implementations for combined
multiple recursive random number generators", Operations Research 47 (1999).
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array

N_STREAM = 6
M_1, M_2 = 4294967087.0, 4294944443.0
MULTIPLIER, MODULUS = 69069.0, 4294967296.0  # of the congruential generator that spreads a seed


@kernel
def seed(stream: Array, number: float) -> None:
    """Set a stream, shape (N_STREAM,), to the start that belongs to a whole number."""
    x = number
    for _ in range(8):
        x = (MULTIPLIER * x + 1.0) % MODULUS
    for i in range(N_STREAM):
        x = (MULTIPLIER * x + 1.0) % MODULUS
        stream[i] = 1.0 + x % (M_2 - 1.0)


@kernel
def remainder(value: float, modulus: float) -> float:
    """`value` modulo `modulus` in [0, modulus), exact for whole numbers below 2^53."""
    rest = value - math.floor(value / modulus) * modulus
    return rest + modulus if rest < 0.0 else rest


@kernel
def uniform(stream: Array) -> float:
    """Next number of a stream, in (0, 1)."""
    x = remainder(1403580.0 * stream[1] - 810728.0 * stream[0], M_1)
    y = remainder(527612.0 * stream[5] - 1370589.0 * stream[3], M_2)
    stream[0], stream[1], stream[2] = stream[1], stream[2], x
    stream[3], stream[4], stream[5] = stream[4], stream[5], y
    difference = x - y if x > y else x - y + M_1
    u: float = difference / (M_1 + 1.0)
    return u


@kernel
def normal_pair(stream: Array) -> tuple[float, float]:
    """Next two numbers of a stream that are normally distributed, mean 0 and deviation 1 (Box and Muller)."""
    radius = math.sqrt(-2.0 * math.log(uniform(stream)))
    angle = 2.0 * math.pi * uniform(stream)
    return radius * math.cos(angle), radius * math.sin(angle)
