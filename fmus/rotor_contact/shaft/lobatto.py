"""Lobatto's quadrature with four points, and the cubic polynomials through them, over 0 <= s <= 1.

s_1,2 = (1 -+ 1/sqrt 5)/2,    int_0^1 f ds = (f_0 + 5 f_1 + 5 f_2 + f_3)/12        exact to degree 5
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array

N_LOBATTO = 4
N_LOOKS = 32  # points at which the sign of a cubic is checked
MOST_TRIALS, ROUNDING = 60, 1e-15  # of the iteration to its root
LOBATTO_POINTS = (0.0, 0.5 - 0.5 / math.sqrt(5.0), 0.5 + 0.5 / math.sqrt(5.0), 1.0)
LOBATTO_WEIGHTS = (1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0)

_FAR, _NEAR, _CUBIC = 2.5 * (math.sqrt(5.0) + 1.0), 2.5 * (math.sqrt(5.0) - 1.0), 5.0 * math.sqrt(5.0)
# Coefficients of 1, s, s^2, s^3 of the polynomial that is 1 at a point and 0 at the others.
LAGRANGE = (
    (1.0, -6.0, 10.0, -5.0),
    (0.0, _FAR, -_FAR - _CUBIC, _CUBIC),
    (0.0, -_NEAR, _NEAR + _CUBIC, -_CUBIC),
    (0.0, 1.0, -5.0, 5.0),
)


def _lagrange(s: float) -> tuple[float, float, float, float]:
    """Return the four cubics l_m at s."""
    return tuple(sum(c * s**k for k, c in enumerate(row)) for row in LAGRANGE)  # type: ignore[return-value]


# The cubics at the Lobatto points of the first half, and at those of the part of that length that begins at s_i/2.
FIRST_HALF = tuple(_lagrange(0.5 * c) for c in LOBATTO_POINTS)
SECOND_PART = tuple(tuple(_lagrange(0.5 * (c + s)) for s in LOBATTO_POINTS) for c in LOBATTO_POINTS[1:])


@kernel
def _coefficients(f_0: float, f_1: float, f_2: float, f_3: float) -> tuple[float, float, float]:
    """Return the coefficients of s, s^2 and s^3 of the cubic through four values; the constant coefficient is f_0."""
    rise = f_3 - 6.0 * f_0 + _FAR * f_1 - _NEAR * f_2
    bend = 10.0 * f_0 - (_FAR + _CUBIC) * f_1 + (_NEAR + _CUBIC) * f_2 - 5.0 * f_3
    return rise, bend, 5.0 * (f_3 - f_0) + _CUBIC * (f_1 - f_2)


@kernel
def third_difference(f_0: float, f_1: float, f_2: float, f_3: float) -> float:
    """Return the magnitude of the coefficient of s^3 of the cubic through four values."""
    return abs(5.0 * (f_3 - f_0) + _CUBIC * (f_1 - f_2))


@kernel
def least_of_cubic(f_0: float, f_1: float, f_2: float, f_3: float) -> float:
    """Return a lower bound of the cubic through four values, namely its smallest Bezier point."""
    b_1 = (f_3 - 3.0 * f_0 + _FAR * f_1 - _NEAR * f_2) / 3.0
    b_2 = (f_0 - 3.0 * f_3 + _FAR * f_2 - _NEAR * f_1) / 3.0
    return min(min(f_0, f_3), min(b_1, b_2))


@kernel
def positive_share(f_0: float, f_1: float, f_2: float, f_3: float) -> float:
    """Return the share of the interval over which the cubic through four values is certainly positive.

    Zero crossings are sought between `N_LOOKS` points. If none is found, but a Bezier point is negative, the result is
    0.5.
    """
    if least_of_cubic(f_0, f_1, f_2, f_3) > 0.0:
        return 1.0
    if not f_0 > 0.0:
        return 0.0
    rise, bend, twist = _coefficients(f_0, f_1, f_2, f_3)
    before = f_0
    for look in range(1, N_LOOKS + 1):
        s = look / N_LOOKS
        f = f_0 + s * (rise + s * (bend + s * twist))
        if not f > 0.0:
            return (look - 1 + before / (before - f)) / N_LOOKS
        before = f
    return 0.5


@kernel
def first_fall(f_0: float, f_1: float, f_2: float, f_3: float) -> float:
    """Return the share of the interval at which the cubic through four values first falls through zero.

    The result is 2.0 if the cubic never falls through zero. A fall is sought between `N_LOOKS` points; the root is
    located to within rounding.
    """
    if least_of_cubic(f_0, f_1, f_2, f_3) > 0.0:
        return 2.0
    rise, bend, twist = _coefficients(f_0, f_1, f_2, f_3)
    for look in range(1, N_LOOKS + 1):
        high = look / N_LOOKS
        if f_0 + high * (rise + high * (bend + high * twist)) < 0.0:
            low, s = high - 1.0 / N_LOOKS, high
            for _ in range(MOST_TRIALS):
                f, slope = f_0 + s * (rise + s * (bend + s * twist)), rise + s * (2.0 * bend + 3.0 * s * twist)
                low, high = (s, high) if f > 0.0 else (low, s)
                last, s = s, s - f / slope if slope < 0.0 else high
                if not low < s < high:
                    s = 0.5 * (low + high)
                if abs(s - last) <= ROUNDING:
                    break
            return s
    return 2.0


@kernel
def value_at(f_0: float, f_1: float, f_2: float, f_3: float, s: float) -> float:
    """Return the value at s of the cubic through four values."""
    rise, bend, twist = _coefficients(f_0, f_1, f_2, f_3)
    return f_0 + s * (rise + s * (bend + s * twist))


@kernel
def restrict(f: Array, s: float) -> None:
    """Replace the values of a cubic at the Lobatto points of [0, 1] by its values at the points of [0, s]."""
    a, b, c, d = f[0], f[1], f[2], f[3]
    f[1] = value_at(a, b, c, d, s * LOBATTO_POINTS[1])
    f[2] = value_at(a, b, c, d, s * LOBATTO_POINTS[2])
    f[3] = value_at(a, b, c, d, s)


@kernel
def greatest_of_cubic(f_0: float, f_1: float, f_2: float, f_3: float) -> float:
    """Return the greatest value of the cubic through four values."""
    rise, bend, twist = _coefficients(f_0, f_1, f_2, f_3)
    return greatest_value(f_0, rise, bend, twist)


@kernel
def greatest_of_parabola(f_0: float, f_mid: float, f_1: float) -> float:
    """Return the greatest value of the parabola through values at both ends and the middle."""
    return greatest_value(f_0, 4.0 * f_mid - 3.0 * f_0 - f_1, 2.0 * (f_0 + f_1) - 4.0 * f_mid, 0.0)


@kernel
def greatest_value(c_0: float, c_1: float, c_2: float, c_3: float) -> float:
    """Return the greatest value of c_0 + c_1 s + c_2 s^2 + c_3 s^3 over 0 <= s <= 1.

    The slope falls through zero, c_1 + 2 c_2 s + 3 c_3 s^2 = 0, at s = c_1/(sqrt(c_2^2 - 3 c_1 c_3) - c_2).
    """
    greatest = max(c_0, c_0 + c_1 + c_2 + c_3)
    square = c_2 * c_2 - 3.0 * c_1 * c_3
    if square > 0.0:
        divisor = math.sqrt(square) - c_2
        if divisor != 0.0:
            s = c_1 / divisor
            if 0.0 < s < 1.0:
                greatest = max(greatest, c_0 + s * (c_1 + s * (c_2 + s * c_3)))
    return greatest
