"""Seals and passive bearings: full, cross-coupled stiffness and damping that depend on the spin speed.

    f = -(K(Omega) q + C(Omega) q'),   q = (x, y) of the shaft there, f the force on the shaft    (1)

K = [[k, Q], [-Q, k]] with Q > 0 drives forward whirl. The mass of the seals is included in the mass of the shaft. K and
C are piecewise cubic in Omega, and constant outside the speeds of a table. Because such a stiffness need not have a
potential, -v^T K q counts as work on the rotor, while v^T C v counts as heat. A seal may be anywhere on the shaft. Its
x and y are therefore S q, which replaces q in (1), with two rows of numbers S. Its force f causes the acceleration M^-1
S^T f.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.records import record, size_of

# A seal over a range of speeds: the speed (rad/s) at which the range begins, the ends of the seal's own table
# (infinite without one), and for each of K_xx, K_xy, K_yx, K_yy (N/m), C_xx, ..., C_yy (N s/m) the four coefficients of
# the cubic in the speed beyond `begin`, the constant first. The first range is that below all speeds.
SEAL = record(("begin", np.float64), ("lowest", np.float64), ("highest", np.float64), ("coefficients", np.float64, 32))
N_SEAL = size_of(SEAL)
ISOTROPY_TOLERANCE = 1e-12  # of the largest coefficient

SealRecords = np.ndarray[tuple[int, int], np.dtype[np.record]]  # over ranges of speeds and seals


class Seals(NamedTuple):
    """The seals of a rotor with n degrees of freedom."""

    records: SealRecords  # of type `SEAL`, shape (ranges of speeds, seals)
    # S, which gives x and y of each seal from the degrees of freedom; below it, in the same order, the accelerations
    # due to unit forces at each seal (M^-1 S^T transposed). The shape is (4 seals, n).
    rows: Array


class SealCoefficients(NamedTuple):
    """K (N/m) and C (N s/m) of a seal at a speed."""

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
    records, place = seals.records, 0
    while place + 1 < records.shape[0] and Omega >= records[place + 1, k].begin:
        place += 1
    seal = records[place, k]
    a, t = seal.coefficients, Omega - seal.begin
    return SealCoefficients(
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
def _product(row: Array, q: Array) -> float:
    """Return the product of a row and the first coordinates of q: a displacement or a velocity."""
    total = 0.0
    for i in range(row.shape[0]):
        total += row[i] * q[i]
    return total


@kernel
def _add_response(seals: Seals, k: int, f_x: float, f_y: float, a: Array) -> None:
    """Add the accelerations due to forces (N) on the shaft at seal k to `a`."""
    x = 2 * (seals.records.shape[1] + k)
    by_x, by_y = seals.rows[x], seals.rows[x + 1]
    for i in range(by_x.shape[0]):
        a[i] += by_x[i] * f_x + by_y[i] * f_y


@kernel
def add_seals(seals: Seals, Omega: float, K_columns: Array, C_columns: Array) -> None:
    """Add M^-1 S^T K S and M^-1 S^T C S of all seals at a speed (rad/s) to matrices that are stored by columns."""
    for k in range(seals.records.shape[1]):
        s = seal_at(seals, k, Omega)
        x, y = seals.rows[2 * k], seals.rows[2 * k + 1]
        for j in range(x.shape[0]):
            if x[j] != 0.0 or y[j] != 0.0:
                _add_response(seals, k, s.k_xx * x[j] + s.k_xy * y[j], s.k_yx * x[j] + s.k_yy * y[j], K_columns[j])
                _add_response(seals, k, s.c_xx * x[j] + s.c_xy * y[j], s.c_yx * x[j] + s.c_yy * y[j], C_columns[j])


@kernel
def add_change_of_seals(seals: Seals, before: float, Omega: float, q: Array, v: Array, a: Array) -> None:
    """Add to `a` the difference between the seals' accelerations at a speed and at the speed `before`."""
    for k in range(seals.records.shape[1]):
        s, t = seal_at(seals, k, before), seal_at(seals, k, Omega)
        row_x, row_y = seals.rows[2 * k], seals.rows[2 * k + 1]
        x, y, v_x, v_y = _product(row_x, q), _product(row_y, q), _product(row_x, v), _product(row_y, v)
        f_x = (s.k_xx - t.k_xx) * x + (s.k_xy - t.k_xy) * y + (s.c_xx - t.c_xx) * v_x + (s.c_xy - t.c_xy) * v_y
        f_y = (s.k_yx - t.k_yx) * x + (s.k_yy - t.k_yy) * y + (s.c_yx - t.c_yx) * v_x + (s.c_yy - t.c_yy) * v_y
        _add_response(seals, k, f_x, f_y, a)


@kernel
def add_missed_between_speeds(
    seals: Seals, low: float, high: float, Omega: float, h: float, z: Array, z_new: Array, n: int
) -> None:
    """Correct z_new after a time h (s) so that the coefficients at a speed replace the interpolated ones.

        a = -M^-1 S^T (dK S (q + q_new)/2 + dC S (v + v_new)/2),  v_new += h a,  q_new += h^2 a/2            (2)

    with dK = K(Omega) - (1 - s) K(low) - s K(high) at the share s from low to high, and likewise dC. The neglected part
    is of order (omega h)^2/12 of this correction at a frequency omega of the motion. Speeds are in rad/s; the states z
    and z_new begin with displacements (m) and continue with velocities (m/s) from index n.
    """
    s, v, v_new = (Omega - low) / (high - low), z[n:], z_new[n:]
    for k in range(seals.records.shape[1]):
        at, a, b = seal_at(seals, k, Omega), seal_at(seals, k, low), seal_at(seals, k, high)
        x, y = seals.rows[2 * k], seals.rows[2 * k + 1]
        q_x, q_y = 0.5 * (_product(x, z) + _product(x, z_new)), 0.5 * (_product(y, z) + _product(y, z_new))
        v_x, v_y = 0.5 * (_product(x, v) + _product(x, v_new)), 0.5 * (_product(y, v) + _product(y, v_new))
        f_x = _missed(at.k_xx, a.k_xx, b.k_xx, s) * q_x + _missed(at.k_xy, a.k_xy, b.k_xy, s) * q_y
        f_x += _missed(at.c_xx, a.c_xx, b.c_xx, s) * v_x + _missed(at.c_xy, a.c_xy, b.c_xy, s) * v_y
        f_y = _missed(at.k_yx, a.k_yx, b.k_yx, s) * q_x + _missed(at.k_yy, a.k_yy, b.k_yy, s) * q_y
        f_y += _missed(at.c_yx, a.c_yx, b.c_yx, s) * v_x + _missed(at.c_yy, a.c_yy, b.c_yy, s) * v_y
        _add_response(seals, k, -h * f_x, -h * f_y, v_new)
        _add_response(seals, k, -0.5 * h * h * f_x, -0.5 * h * h * f_y, z_new)


@kernel
def _missed(value: float, low: float, high: float, share: float) -> float:
    """Return the difference of a value from linear interpolation between two others."""
    return value - low - share * (high - low)


@kernel
def seal_power(seals: Seals, Omega: float, q: Array, v: Array) -> tuple[float, float, float]:
    """Return the dissipation v^T C v of all seals, the power -v^T K q of their stiffness, and its skew part (W)."""
    heat = power = of_skew = 0.0
    for k in range(seals.records.shape[1]):
        s, row_x, row_y = seal_at(seals, k, Omega), seals.rows[2 * k], seals.rows[2 * k + 1]
        x, y, v_x, v_y = _product(row_x, q), _product(row_y, q), _product(row_x, v), _product(row_y, v)
        heat += v_x * (s.c_xx * v_x + s.c_xy * v_y) + v_y * (s.c_yx * v_x + s.c_yy * v_y)
        power -= v_x * (s.k_xx * x + s.k_xy * y) + v_y * (s.k_yx * x + s.k_yy * y)
        of_skew += 0.5 * (s.k_xy - s.k_yx) * (v_y * x - v_x * y)
    return heat, power, of_skew


@kernel
def add_seal_heat(seals: Seals, Omega: float, y: Array, n: int, heat: Array) -> None:
    """Add to `heat` the symmetric matrix of the seals' dissipation times y = (q, v)."""
    for k in range(seals.records.shape[1]):
        s, row_x, row_y = seal_at(seals, k, Omega), seals.rows[2 * k], seals.rows[2 * k + 1]
        v_x, v_y, cross = _product(row_x, y[n:]), _product(row_y, y[n:]), 0.5 * (s.c_xy + s.c_yx)
        f_x, f_y = s.c_xx * v_x + cross * v_y, cross * v_x + s.c_yy * v_y
        for i in range(row_x.shape[0]):
            heat[n + i] += row_x[i] * f_x + row_y[i] * f_y


@kernel
def add_seal_work(seals: Seals, Omega: float, y: Array, n: int, work: Array) -> None:
    """Add to `work` the symmetric matrix of the power of the seals' skew stiffness times y = (q, v)."""
    for k in range(seals.records.shape[1]):
        s, row_x, row_y = seal_at(seals, k, Omega), seals.rows[2 * k], seals.rows[2 * k + 1]
        x, y_, v_x, v_y = _product(row_x, y), _product(row_y, y), _product(row_x, y[n:]), _product(row_y, y[n:])
        skew = 0.25 * (s.k_xy - s.k_yx)
        for i in range(row_x.shape[0]):
            work[i] += skew * (row_x[i] * v_y - row_y[i] * v_x)
            work[n + i] += skew * (row_y[i] * x - row_x[i] * y_)


@kernel
def stored_by_seals(seals: Seals, Omega: float, q: Array) -> float:
    """Return q^T K q/2 (J) of all seals, without the contribution of the skew stiffness."""
    energy = 0.0
    for k in range(seals.records.shape[1]):
        s = seal_at(seals, k, Omega)
        x, y = _product(seals.rows[2 * k], q), _product(seals.rows[2 * k + 1], q)
        energy += 0.5 * (s.k_xx * x * x + (s.k_xy + s.k_yx) * x * y + s.k_yy * y * y)
    return energy


@kernel
def seals_are_isotropic(seals: Seals) -> bool:
    """Return whether, at all speeds, all seals respond in y as they do in x, turned by a right angle."""
    for place in range(seals.records.shape[0]):
        for k in range(seals.records.shape[1]):
            a = seals.records[place, k].coefficients
            for at in range(0, 32, 16):
                for power in range(at, at + 4):
                    xx, xy, yx, yy = a[power], a[power + 4], a[power + 8], a[power + 12]
                    largest = max(max(abs(xx), abs(xy)), max(abs(yx), abs(yy)))
                    if max(abs(xx - yy), abs(xy + yx)) > ISOTROPY_TOLERANCE * largest:
                        return False
    return True
