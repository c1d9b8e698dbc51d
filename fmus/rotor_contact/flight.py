"""Free flight at constant speed: the exact solution, by a matrix that is made once for all steps alike.

Without contact and under held forces the rotor is linear,

    q'' = -K q - C q' + M^-1 [ f + p cos(Omega t) + r sin(Omega t) ]        (3.1, unbalance in p and r)

so that everything at a time h later is linear in what is now:

    (q, v, v_b)(h) = P x,  (V_c, V_s) = V x,  x = (q, v, f, p, r)(0),    V_c - i V_s = int_0^h v exp(-i Omega t) dt

V_c and V_s give the work of the unbalance, p V_c + r V_s, where it acts; v_b are velocities at the bearings at the
points of Gauss's quadrature, for the heat of their damping. A column of P and V is a Taylor series in time: the motion
from one unit.

A communication step is flown in equal pieces, short enough for the series. Where a journal might touch in one of them,
the step is left to `events`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.flat import copy
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from rotor_contact.contact import can_touch
from rotor_contact.dynamics import BEARING_COLUMNS, C_B, COSINE, GRADIENT_X, K_B, ROW, SINE, STEADY, Motion
from rotor_contact.integration import DAMPING_HEAT, WORK_DONE, Z_NEW, Z
from rotor_contact.interface import ENABLED, N_BEARINGS, N_SITES
from rotor_contact.path import stays_within

# What P and V depend on: step size, speed, then stiffness, damping and both force gradients of each bearing.
N_KEY = 2 + (BEARING_COLUMNS - K_B) * N_BEARINGS
STEPS = N_KEY  # in the memory of `steady`: for how many steps nothing of it has changed
N_MEMORY = N_KEY + 1
PATIENCE = 64  # steps; making P costs as much as some fifty of them

STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times rounds in the last digits of the step
TERMS = 22  # of the series, whose terms fall at least like 1/k!
MOST_PIECES = 32
MARGIN = 1e-4  # of the clearance, within which the path is not trusted

N_GAUSS = 4
GAUSS_POINTS = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)  # in [0, 1]
GAUSS_WEIGHTS = (0.17392742256872692, 0.3260725774312731, 0.3260725774312731, 0.17392742256872692)
N_B = 2 * N_BEARINGS


class Flight(NamedTuple):
    """P, V and what they were made for, with room to use and to make them.

    key
        Shape (N_KEY + 1,); the last is the number of pieces, 0 where there are too many.
    P, V
        Shapes (5 n, 2 n + N_GAUSS N_B) and (5 n, 2 n); row j holds what unit j leads to.
    start, end
        What P maps from and to.
    series
        Terms of the series of q, v, and the real and imaginary part of the integral, then the acceleration; (5, n).
    """

    key: Array
    P: Array
    V: Array
    start: Array
    end: Array
    series: Array


def size_of(n: int) -> int:
    """Size of a `Flight` of a rotor with n degrees of freedom."""
    start, end = 5 * n, 2 * n + N_GAUSS * N_B
    return N_KEY + 1 + start * (end + 2 * n) + start + end + 5 * n


@views
def flight_of(work: Array, n: int) -> Flight:
    """A `Flight` in the beginning of an array."""
    rows, columns = 5 * n, 2 * n + N_GAUSS * N_B
    key, rest = work[: N_KEY + 1], work[N_KEY + 1 :]
    P, rest = rest[: rows * columns].reshape(rows, columns), rest[rows * columns :]
    V, rest = rest[: rows * 2 * n].reshape(rows, 2 * n), rest[rows * 2 * n :]
    start, rest = rest[:rows], rest[rows:]
    end, rest = rest[:columns], rest[columns:]
    return Flight(key, P, V, start, end, rest[: 5 * n].reshape(5, n))


@kernel
def steady(m: Motion, step_size: float, memory: Array) -> bool:
    """Whether P has been the same for some time, so that it is worth making; `memory` is of shape (N_MEMORY,).

    The step size that counts is the first of those that differ by rounding alone.
    """
    same = m.Omega_dot == 0.0 and m.Omega == memory[1]
    memory[1] = m.Omega
    if not abs(step_size - memory[0]) <= STEP_TOLERANCE * step_size:
        same = False
        memory[0] = step_size
    for k in range(N_BEARINGS):
        for what in range(BEARING_COLUMNS - K_B):
            i, value = 2 + (BEARING_COLUMNS - K_B) * k + what, m.bearings[k, K_B + what]
            same = same and memory[i] == value
            memory[i] = value
    memory[STEPS] = min(memory[STEPS] + 1.0, float(PATIENCE)) if same else 0.0
    return bool(memory[STEPS] >= PATIENCE)


@kernel
def is_made(f: Flight, memory: Array) -> bool:
    """Whether P is the one for this memory of `steady`."""
    for i in range(N_KEY):
        if f.key[i] != memory[i]:
            return False
    return True


@kernel
def make(Minv: Array, m: Motion, memory: Array, f: Flight) -> None:
    """Make P for this memory of `steady`, from the coefficients of the motion."""
    n = Minv.shape[0]
    elastic = viscous = 0.0  # the largest row sums bound how fast anything can change
    for i in range(n):
        of_k = of_c = 0.0
        for j in range(n):
            of_k += abs(m.coefficients[j, i])
            of_c += abs(m.coefficients[n + j, i])
        elastic, viscous = max(elastic, of_k), max(viscous, of_c)
    rate = math.sqrt(elastic) + viscous + abs(m.Omega)
    copy(memory[:N_KEY], f.key)
    f.key[N_KEY] = 0.0
    if memory[0] * rate <= MOST_PIECES:
        pieces = max(math.ceil(memory[0] * rate), 1)
        f.key[N_KEY] = pieces
        for unit in range(5 * n):
            _add_series(Minv, m, unit, memory[0] / pieces, f.P[unit], f.V[unit], f.series)


@kernel
def _add_series(Minv: Array, m: Motion, unit: int, h: float, row: Array, integral: Array, series: Array) -> None:
    """What one unit of the start leads to after h (s), by the series in t/h, term after term."""
    n = Minv.shape[0]
    row[:] = 0.0
    integral[:] = 0.0
    series[:, :] = 0.0
    q, v, re, im, a = series[0], series[1], series[2], series[3], series[4]
    kind, column = unit // n - 2, unit % n  # -2, -1: displacement, velocity; 0, 1, 2: steady, cosine, sine
    if kind < 0:
        series[kind + 2, column] = 1.0
        row[unit] = 1.0
    for k in range(N_GAUSS):
        for b in range(N_B):
            row[2 * n + k * N_B + b] = v[row_of(m, b)]
    cosine, sine = 1.0, 0.0
    for term in range(1, TERMS + 1):
        share, turn = h / term, 0.0 if kind == 0 else m.Omega * h / term
        force = 0.0 if kind < 0 else sine if kind == 2 else cosine
        cosine, sine = -turn * sine, turn * cosine
        for i in range(n):
            a[i] = force * Minv[i, column]
        for j in range(n):
            for i in range(n):
                a[i] -= m.coefficients[j, i] * q[j] + m.coefficients[n + j, i] * v[j]
        for i in range(n):
            real = share * (v[i] - m.Omega * im[i])
            im[i] = share * m.Omega * re[i]
            re[i] = real
            q[i] = share * v[i]
            v[i] = share * a[i]
            row[i] += q[i]
            row[n + i] += v[i]
            integral[i] += re[i]
            integral[n + i] += im[i]
        for k in range(N_GAUSS):
            power = GAUSS_POINTS[k] ** term
            for b in range(N_B):
                row[2 * n + k * N_B + b] += power * v[row_of(m, b)]
    along, across = math.cos(m.Omega * h), math.sin(m.Omega * h)
    for i in range(n):  # from int v exp(i Omega (h - t)) dt to V_c and V_s
        real, imaginary = integral[i], integral[n + i]
        integral[i] = real * along + imaginary * across
        integral[n + i] = real * across - imaginary * along


@kernel
def row_of(m: Motion, b: int) -> int:
    """Degree of freedom of axis b of the bearings: x and y of the first, then of the second."""
    return int(m.bearings[b // 2, ROW]) + b % 2


@kernel
def fly(m: Motion, sites: Array, r: Array, f: Flight, step_size: float) -> bool:
    """Advance z by one communication step in free flight; False, and z as before, if a site is or comes too close.

    P must be made. `r` holds z as for `events.advance`.
    """
    pieces = int(f.key[N_KEY])
    for k in range(N_SITES):
        if sites[k, ENABLED] != 0.0 and not can_touch(sites, k):
            return False
    if pieces == 0:
        return False
    copy(r[Z], r[Z_NEW])
    h = step_size / pieces
    for piece in range(pieces):
        if not _fly_piece(m, sites, r[Z_NEW], f, piece * h, h):
            return False
    copy(r[Z_NEW], r[Z])
    return True


@kernel
def _fly_piece(m: Motion, sites: Array, z: Array, f: Flight, tau: float, h: float) -> bool:
    """Advance z by one piece that begins at `tau` (s); False if it may touch."""
    n = m.forces.shape[1]
    start, end = f.start, f.end
    square = m.Omega * m.Omega
    along, across = square * math.cos(m.theta + m.Omega * tau), square * math.sin(m.theta + m.Omega * tau)
    copy(z[: 2 * n], start)
    copy(m.forces[STEADY], start[2 * n :])
    for i in range(n):
        start[3 * n + i] = along * m.forces[COSINE, i] + across * m.forces[SINE, i]
        start[4 * n + i] = along * m.forces[SINE, i] - across * m.forces[COSINE, i]
    damped = m.bearings[0, C_B] != 0.0 or m.bearings[1, C_B] != 0.0
    size = 2 * n + (N_GAUSS * N_B if damped else 0)
    for i in range(size):
        end[i] = 0.0
    for j in range(5 * n):
        if start[j] != 0.0:
            for i in range(size):
                end[i] += start[j] * f.P[j, i]
    for k in range(N_SITES):
        if sites[k, ENABLED] != 0.0 and not stays_within(sites, k, start, end, h, n, MARGIN):
            return False
    tallies = 2 * n
    work = 0.0
    for i in range(n):
        work += start[2 * n + i] * (end[i] - start[i])
        if start[3 * n + i] != 0.0 or start[4 * n + i] != 0.0:
            v_c, v_s = 0.0, 0.0
            for j in range(5 * n):
                v_c += start[j] * f.V[j, i]
                v_s += start[j] * f.V[j, n + i]
            work += start[3 * n + i] * v_c + start[4 * n + i] * v_s
    for b in range(N_B):
        i = row_of(m, b)
        work += 0.5 * m.bearings[b // 2, GRADIENT_X + b % 2] * (end[i] * end[i] - start[i] * start[i])
    heat = 0.0
    if damped:
        for k in range(N_GAUSS):
            for b in range(N_B):
                velocity = end[2 * n + k * N_B + b]
                heat += GAUSS_WEIGHTS[k] * m.bearings[b // 2, C_B] * velocity * velocity
    z[tallies + WORK_DONE] += work
    z[tallies + DAMPING_HEAT] += h * heat
    copy(end[: 2 * n], z)
    return True
