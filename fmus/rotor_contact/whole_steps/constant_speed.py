"""Matrices at a constant, prescribed speed, built for exactly this speed and with the gradients of the magnets.

    K = K_0 - diag(g_0),   f = F + (g - g_0) q    at each axis of a magnetic bearing            (1)

g_0 are the gradients in the matrices, g the gradients of the present step, and f is the force at the nodes of a piece
(`piece_ports`). Gradients that vary around g_0, such as those of nonlinear magnets, therefore leave only small forces
at the nodes.

The matrices are built over `STEPS_BEFORE_BUILD` steps. Gradients that stay far from g_0 for many steps, such as the
gradients of magnets that were switched off, become the next g_0. Their matrices are built in a separate slot while the
old matrices are used.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.flat import copy, same_bits
from fmi_export.jit import inlined_kernel, kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rotor_contact.contact.site import Sites
from rotor_contact.forces.dynamics import Motion
from rotor_contact.matrices.matrix_inputs import combine_ahead
from rotor_contact.matrices.matrix_levels import choose_levels
from rotor_contact.matrices.matrix_rows import build_slot, is_complete
from rotor_contact.matrices.matrix_schedule import STEPS_BEFORE_BUILD, count_of_steps
from rotor_contact.matrices.matrix_sizes import FIRST_CONSTANT, N_CONSTANT
from rotor_contact.matrices.speed_grid import CONSTANT
from rotor_contact.matrices.step_matrices import MatricesKey, StepMatrices, is_for
from rotor_contact.shaft.structure import REAL, Structure
from rotor_contact.whole_steps.whole_step import derive_whole_step

NEAR = 0.1  # of the largest gradient, by which gradients may differ from those in the matrices
PATIENCE = 96.0  # steps with gradients farther away, before matrices with them are built

# The speed (rad/s), whether there are matrices for it, the number of steps for the next ones, and whether the matrices
# of the grid have been used with this key, and the number of steps for which these have been built ahead.
SPEED = record(
    ("Omega", np.float64),
    ("is_known", np.float64),
    ("n_steps", np.float64),
    ("uses_grid", np.float64),
    ("n_grid", np.float64),
)
N_SPEED = size_of(SPEED) + size_of(SPEED) % 2  # even, as all places of parts


class ConstantSpeed(NamedTuple):
    """The constant speed: a record of type `SPEED`, in an array of length 1, and gradients (N/m), shape (2 bearings,).

    `known` contains the gradients in the matrices, and `following` the gradients in the next matrices.
    """

    speed: np.ndarray[tuple[int], np.dtype[np.record]]
    known: Array
    following: Array


@views
def constant_speed_size(n_bearings: int) -> int:
    """Return how many float64 values a `ConstantSpeed` occupies; the number is even."""
    return N_SPEED + 4 * n_bearings


@views
def constant_speed_of(array: Array, at: int, n_bearings: int) -> ConstantSpeed:
    """Return a `ConstantSpeed` as views into an array, from position `at`."""
    return ConstantSpeed(
        part(array, at, SPEED, 1),
        part(array, at + N_SPEED, REAL, 2 * n_bearings),
        part(array, at + N_SPEED + 2 * n_bearings, REAL, 2 * n_bearings),
    )


@inlined_kernel
def follow(motion: Motion, is_constant: bool, is_same: bool, constant: ConstantSpeed, memory: np.record) -> None:
    """Count the steps at a constant speed; choose the gradients for the matrices at this speed.

    `is_same` states whether the key of the matrices is the same as in the last step.
    """
    speed = constant.speed[0]
    if not is_same:
        speed.uses_grid = 0.0
    if not is_same or (is_constant and motion.Omega != speed.Omega):
        speed.Omega, speed.is_known, speed.n_steps = motion.Omega, 0.0, 0.0
        _choose_gradients(motion, constant.following)
    elif is_constant and speed.is_known == 0.0:
        if memory.has_matrices == 0.0:
            _choose_gradients(motion, constant.following)
        speed.n_steps = count_of_steps(speed.n_steps, memory, float(STEPS_BEFORE_BUILD))
        if speed.n_steps >= STEPS_BEFORE_BUILD:
            copy(constant.following, constant.known)
            speed.is_known, speed.n_steps = 1.0, 0.0
    elif is_constant:
        if _are_near(motion, constant.known):
            speed.n_steps = 0.0
        elif speed.n_steps == 0.0 or not _are_near(motion, constant.following):
            _choose_gradients(motion, constant.following)
            speed.n_steps = 1.0
        else:
            speed.n_steps += 1.0
            if speed.n_steps >= PATIENCE + STEPS_BEFORE_BUILD:
                copy(constant.following, constant.known)
                speed.n_steps = 0.0


@kernel
def _choose_gradients(motion: Motion, gradients: Array) -> None:
    """Write the gradients of the magnets; two axes with similar gradients get their mean, to keep a rotor isotropic."""
    for b in range(motion.bearings.shape[0]):
        x, y = motion.bearings[b].gradient[0], motion.bearings[b].gradient[1]
        if abs(x - y) <= NEAR * max(abs(x), abs(y)):
            x = y = 0.5 * (x + y)
        gradients[2 * b], gradients[2 * b + 1] = x, y


@kernel
def _are_near(motion: Motion, gradients: Array) -> bool:
    """Return whether the gradients of the magnets are near these `gradients`."""
    largest = change = 0.0
    for b in range(motion.bearings.shape[0]):
        for axis in range(2):
            gradient, known = motion.bearings[b].gradient[axis], gradients[2 * b + axis]
            largest, change = max(largest, abs(known)), max(change, abs(gradient - known))
    return bool(change <= NEAR * largest)


@inlined_kernel
def use_constant_speed(
    structure: Structure,
    motion: Motion,
    sites: Sites,
    key: MatricesKey,
    matrices: StepMatrices,
    constant: ConstantSpeed,
) -> bool:
    """Build the matrices for the motion's constant speed; return whether they are complete and thus in use."""
    if not is_for(matrices, key):
        choose_levels(structure, motion, sites, key, matrices)
    sizes, speed = matrices.sizes[0], constant.speed[0]
    if sizes.n_levels == 0.0:
        return False
    is_known = speed.is_known != 0.0
    share = (speed.n_steps - (PATIENCE if is_known else 0.0)) / STEPS_BEFORE_BUILD
    if share > 0.0:
        which = _slot_for(matrices, speed.Omega, constant.following, constant.known)
        _build(structure, motion, sites, matrices, which, share)
    if not is_known:
        return False
    which = _slot_for(matrices, speed.Omega, constant.known, constant.following)
    _build(structure, motion, sites, matrices, which, 1.0)
    if not is_complete(matrices, FIRST_CONSTANT + which, CONSTANT + which):
        return False
    sizes.place, sizes.isotropic = CONSTANT + which, matrices.slots[FIRST_CONSTANT + which].isotropic
    copy(matrices.constant[which, 1:], matrices.gradients)
    combine_ahead(matrices, FIRST_CONSTANT + which)
    return True


@kernel
def use_grid(matrices: StepMatrices) -> None:
    """Switch from the matrices for a constant speed to the matrices of the grid."""
    sizes = matrices.sizes[0]
    sizes.place, sizes.isotropic = 0.0, sizes.grid_isotropic
    matrices.gradients[:] = 0.0


@inlined_kernel
def _slot_for(matrices: StepMatrices, Omega: float, gradients: Array, others: Array) -> int:
    """Return the slot for this speed and these gradients, or assign one that does not contain the `others`."""
    for which in range(N_CONSTANT):
        if _is_of(matrices, which, Omega, gradients):
            return which
    which = 1 if _is_of(matrices, 0, Omega, others) else 0
    matrices.constant[which, 0] = Omega
    copy(gradients, matrices.constant[which, 1:])
    matrices.slots[FIRST_CONSTANT + which].index = math.nan
    return which


@inlined_kernel
def _is_of(matrices: StepMatrices, which: int, Omega: float, gradients: Array) -> bool:
    """Return whether a slot contains rows for this speed and these gradients."""
    is_begun = matrices.slots[FIRST_CONSTANT + which].index == CONSTANT + which
    same = matrices.constant[which, 0] == Omega and same_bits(matrices.constant[which, 1:], gradients)
    return bool(is_begun and same)


@kernel
def _build(
    structure: Structure, motion: Motion, sites: Sites, matrices: StepMatrices, which: int, share: float
) -> None:
    """Build a share of the rows of a slot, and the matrices of a whole step once all rows are complete."""
    slot, place = FIRST_CONSTANT + which, CONSTANT + which
    if not is_complete(matrices, slot, place):
        build_slot(structure, motion, sites, matrices, slot, place, share)
        if is_complete(matrices, slot, place):
            derive_whole_step(structure.Minv, motion, sites, matrices, which, True)
