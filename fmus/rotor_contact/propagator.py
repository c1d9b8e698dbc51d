"""The propagator of exact motion: matrices for a piece of a step, and criteria for building them.

P, V and S are explained in `exact_motion` and `collocation`; `series` builds them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.flat import is_near, same_bits
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import copy_all, part
from fmi_export.records import record, size_of
from rotor_contact.dynamics import Motion, motion_at
from rotor_contact.linear_solver import Equations, equations_of
from rotor_contact.lobatto import N_LOBATTO
from rotor_contact.passive_bearings import BEARING, Bearings, bearings_size, same_passive
from rotor_contact.structure import REAL

# What P and V depend on, besides the bearings: step size (s) and speed (rad/s).
STEP_KEY = record(("step_size", np.float64), ("Omega", np.float64))
N_STEP_KEY = size_of(STEP_KEY)

STEPS_BEFORE_BUILD = 32  # in which P is built, row by row; altogether that costs as much as they do
STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times rounds in the last digits of the step
ROUNDING = 1e-13  # relative; speeds and bearings that differ by less count as unchanged

N_GAUSS = 4
N_SERIES = 5  # see `series`

# Observations of a journal for the equations of its contact: the acceleration without contact at the start (m/s^2),
# position and velocity at the Lobatto points after that, and the acceleration without contact at the end.
JOURNAL = record(("x", np.float64), ("y", np.float64), ("v_x", np.float64), ("v_y", np.float64))
OBSERVED = record(("a_start", np.float64, 2), ("journal", JOURNAL, N_LOBATTO - 1), ("a_end", np.float64, 2))
N_OBSERVED = size_of(OBSERVED)
# A site at a Lobatto point: normal, slip velocity (m/s), ratio T/N of sliding, and the forces (N).
NODE = record(
    ("n_x", np.float64),
    ("n_y", np.float64),
    ("slip", np.float64),
    ("ratio", np.float64),
    ("f_n", np.float64),
    ("f_t", np.float64),
)
# Progress of building: number of equal pieces of a step, 0 if there would be too many; of rows so far; of terms of the
# series; and length of a piece (s).
BUILT = record(("n_pieces", np.float64), ("n_rows", np.float64), ("n_terms", np.float64), ("length", np.float64))
N_NODE, N_BUILT = size_of(NODE), size_of(BUILT)


Nodes = np.ndarray[tuple[int, int], np.dtype[np.record]]


class Key(NamedTuple):
    """Key of a propagator: all numbers, with views as `STEP_KEY` (array of length 1) and `BEARING` records."""

    values: Array
    step: np.ndarray[tuple[int], np.dtype[np.record]]
    bearings: Bearings


class Propagator(NamedTuple):
    """P, V and S with their key, and scratch to use and build them.

    P, V
        Shapes (n_rows, 2 n + N_GAUSS n_observed) and (n_rows, 2 n); row j is the effect of unit j of x. The first
        `n_free` are for free flight, the others for unit forces in x and y at a site at a Lobatto point: all sites at
        the first point, then all at the next. The n_x rows are followed by those from which `direct_unbalance` computes
        the two rows of the unbalance: unit forces with the course of cosine and sine.
    S
        Observations of these at each site, shape (n_sites, n_rows, N_OBSERVED).
    key
        Key that P, V and S were built for.
    unbalance, work
        Cosine and sine part of the unbalance, shape (2 n,), and the coefficients of its work at x for each of its two
        directions, shape (2, n_x): V in these directions.
    start, end
        Argument and result of P: x, shape (n_x,), and the end.
    free_response, contact_response
        Observations at each site without contact and due to contact, shape (n_sites, N_OBSERVED) each.
    nodes
        Records of type `NODE`, shape (n_sites, N_LOBATTO).
    equations
        Room for the equations of all points after the first.
    series
        Terms of the series, shape (N_SERIES, n).
    built
        Record of type `BUILT`, in an array of length 1.
    """

    P: Array
    V: Array
    S: Array
    key: Key
    unbalance: Array
    work: Array
    start: Array
    end: Array
    free_response: Array
    contact_response: Array
    nodes: Nodes
    equations: Equations
    series: Array
    built: np.ndarray[tuple[int], np.dtype[np.record]]


@views
def key_size(n_bearings: int) -> int:
    """Return the number of float64 in a `Key`, an even number."""
    return N_STEP_KEY + bearings_size(n_bearings)


@views
def key_of(array: Array, start: int, n_bearings: int) -> Key:
    """Return a `Key` in an array from `start` on."""
    return Key(
        part(array, start, REAL, key_size(n_bearings)),
        part(array, start, STEP_KEY, 1),
        part(array, start + N_STEP_KEY, BEARING, n_bearings),
    )


@views
def n_free(n: int) -> int:
    """Return the size of x without contact: q, v, steady forces, direction of the unbalance."""
    return 3 * n + 2


@views
def n_start(n: int, n_sites: int) -> int:
    """Return the size of x."""
    return n_free(n) + 2 * N_LOBATTO * n_sites


@views
def n_end(n: int, n_bearings: int, is_damped: bool) -> int:
    """Return the number of columns of P."""
    return 2 * n + N_GAUSS * (2 * n if is_damped else 2 * n_bearings)


@views
def propagator_size(n: int, n_bearings: int, n_sites: int, is_damped: bool) -> int:
    """Return the number of float64 in a `Propagator` of a rotor with n degrees of freedom."""
    n_x, columns, n_equations = n_start(n, n_sites), n_end(n, n_bearings, is_damped), 2 * (N_LOBATTO - 1) * n_sites
    rows = n_x + 2 * n
    at_sites = n_sites * ((rows + 2) * N_OBSERVED + N_LOBATTO * N_NODE)
    matrices = rows * (columns + 2 * n) + n_equations * (n_equations + 1)
    return matrices + at_sites + key_size(n_bearings) + 3 * n_x + columns + (N_SERIES + 2) * n + N_BUILT


@views
def propagator_of(work: Array, at: int, n: int, n_bearings: int, n_sites: int, is_damped: bool) -> Propagator:
    """Return a `Propagator` in an array from `at` on."""
    n_x, columns, n_equations = n_start(n, n_sites), n_end(n, n_bearings, is_damped), 2 * (N_LOBATTO - 1) * n_sites
    rows = n_x + 2 * n
    V = at + rows * columns
    S = V + rows * 2 * n
    key = S + n_sites * rows * N_OBSERVED
    unbalance = key + key_size(n_bearings)
    directions = unbalance + 2 * n
    start = directions + 2 * n_x
    end = start + n_x
    free_response = end + columns
    contact_response = free_response + n_sites * N_OBSERVED
    nodes = contact_response + n_sites * N_OBSERVED
    equations = nodes + n_sites * N_LOBATTO * N_NODE
    series = equations + n_equations * (n_equations + 1)
    return Propagator(
        part(work, at, REAL, (rows, columns)),
        part(work, V, REAL, (rows, 2 * n)),
        part(work, S, REAL, (n_sites, rows, N_OBSERVED)),
        key_of(work, key, n_bearings),
        part(work, unbalance, REAL, 2 * n),
        part(work, directions, REAL, (2, n_x)),
        part(work, start, REAL, n_x),
        part(work, end, REAL, columns),
        part(work, free_response, REAL, (n_sites, N_OBSERVED)),
        part(work, contact_response, REAL, (n_sites, N_OBSERVED)),
        part(work, nodes, NODE, (n_sites, N_LOBATTO)),
        equations_of(work, equations, n_equations),
        part(work, series, REAL, (N_SERIES, n)),
        part(work, series + N_SERIES * n, BUILT, 1),
    )


@views
def observed(response: Array) -> np.record:
    """Return a row of S, or a response made of such rows, as a record of type `OBSERVED`."""
    of_site: np.record = part(response, 0, OBSERVED, 1)[0]
    return of_site


@kernel
def steps_unchanged(motion: Motion, step_size: float, key: Key, memory: np.record) -> float:
    """Return the number of steps with the same P, at most STEPS_BEFORE_BUILD.

    Updates `key` and `memory.n_steps`, the number. A value that differs only by rounding is not replaced.
    """
    same = _is_for(key, motion, step_size)
    if not same:
        key.step[0].step_size, key.step[0].Omega = step_size, motion.Omega
        copy_all(motion.bearings, key.bearings)
    memory.n_steps = count_of_steps(memory.n_steps, memory, float(STEPS_BEFORE_BUILD)) if same else 0.0
    n_steps: float = memory.n_steps
    return n_steps


@kernel
def count_of_steps(count: float, memory: np.record, largest: float) -> float:
    """Return the next count of equal steps, at most `largest`.

    The first matrices of a run are built at once: without them, its start would be less accurate than what follows.
    """
    return min(count + 1.0, largest) if memory.has_matrices != 0.0 else float(STEPS_BEFORE_BUILD)


@kernel
def _is_for(key: Key, motion: Motion, step_size: float) -> bool:
    """Return whether a key is that of a step at constant speed, within rounding."""
    step = key.step[0]
    same = motion.Omega_dot == 0.0 and is_near(motion.Omega, step.Omega, ROUNDING)
    same = same and is_near(step_size, step.step_size, STEP_TOLERANCE)
    for k in range(motion.bearings.shape[0]):
        bearing, reference = motion.bearings[k], key.bearings[k]
        same = same and same_passive(bearing, reference, ROUNDING)
        for axis in range(2):
            same = same and is_near(bearing.gradient[axis], reference.gradient[axis], ROUNDING)
    return same


@kernel
def without_rounding(motion: Motion, key: Key) -> Motion:
    """Return a motion with the exact speed and bearings of the key that it matches within rounding.

    So P is the same to the last bit, regardless of the step in which it is built.
    """
    copy_all(key.bearings, motion.bearings)
    return motion_at(motion, motion.theta, key.step[0].Omega)


@kernel
def is_left_to_pieces(propagator: Propagator) -> bool:
    """Return whether the series of a step would require too many pieces."""
    return bool(propagator.built[0].n_pieces == 0.0)


@kernel
def is_begun(propagator: Propagator, key: Key) -> bool:
    """Return whether the built part of P is for this key."""
    return same_bits(propagator.key.values, key.values)


@kernel
def is_built(propagator: Propagator, key: Key) -> bool:
    """Return whether P was built for this key."""
    return bool(propagator.built[0].n_rows == propagator.P.shape[0]) and is_begun(propagator, key)
