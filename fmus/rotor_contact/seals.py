"""Seals and passive bearings: full stiffness and damping, cross-coupled, that depend on the spin speed.

    f = -(K(Omega) q + C(Omega) q'),   q = (x, y) of the shaft there, f the force on it            (1)

K = [[k, Q], [-Q, k]] with Q > 0 drives forward whirl. Their mass is in that of the shaft. K and C are cubics in Omega
piece by piece, constant below the first speed of a table and beyond its last. Such a stiffness need not have a
potential: -v . K q counts as work on the rotor, v . C v as heat.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.records import record, size_of

# A seal over a range of speeds: the speed (rad/s) from which on it is so, the row of its x, the ends of its own table
# (infinite without one), and of K_xx, K_xy, K_yx, K_yy (N/m), C_xx, ..., C_yy (N s/m) four coefficients each, of the
# cubic in the speed beyond `begin`, the constant one first. The first range has those below all speeds.
SEAL = record(
    ("begin", np.float64),
    ("row", np.float64),
    ("lowest", np.float64),
    ("highest", np.float64),
    ("coefficients", np.float64, 32),
)
N_SEAL = size_of(SEAL)
ISOTROPY_TOLERANCE = 1e-12  # of the largest coefficient

Seals = np.ndarray[tuple[int, int], np.dtype[np.record]]  # over ranges of speeds and seals


class SealCoefficients(NamedTuple):
    """K (N/m) and C (N s/m) of a seal at a speed, and the row of its x."""

    row: int
    k_xx: float
    k_xy: float
    k_yx: float
    k_yy: float
    c_xx: float
    c_xy: float
    c_yx: float
    c_yy: float


@kernel
def seal_at(seals: Seals, k: int, Omega: float) -> SealCoefficients:
    """Return the coefficients of seal k at a spin speed (rad/s)."""
    place = 0
    while place + 1 < seals.shape[0] and Omega >= seals[place + 1, k].begin:
        place += 1
    seal = seals[place, k]
    a, t = seal.coefficients, Omega - seal.begin
    return SealCoefficients(
        int(seal.row),
        _cubic(a, 0, t),
        _cubic(a, 4, t),
        _cubic(a, 8, t),
        _cubic(a, 12, t),
        _cubic(a, 16, t),
        _cubic(a, 20, t),
        _cubic(a, 24, t),
        _cubic(a, 28, t),
    )


@kernel
def _cubic(a: Array, at: int, t: float) -> float:
    value: float = a[at] + t * (a[at + 1] + t * (a[at + 2] + t * a[at + 3]))
    return value


@kernel
def add_seals(Minv: Array, seals: Seals, Omega: float, K_columns: Array, C_columns: Array) -> None:
    """Add M^-1 K and M^-1 C of all seals at a speed (rad/s) to matrices whose row j is column j."""
    for k in range(seals.shape[1]):
        s = seal_at(seals, k, Omega)
        x, y = s.row, s.row + 1
        for i in range(Minv.shape[0]):
            of_x, of_y = Minv[x, i], Minv[y, i]
            K_columns[x, i] += of_x * s.k_xx + of_y * s.k_yx
            K_columns[y, i] += of_x * s.k_xy + of_y * s.k_yy
            C_columns[x, i] += of_x * s.c_xx + of_y * s.c_yx
            C_columns[y, i] += of_x * s.c_xy + of_y * s.c_yy


@kernel
def add_change_of_seals(Minv: Array, seals: Seals, before: float, Omega: float, q: Array, v: Array, a: Array) -> None:
    """Add to accelerations `a` by how much those of the seals differ at a speed from those at the speed `before`."""
    for k in range(seals.shape[1]):
        s, t = seal_at(seals, k, before), seal_at(seals, k, Omega)
        x, y = s.row, s.row + 1
        f_x = (s.k_xx - t.k_xx) * q[x] + (s.k_xy - t.k_xy) * q[y] + (s.c_xx - t.c_xx) * v[x] + (s.c_xy - t.c_xy) * v[y]
        f_y = (s.k_yx - t.k_yx) * q[x] + (s.k_yy - t.k_yy) * q[y] + (s.c_yx - t.c_yx) * v[x] + (s.c_yy - t.c_yy) * v[y]
        for i in range(Minv.shape[0]):
            a[i] += Minv[x, i] * f_x + Minv[y, i] * f_y


@kernel
def add_missed_between_speeds(
    Minv: Array, seals: Seals, low: float, high: float, Omega: float, h: float, z: Array, z_new: Array, n: int
) -> None:
    """Add to z_new what the coefficients at a speed give in a time h (s) beyond those between the speeds low and high.

        a = -M^-1 (dK (q + q_new)/2 + dC (v + v_new)/2),  v_new += h a,  q_new += h^2 a/2            (2)

    with dK = K(Omega) - (1 - s) K(low) - s K(high) at the share s from low to high, likewise dC. What it leaves out is
    of the order of (omega h)^2/12 of this, at a frequency omega of the motion.

    Parameters
    ----------
    Minv, seals
        M^-1 of the shaft (1/kg), shape (m, m), and the seals.
    low, high, Omega
        Speeds (rad/s); the last is between the others.
    h
        Time from z to z_new (s).
    z, z_new, n
        States that begin with displacements (m), with velocities (m/s) from n on.
    """
    s = (Omega - low) / (high - low)
    for k in range(seals.shape[1]):
        at, a, b = seal_at(seals, k, Omega), seal_at(seals, k, low), seal_at(seals, k, high)
        x, y = at.row, at.row + 1
        q_x, q_y = 0.5 * (z[x] + z_new[x]), 0.5 * (z[y] + z_new[y])
        v_x, v_y = 0.5 * (z[n + x] + z_new[n + x]), 0.5 * (z[n + y] + z_new[n + y])
        f_x = _missed(at.k_xx, a.k_xx, b.k_xx, s) * q_x + _missed(at.k_xy, a.k_xy, b.k_xy, s) * q_y
        f_x += _missed(at.c_xx, a.c_xx, b.c_xx, s) * v_x + _missed(at.c_xy, a.c_xy, b.c_xy, s) * v_y
        f_y = _missed(at.k_yx, a.k_yx, b.k_yx, s) * q_x + _missed(at.k_yy, a.k_yy, b.k_yy, s) * q_y
        f_y += _missed(at.c_yx, a.c_yx, b.c_yx, s) * v_x + _missed(at.c_yy, a.c_yy, b.c_yy, s) * v_y
        for i in range(Minv.shape[0]):
            gain = -h * (Minv[x, i] * f_x + Minv[y, i] * f_y)
            z_new[n + i] += gain
            z_new[i] += 0.5 * h * gain


@kernel
def _missed(value: float, low: float, high: float, share: float) -> float:
    """Return by how much a value differs from that on the line between two others."""
    return value - low - share * (high - low)


@kernel
def seal_power(seals: Seals, Omega: float, q: Array, v: Array) -> tuple[float, float, float]:
    """Return the heat per second v . C v of all seals, the power -v . K q of their stiffness, and of it what its skew
    part gives (W).
    """
    heat = power = of_skew = 0.0
    for k in range(seals.shape[1]):
        s = seal_at(seals, k, Omega)
        x, y, v_x, v_y = q[s.row], q[s.row + 1], v[s.row], v[s.row + 1]
        heat += v_x * (s.c_xx * v_x + s.c_xy * v_y) + v_y * (s.c_yx * v_x + s.c_yy * v_y)
        power -= v_x * (s.k_xx * x + s.k_xy * y) + v_y * (s.k_yx * x + s.k_yy * y)
        of_skew += 0.5 * (s.k_xy - s.k_yx) * (v_y * x - v_x * y)
    return heat, power, of_skew


@kernel
def slopes_of_seal_power(seals: Seals, Omega: float, q: Array, v: Array, a: Array) -> tuple[float, float]:
    """Return how fast the heat per second, and the power of the skew stiffness, change (W/s)."""
    heat = of_skew = 0.0
    for k in range(seals.shape[1]):
        s = seal_at(seals, k, Omega)
        v_x, v_y, a_x, a_y = v[s.row], v[s.row + 1], a[s.row], a[s.row + 1]
        cross = s.c_xy + s.c_yx
        heat += a_x * (2.0 * s.c_xx * v_x + cross * v_y) + a_y * (cross * v_x + 2.0 * s.c_yy * v_y)
        of_skew += 0.5 * (s.k_xy - s.k_yx) * (a_y * q[s.row] - a_x * q[s.row + 1])
    return heat, of_skew


@kernel
def stored_by_seals(seals: Seals, Omega: float, q: Array) -> float:
    """Return q . K q/2 (J) of all seals, to which their skew stiffness adds nothing."""
    energy = 0.0
    for k in range(seals.shape[1]):
        s = seal_at(seals, k, Omega)
        x, y = q[s.row], q[s.row + 1]
        energy += 0.5 * (s.k_xx * x * x + (s.k_xy + s.k_yx) * x * y + s.k_yy * y * y)
    return energy


@kernel
def seals_are_isotropic(seals: Seals) -> bool:
    """Return whether all seals answer in y as in x, turned by a right angle, at all speeds."""
    for place in range(seals.shape[0]):
        for k in range(seals.shape[1]):
            a = seals[place, k].coefficients
            for at in range(0, 32, 16):
                for power in range(at, at + 4):
                    xx, xy, yx, yy = a[power], a[power + 4], a[power + 8], a[power + 12]
                    largest = max(max(abs(xx), abs(xy)), max(abs(yx), abs(yy)))
                    if max(abs(xx - yy), abs(xy + yx)) > ISOTROPY_TOLERANCE * largest:
                        return False
    return True
