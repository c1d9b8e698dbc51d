"""The propagator of free flight: a matrix for one piece of a step, built by Taylor series; when to build it.

P and V are explained in `free_flight`. A column is a Taylor series in time: the motion from one unit of x.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rotor_contact.dynamics import Motion, coefficients
from rotor_contact.structure import REAL

# What P and V depend on: step size (s) and speed (rad/s); stiffness, damping and force gradients of each bearing.
KEY = record(("step_size", np.float64), ("Omega", np.float64))
BEARING_KEY = record(("k_b", np.float64), ("c_b", np.float64), ("gradient", np.float64, (2,)))
N_KEY, N_BEARING_KEY = size_of(KEY), size_of(BEARING_KEY)

STEPS_BEFORE_BUILD = 64  # to build P costs as much as some fifty steps
STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times rounds in the last digits of the step
ROUNDING = 1e-13  # relative, of speed and bearings: what differs by less is computed anew by others, not changed
TERMS = 22  # of the series, whose terms fall at least like 1/k!
MAX_PIECES = 32

N_GAUSS = 4
GAUSS_POINTS = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)  # in [0, 1]

# Terms of the series of q, v, and the real and imaginary part of the integral, then the acceleration.
N_SERIES = 5


class Key(NamedTuple):
    """What a propagator is for: a record of type `KEY`, in an array of one, and records of type `BEARING_KEY`."""

    own: np.ndarray[tuple[int], np.dtype[np.record]]
    bearings: np.ndarray[tuple[int], np.dtype[np.record]]


class Propagator(NamedTuple):
    """P and V with what they were built for, and room to use and to build them.

    P, V
        Shapes (5 n, 2 n + N_GAUSS n_observed) and (5 n, 2 n); row j is the effect of unit j of x.
    key
        What they were built for.
    start, end
        What P maps from and to.
    series
        Terms of the series, shape (N_SERIES, n).
    n_pieces
        Number of pieces of a step, in an array of one; 0 where there are too many.
    """

    P: Array
    V: Array
    key: Key
    start: Array
    end: Array
    series: Array
    n_pieces: Array


@views
def key_size(n_bearings: int) -> int:
    """Return how many float64 a `Key` takes."""
    return N_KEY + n_bearings * N_BEARING_KEY


@views
def key_of(array: Array, start: int, n_bearings: int) -> Key:
    """Return a `Key` in an array from `start` on."""
    return Key(part(array, start, KEY, 1), part(array, start + N_KEY, BEARING_KEY, n_bearings))


@views
def propagator_size(n: int, n_bearings: int, is_damped: bool) -> int:
    """Return how many float64 a `Propagator` of a rotor with n degrees of freedom takes."""
    start, end = 5 * n, 2 * n + N_GAUSS * (2 * n if is_damped else 2 * n_bearings)
    return start * (end + 2 * n) + key_size(n_bearings) + start + end + N_SERIES * n + 1


@views
def propagator_of(work: Array, at: int, n: int, n_bearings: int, is_damped: bool) -> Propagator:
    """Return a `Propagator` in an array from `at` on."""
    rows, columns = 5 * n, 2 * n + N_GAUSS * (2 * n if is_damped else 2 * n_bearings)
    V = at + rows * columns
    key = V + rows * 2 * n
    start = key + key_size(n_bearings)
    end = start + rows
    series = end + columns
    return Propagator(
        part(work, at, REAL, (rows, columns)),
        part(work, V, REAL, (rows, 2 * n)),
        key_of(work, key, n_bearings),
        part(work, start, REAL, rows),
        part(work, end, REAL, columns),
        part(work, series, REAL, (N_SERIES, n)),
        part(work, series + N_SERIES * n, REAL, 1),
    )


@kernel
def is_time_invariant(motion: Motion, step_size: float, key: Key, memory: np.record) -> bool:
    """Return whether P has been the same for some time, so that it is worth building.

    `key` is updated, and `memory.n_steps`, for how many steps it has not changed. Of values that differ by rounding
    alone the first counts.
    """
    own = key.own[0]
    same = motion.Omega_dot == 0.0 and is_near(motion.Omega, own.Omega, ROUNDING)
    same = same and is_near(step_size, own.step_size, STEP_TOLERANCE)
    for k in range(motion.bearings.shape[0]):
        bearing, known = motion.bearings[k], key.bearings[k]
        same = same and is_near(bearing.k_b, known.k_b, ROUNDING) and is_near(bearing.c_b, known.c_b, ROUNDING)
        for axis in range(2):
            same = same and is_near(bearing.gradient[axis], known.gradient[axis], ROUNDING)
    if not same:
        own.Omega, own.step_size = motion.Omega, step_size
        for k in range(motion.bearings.shape[0]):
            bearing, known = motion.bearings[k], key.bearings[k]
            known.k_b, known.c_b = bearing.k_b, bearing.c_b
            known.gradient[0], known.gradient[1] = bearing.gradient[0], bearing.gradient[1]
    memory.n_steps = min(memory.n_steps + 1.0, float(STEPS_BEFORE_BUILD)) if same else 0.0
    return bool(memory.n_steps >= STEPS_BEFORE_BUILD)


@kernel
def without_rounding(motion: Motion, key: Key) -> Motion:
    """Return a motion with the speed, and with the bearings, of the key that it has but for rounding.

    So P is the same to the last bit, whichever step it is built at.
    """
    for k in range(motion.bearings.shape[0]):
        bearing, known = motion.bearings[k], key.bearings[k]
        bearing.k_b, bearing.c_b = known.k_b, known.c_b
        bearing.gradient[0], bearing.gradient[1] = known.gradient[0], known.gradient[1]
    Omega: float = key.own[0].Omega
    return Motion(
        motion.rows, motion.bearings, motion.over_speed, motion.is_damped, motion.theta, Omega, motion.Omega_dot
    )


@kernel
def is_near(value: float, known: float, tolerance: float) -> bool:
    """Return whether a value differs from a known one by no more than `tolerance` of that; NaN does."""
    return abs(value - known) <= tolerance * abs(known)


@kernel
def is_built(propagator: Propagator, key: Key) -> bool:
    """Return whether P was built for this key."""
    built, own = propagator.key.own[0], key.own[0]
    same = built.step_size == own.step_size and built.Omega == own.Omega
    for k in range(key.bearings.shape[0]):
        a, b = propagator.key.bearings[k], key.bearings[k]
        same = same and a.k_b == b.k_b and a.c_b == b.c_b
        same = same and a.gradient[0] == b.gradient[0] and a.gradient[1] == b.gradient[1]
    return same


@kernel
def _set_key(key: Key, source: Key) -> None:
    """Write the key `source` into `key`."""
    key.own[0].step_size = source.own[0].step_size
    key.own[0].Omega = source.own[0].Omega
    for k in range(key.bearings.shape[0]):
        a, b = key.bearings[k], source.bearings[k]
        a.k_b = b.k_b
        a.c_b = b.c_b
        a.gradient[0] = b.gradient[0]
        a.gradient[1] = b.gradient[1]


@kernel
def build_propagator(Minv: Array, motion: Motion, key: Key, propagator: Propagator) -> None:
    """Build P and V for this key, from the coefficients of the motion."""
    n = Minv.shape[0]
    K, C = coefficients(motion)
    elastic = viscous = 0.0  # the largest row sums bound how fast anything can change
    for i in range(n):
        row_of_K = row_of_C = 0.0
        for j in range(n):
            row_of_K += abs(K[j, i])
            row_of_C += abs(C[j, i])
        elastic, viscous = max(elastic, row_of_K), max(viscous, row_of_C)
    rate = math.sqrt(elastic) + viscous + abs(motion.Omega)
    _set_key(propagator.key, key)
    step_size = key.own[0].step_size
    propagator.n_pieces[0] = 0.0
    if step_size * rate <= MAX_PIECES:
        pieces = max(math.ceil(step_size * rate), 1)
        propagator.n_pieces[0] = pieces
        for unit in range(5 * n):
            _integrate_unit(Minv, motion, propagator, unit, step_size / pieces)


@kernel
def _integrate_unit(Minv: Array, motion: Motion, propagator: Propagator, unit: int, h: float) -> None:
    """Taylor-integrate one unit initial condition or force over h (s), term by term in t/h."""
    n = Minv.shape[0]
    K, C = coefficients(motion)
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
        for b in range(n_observed(motion)):
            row[2 * n + k * n_observed(motion) + b] = observed(motion, q, v, b)
    cosine, sine = 1.0, 0.0
    for term in range(1, TERMS + 1):
        dt, delta_theta = h / term, 0.0 if kind == 0 else motion.Omega * h / term
        force = 0.0 if kind < 0 else sine if kind == 2 else cosine
        cosine, sine = -delta_theta * sine, delta_theta * cosine
        for i in range(n):
            a[i] = force * Minv[i, column]
        for j in range(n):
            K_j, C_j, q_j, v_j = K[j], C[j], q[j], v[j]
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
            for b in range(n_observed(motion)):
                row[2 * n + k * n_observed(motion) + b] += power * observed(motion, q, v, b)
    cosine, sine = math.cos(motion.Omega * h), math.sin(motion.Omega * h)
    for i in range(n):  # from int v exp(i Omega (h - t)) dt to V_c and V_s
        real, imaginary = integral[i], integral[n + i]
        integral[i] = real * cosine + imaginary * sine
        integral[n + i] = real * sine - imaginary * cosine


@kernel
def n_observed(motion: Motion) -> int:
    """Return how many numbers of q and v the heat of damping takes: all, or the velocities at the bearings' axes."""
    return 2 * motion.rows.shape[1] if motion.is_damped else n_axes(motion)


@kernel
def observed(motion: Motion, q: Array, v: Array, b: int) -> float:
    """Return number b of those of `n_observed`."""
    n = motion.rows.shape[1]
    if motion.is_damped:
        number: float = q[b] if b < n else v[b - n]
        return number
    velocity: float = v[row_of_axis(motion, b)]
    return velocity


@kernel
def n_axes(motion: Motion) -> int:
    """Return the number of the bearings' axes."""
    return 2 * motion.bearings.shape[0]


@kernel
def row_of_axis(motion: Motion, b: int) -> int:
    """Return the degree of freedom of axis b of the bearings: x and y of the first, then of the next."""
    row: int = motion.bearings[b // 2].row + b % 2
    return row
