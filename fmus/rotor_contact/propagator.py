"""The propagator of free flight: a matrix for one piece of a step, built by Taylor series; when to build it.

P and V are explained in `free_flight`. A column is a Taylor series in time: the motion from one unit of x.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.records import record, size_of
from rotor_contact.dynamics import Motion
from rotor_contact.interface import N_BEARINGS

# What P and V depend on: step size (s), speed (rad/s), stiffness, damping and force gradients of each bearing.
BEARING_KEY = record(("k_b", np.float64), ("c_b", np.float64), ("gradient", np.float64, (2,)))
KEY = record(("step_size", np.float64), ("Omega", np.float64), ("bearings", BEARING_KEY, (N_BEARINGS,)))
N_KEY = size_of(KEY)
# The latest key, and for how many steps it has not changed.
HISTORY = record(("key", KEY), ("n_steps", np.float64))

STEPS_BEFORE_BUILD = 64  # to build P costs as much as some fifty steps
STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times rounds in the last digits of the step
TERMS = 22  # of the series, whose terms fall at least like 1/k!
MAX_PIECES = 32

N_GAUSS = 4
GAUSS_POINTS = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)  # in [0, 1]
N_AXES = 2 * N_BEARINGS

# Terms of the series of q, v, and the real and imaginary part of the integral, then the acceleration.
N_SERIES = 5


class Propagator(NamedTuple):
    """P and V with what they were built for, and room to use and to build them.

    key
        Record of type `KEY`, in an array of one.
    P, V
        Shapes (5 n, 2 n + N_GAUSS N_AXES) and (5 n, 2 n); row j is the effect of unit j of x.
    start, end
        What P maps from and to.
    series
        Terms of the series, shape (N_SERIES, n).
    n_pieces
        Number of pieces of a step, in an array of one; 0 where there are too many.
    """

    key: np.ndarray[tuple[int], np.dtype[np.record]]
    P: Array
    V: Array
    start: Array
    end: Array
    series: Array
    n_pieces: Array


def propagator_size(n: int) -> int:
    """Return how many float64 a `Propagator` of a rotor with n degrees of freedom takes."""
    start, end = 5 * n, 2 * n + N_GAUSS * N_AXES
    return N_KEY + 1 + start * (end + 2 * n) + start + end + N_SERIES * n


@views
def propagator_of(work: Array, n: int) -> Propagator:
    """Return a `Propagator` in the beginning of an array."""
    rows, columns = 5 * n, 2 * n + N_GAUSS * N_AXES
    key, rest = work[:N_KEY].view(KEY), work[N_KEY:]
    P, rest = rest[: rows * columns].reshape(rows, columns), rest[rows * columns :]
    V, rest = rest[: rows * 2 * n].reshape(rows, 2 * n), rest[rows * 2 * n :]
    start, rest = rest[:rows], rest[rows:]
    end, rest = rest[:columns], rest[columns:]
    series, rest = rest[: N_SERIES * n].reshape(N_SERIES, n), rest[N_SERIES * n :]
    return Propagator(key, P, V, start, end, series, rest[:1])


@kernel
def is_time_invariant(motion: Motion, step_size: float, history: np.record) -> bool:
    """Return whether P has been the same for some time, so that it is worth building; update `history`.

    The step size that counts is the first of those that differ by rounding alone.
    """
    key = history.key
    same = motion.Omega_dot == 0.0 and motion.Omega == key.Omega
    key.Omega = motion.Omega
    if not abs(step_size - key.step_size) <= STEP_TOLERANCE * step_size:
        same = False
        key.step_size = step_size
    for k in range(N_BEARINGS):
        bearing, known = motion.bearings[k], key.bearings[k]
        same = same and known.k_b == bearing.k_b and known.c_b == bearing.c_b
        known.k_b = bearing.k_b
        known.c_b = bearing.c_b
        for axis in range(2):
            same = same and known.gradient[axis] == bearing.gradient[axis]
            known.gradient[axis] = bearing.gradient[axis]
    history.n_steps = min(history.n_steps + 1.0, float(STEPS_BEFORE_BUILD)) if same else 0.0
    return bool(history.n_steps >= STEPS_BEFORE_BUILD)


@kernel
def is_built(propagator: Propagator, key: np.record) -> bool:
    """Return whether P was built for this key."""
    built = propagator.key[0]
    same = built.step_size == key.step_size and built.Omega == key.Omega
    for k in range(N_BEARINGS):
        a, b = built.bearings[k], key.bearings[k]
        same = same and a.k_b == b.k_b and a.c_b == b.c_b
        same = same and a.gradient[0] == b.gradient[0] and a.gradient[1] == b.gradient[1]
    return same


@kernel
def _set_key(key: np.record, source: np.record) -> None:
    """Write the key `source` into `key`."""
    key.step_size = source.step_size
    key.Omega = source.Omega
    for k in range(N_BEARINGS):
        a, b = key.bearings[k], source.bearings[k]
        a.k_b = b.k_b
        a.c_b = b.c_b
        a.gradient[0] = b.gradient[0]
        a.gradient[1] = b.gradient[1]


@kernel
def build_propagator(Minv: Array, motion: Motion, key: np.record, propagator: Propagator) -> None:
    """Build P and V for this key, from the coefficients of the motion."""
    n = Minv.shape[0]
    elastic = viscous = 0.0  # the largest row sums bound how fast anything can change
    for i in range(n):
        row_of_K = row_of_C = 0.0
        for j in range(n):
            row_of_K += abs(motion.K_columns[j, i])
            row_of_C += abs(motion.C_columns[j, i])
        elastic, viscous = max(elastic, row_of_K), max(viscous, row_of_C)
    rate = math.sqrt(elastic) + viscous + abs(motion.Omega)
    _set_key(propagator.key[0], key)
    propagator.n_pieces[0] = 0.0
    if key.step_size * rate <= MAX_PIECES:
        pieces = max(math.ceil(key.step_size * rate), 1)
        propagator.n_pieces[0] = pieces
        for unit in range(5 * n):
            _integrate_unit(Minv, motion, propagator, unit, key.step_size / pieces)


@kernel
def _integrate_unit(Minv: Array, motion: Motion, propagator: Propagator, unit: int, h: float) -> None:
    """Taylor-integrate one unit initial condition or force over h (s), term by term in t/h."""
    n = Minv.shape[0]
    row, integral, series = propagator.P[unit], propagator.V[unit], propagator.series
    row[:] = 0.0
    integral[:] = 0.0
    series[:, :] = 0.0
    q, v, re, im, a = series[0], series[1], series[2], series[3], series[4]
    kind, column = unit // n - 2, unit % n  # -2, -1: displacement, velocity; 0, 1, 2: steady, cosine, sine
    if kind < 0:
        series[kind + 2, column] = 1.0
        row[unit] = 1.0
    for k in range(N_GAUSS):
        for b in range(N_AXES):
            row[2 * n + k * N_AXES + b] = v[row_of_axis(motion, b)]
    cosine, sine = 1.0, 0.0
    for term in range(1, TERMS + 1):
        dt, delta_theta = h / term, 0.0 if kind == 0 else motion.Omega * h / term
        force = 0.0 if kind < 0 else sine if kind == 2 else cosine
        cosine, sine = -delta_theta * sine, delta_theta * cosine
        for i in range(n):
            a[i] = force * Minv[i, column]
        for j in range(n):
            K_j, C_j, q_j, v_j = motion.K_columns[j], motion.C_columns[j], q[j], v[j]
            for i in range(n):
                a[i] -= K_j[i] * q_j + C_j[i] * v_j
        for i in range(n):
            real = dt * (v[i] - motion.Omega * im[i])
            im[i] = dt * motion.Omega * re[i]
            re[i] = real
            q[i] = dt * v[i]
            v[i] = dt * a[i]
            row[i] += q[i]
            row[n + i] += v[i]
            integral[i] += re[i]
            integral[n + i] += im[i]
        for k in range(N_GAUSS):
            power = GAUSS_POINTS[k] ** term
            for b in range(N_AXES):
                row[2 * n + k * N_AXES + b] += power * v[row_of_axis(motion, b)]
    cosine, sine = math.cos(motion.Omega * h), math.sin(motion.Omega * h)
    for i in range(n):  # from int v exp(i Omega (h - t)) dt to V_c and V_s
        real, imaginary = integral[i], integral[n + i]
        integral[i] = real * cosine + imaginary * sine
        integral[n + i] = real * sine - imaginary * cosine


@kernel
def row_of_axis(motion: Motion, b: int) -> int:
    """Return the degree of freedom of axis b of the bearings: x and y of the first, then of the second."""
    row: int = motion.bearings[b // 2].row + b % 2
    return row
