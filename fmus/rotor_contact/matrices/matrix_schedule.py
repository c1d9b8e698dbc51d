"""When the matrices of a step are built: after several equal steps, and only while the speed changes slowly."""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import is_near
from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rotor_contact.contact.site import Sites
from rotor_contact.forces.dynamics import Motion
from rotor_contact.forces.passive_bearings import same_passive, set_passive
from rotor_contact.matrices.matrix_inputs import combine_ahead
from rotor_contact.matrices.matrix_levels import choose_levels
from rotor_contact.matrices.matrix_rows import build_slot, is_complete, share_of
from rotor_contact.matrices.matrix_sizes import N_SITE_KEY
from rotor_contact.matrices.speed_grid import (
    CONSTANT,
    STRIDE,
    begin_interpolation,
    built_slot_of,
    middle_of,
    place_on_grid,
    slot_of,
    spacing_for,
    stride_for,
)
from rotor_contact.matrices.step_matrices import MatricesKey, StepMatrices, is_for
from rotor_contact.shaft.structure import Structure

STEPS_BEFORE_BUILD = 32  # in which matrices are built, row by row; altogether that costs as much as they do
STEP_TOLERANCE = 1e-9  # relative; a master that subtracts times rounds in the last digits of the step
STEPS_PER_SPEED = 16.0  # steps that are subtracted from the count for every speed passed that is built


@inlined_kernel
def steps_with_matrices(
    motion: Motion, sites: Sites, step_size: float, key: MatricesKey, memory: np.record
) -> tuple[bool, float]:
    """Return whether the key of the matrices is unchanged, and the number of steps since it changed (at most about 32).

    `key` is updated. When the spin speed passes a speed for which matrices are built, the number decreases by
    `STEPS_PER_SPEED`. During fast speed changes the motion is therefore integrated, because building the matrices costs
    as much as about thirty steps.
    """
    same = is_near(step_size, key.step_size[0], STEP_TOLERANCE)
    if not same:
        key.step_size[0] = step_size
    for k in range(motion.bearings.shape[0]):
        if not same_passive(motion.bearings[k], key.bearings[k], 0.0):
            same = False
            set_passive(key.bearings[k], motion.bearings[k])
    for k in range(sites.shape[0]):
        same = _housing_is_unchanged(sites[k], key.sites[k]) and same
    between_built = stride_for(motion.seals) * spacing_for(key.step_size[0], motion.seals)
    place = math.floor(motion.Omega / between_built)
    moved = abs(place - float(memory.place))
    memory.place = place
    n_steps = 0.0
    if same and moved <= 1.0:
        count = max(float(memory.n_matrix_steps) - STEPS_PER_SPEED * moved, -1.0)
        n_steps = count_of_steps(count, memory, STEPS_BEFORE_BUILD + STEPS_PER_SPEED)
    memory.n_matrix_steps = n_steps
    return same, n_steps


@kernel
def count_of_steps(count: float, memory: np.record, largest: float) -> float:
    """Return the next count of equal steps, at most `largest`.

    The first matrices of a run are built at once, because the start of the run would otherwise be less accurate than
    the rest.
    """
    return min(count + 1.0, largest) if memory.has_matrices != 0.0 else float(STEPS_BEFORE_BUILD)


@kernel
def _housing_is_unchanged(site: np.record, stored: Array) -> bool:
    """Return whether the housing of a site is unchanged; update its stored parameters."""
    stiffness, damping = (site.mount_stiffness_x, site.mount_stiffness_y), (site.mount_damping_x, site.mount_damping_y)
    now, same = (float(site.housing), site.mobility, *stiffness, *damping), True
    for i in range(N_SITE_KEY):
        same = same and stored[i] == now[i]
        stored[i] = now[i]
    return same


@kernel
def update_matrices(
    structure: Structure, motion: Motion, sites: Sites, key: MatricesKey, matrices: StepMatrices, share: float
) -> bool:
    """Build a share of the matrices for the speeds around the present one; return whether they can be used.

    The matrices for the next speed are built while the present speed approaches it.
    """
    if not is_for(matrices, key):
        choose_levels(structure, motion, sites, key, matrices)
    if matrices.sizes[0].n_levels == 0.0:
        return False
    index, stride = place_on_grid(matrices, motion.Omega), matrices.sizes[0].stride
    if math.isinf(index):
        return False
    low = float(math.floor(index))  # the type of `first`: for two types all that follows is compiled twice
    n_near = 1 if index == low else 2
    is_direct = stride == 1.0
    first = low if is_direct else middle_of(low) - 1.0
    n_built = n_near if is_direct else int(middle_of(low + n_near - 1.0) + 1.0 - first) + 1
    for i in range(n_built):
        part_of_it = min(max(n_built * share - i, 0.0), 1.0)
        if part_of_it > 0.0:
            _build(structure, motion, sites, matrices, is_direct, first + i, part_of_it)
    if share < 1.0 or not complete_speeds(matrices, index):
        return False
    if n_near > 1:
        _look_ahead(structure, motion, sites, matrices, is_direct, index)
    if not combine_ahead(matrices, slot_of(low)) and n_near > 1 and not combine_ahead(matrices, slot_of(low + 1.0)):
        following = low + 2.0 if index - low > 0.5 else low - 1.0
        if _complete(matrices, following):
            combine_ahead(matrices, slot_of(following))
    return True


@kernel
def complete_speeds(matrices: StepMatrices, index: float) -> bool:
    """Return whether the levels for the speeds around a point of the grid are built or can be interpolated."""
    if math.isinf(index):
        return False
    low = float(math.floor(index))
    return _complete(matrices, low) and (index == low or _complete(matrices, low + 1.0))


@kernel
def _complete(matrices: StepMatrices, index: float) -> bool:
    """Return whether levels exist for a grid speed; if they will be interpolated, assign a slot to this speed."""
    if matrices.sizes[0].stride == 1.0 or index >= CONSTANT:
        return is_complete(matrices, slot_of(index), index)
    middle = middle_of(index)
    for i in range(3):
        number = middle - 1.0 + i
        if not is_complete(matrices, built_slot_of(number), STRIDE * number):
            return False
    begin_interpolation(matrices, index)
    return True


@kernel
def _look_ahead(
    structure: Structure, motion: Motion, sites: Sites, matrices: StepMatrices, is_direct: bool, index: float
) -> None:
    """Build a share of the matrices for the next speed; the share grows as the present speed approaches the next."""
    if is_direct:
        low = float(math.floor(index))
        beyond = index - low - 0.5
        number, share = low + 2.0 if beyond > 0.0 else low - 1.0, 3.0 * abs(beyond) - 0.3
    else:
        beyond = index / STRIDE - middle_of(index)
        number = middle_of(index) + 2.0 if beyond > 0.0 else middle_of(index) - 2.0
        share = 5.0 * abs(beyond) - 1.3  # complete before the first speed that is interpolated from it
    if share > 0.0:
        which, place = (slot_of(number), number) if is_direct else (built_slot_of(number), STRIDE * number)
        share = min(share, share_of(matrices, which, place) + 1.0 / STEPS_BEFORE_BUILD)
        _build(structure, motion, sites, matrices, is_direct, number, min(share, 1.0))


@kernel
def _build(
    structure: Structure,
    motion: Motion,
    sites: Sites,
    matrices: StepMatrices,
    is_direct: bool,
    number: float,
    share: float,
) -> None:
    """Build a share of the matrices for a speed, unless they are complete.

    `number` counts all speeds of the grid if `is_direct` is true, and otherwise the speeds `STRIDE` apart.
    """
    which, index = (slot_of(number), number) if is_direct else (built_slot_of(number), STRIDE * number)
    if not is_complete(matrices, which, index):
        build_slot(structure, motion, sites, matrices, which, index, share)
