"""Matrices of exact motion between the speeds for which they are built.

P and S (`step_matrices`) depend on the speed through gyroscopic terms, rotating damping and the rotation of the
unbalance. A constant prescribed speed has matrices of its own (`constant_speed`). Other speeds are rounded to
`QUANTUM` of d below, an error of g d h/4096, so that a level in use is interpolated once for many pieces; it gives the
bits of an interpolation in each product.

Matrices are built for speeds m d apart. Those of the grid, d/4 apart, follow from the parabola through the nearest
three that are built, at t of m d from the middle one, -1/2 <= t <= 1/2, and those between two speeds of the grid from
the line through these,

    P(t) = t (t - 1)/2 P(-1) + (1 - t^2) P(0) + t (t + 1)/2 P(1),    errors (g m d h)^3/16 and (g d h/4)^2/8

relative to P, where g <= 2 is the rate of gyroscopic rotation of the velocity per speed (2 for a thin disc). If seals
depend on the speed, matrices are built for all speeds of the grid, which are d apart.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.parts import part
from rotor_contact.products import interpolate
from rotor_contact.seals import Seals
from rotor_contact.step_matrices import (
    MAX_LEVELS,
    N_BUILT,
    N_NEAR,
    N_SLOTS,
    Level,
    StepMatrices,
    forget_combined,
    level_of,
    place_of_level,
    place_of_slot,
)
from rotor_contact.structure import REAL

INTERPOLATION_ERROR = 1e-6  # of the velocities, between two speeds d apart
GYROSCOPIC = 2.0  # largest g, see above
FINER = 4  # spacing of the grid over that for all of whose speeds matrices are built
STRIDE = 8 * FINER  # of the grid, from one speed whose matrices are built to the next
BLENDS = N_SLOTS  # slot of the levels that are interpolated
FIRST_CONSTANT = BLENDS + 1  # slot of a constant speed
CONSTANT = 2.0**40  # place of the first slot of a constant speed, beyond all speeds of the grid
QUANTUM = 2.0**-11  # of d, to which speeds are rounded
USES_BEFORE_BLEND = 3.0  # pieces of a level at a speed before it is interpolated, which costs as much as some pieces


class LevelsAround(NamedTuple):
    """The matrices of a level at the speeds of the grid below and above a speed, at the fraction `share`.

    If the fraction is 0, `low` is for the speed itself, on the grid or between.
    """

    low: Level
    high: Level
    share: float


@kernel
def spacing_for(step_size: float, seals: Seals) -> float:
    """Return the spacing of the grid (rad/s) for steps of this length (s)."""
    spacing = math.sqrt(8.0 * INTERPOLATION_ERROR) / (GYROSCOPIC * step_size)
    return spacing if stride_for(seals) == 1 else spacing / FINER


@kernel
def quantum_for(seals: Seals) -> float:
    """Return the share of the spacing to which speeds are rounded."""
    return QUANTUM if stride_for(seals) == 1 else FINER * QUANTUM


@kernel
def grid_speed(matrices: StepMatrices, index: float) -> float:
    """Return the speed (rad/s) at a position on the grid."""
    if index >= CONSTANT:
        constant: float = matrices.constant[int(index - CONSTANT), 0]
        return constant
    speed: float = index * matrices.sizes[0].spacing
    return speed


@kernel
def place_on_grid(matrices: StepMatrices, Omega: float) -> float:
    """Return the position of a speed (rad/s) on the grid, rounded to a multiple of the quantum."""
    sizes = matrices.sizes[0]
    place: float = sizes.place
    if place == 0.0:
        place = math.floor(Omega / sizes.spacing / sizes.quantum + 0.5) * sizes.quantum
    return place


@kernel
def stride_for(seals: Seals) -> int:
    """Return how many speeds of the grid apart matrices are built: 1 if seals depend on the speed, else `STRIDE`."""
    return 1 if seals.records.shape[0] > 1 else STRIDE


@kernel
def slot_of(index: float) -> int:
    """Return the slot of a point of the grid, or of a constant speed."""
    if index >= CONSTANT:
        return FIRST_CONSTANT + int(index - CONSTANT)
    return int(index - N_NEAR * math.floor(index / N_NEAR))


@kernel
def built_slot_of(number: float) -> int:
    """Return the slot of the speed of this number among those, `STRIDE` apart, that others are interpolated from."""
    return N_NEAR + int(number - N_BUILT * math.floor(number / N_BUILT))


@kernel
def middle_of(index: float) -> float:
    """Return the number of the middle one of three such speeds around a point of the grid."""
    return float(math.floor(index / STRIDE + 0.5))


@views
def is_blended(matrices: StepMatrices, level: int, index: float) -> bool:
    """Return whether a level is, or will be, interpolated at a point between the speeds of the grid."""
    blend = matrices.blends[level]
    return bool(blend.index == index and blend.n_uses >= USES_BEFORE_BLEND)


@views
def levels_around(matrices: StepMatrices, level: int, index: float) -> LevelsAround:
    """Return the matrices of a level around a point of the grid."""
    low = math.floor(index)
    if index == low or is_blended(matrices, level, index):
        of_speed = level_of(matrices, slot_of(low) if index == low else BLENDS, level)
        return LevelsAround(of_speed, of_speed, 0.0)
    return LevelsAround(
        level_of(matrices, slot_of(low), level), level_of(matrices, slot_of(low + 1.0), level), index - low
    )


@kernel
def note_use(matrices: StepMatrices, level: int, index: float) -> None:
    """Count a piece of a level at a point of the grid; after several the level is interpolated (`matrix_inputs`)."""
    if index == math.floor(index):
        return
    blend = matrices.blends[level]
    if blend.index != index:
        blend.index, blend.n_uses = index, 0.0
        matrices.combined[BLENDS * MAX_LEVELS + level] = 0.0
    blend.n_uses += 1.0


@noinline_kernel
def interpolate_level(matrices: StepMatrices, level: int, index: float) -> None:
    """Write a level between the speeds around a point of the grid to the blends."""
    low, size = math.floor(index), _level_size(matrices)
    target = part(matrices.memory, place_of_level(matrices, BLENDS, level), REAL, size)
    below = part(matrices.memory, place_of_level(matrices, slot_of(low), level), REAL, size)
    above = part(matrices.memory, place_of_level(matrices, slot_of(low + 1.0), level), REAL, size)
    interpolate(below, above, index - low, target, size)


@kernel
def _level_size(matrices: StepMatrices) -> int:
    """Return the number of float64 in a level."""
    size: int = place_of_level(matrices, 0, 1) - place_of_level(matrices, 0, 0)
    return size


@noinline_kernel
def interpolate_slot(matrices: StepMatrices, index: float) -> None:
    """Interpolate the slot of a point of the grid, K and C included, from three that are built."""
    sizes, which, middle = matrices.sizes[0], slot_of(index), middle_of(index)
    used = place_of_level(matrices, 0, int(sizes.n_levels) - 1) + _level_size(matrices)
    target = part(matrices.memory, place_of_slot(matrices, which), REAL, used)
    below = part(matrices.memory, place_of_slot(matrices, built_slot_of(middle - 1.0)), REAL, used)
    at = part(matrices.memory, place_of_slot(matrices, built_slot_of(middle)), REAL, used)
    above = part(matrices.memory, place_of_slot(matrices, built_slot_of(middle + 1.0)), REAL, used)
    t = index / STRIDE - middle
    of_below, of_middle, of_above = 0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)
    for i in range(used):
        target[i] = of_middle * at[i] + (of_below * below[i] + of_above * above[i])
    slot = matrices.slots[which]
    slot.index, slot.n_rows = index, sizes.n_rows * sizes.n_built
    forget_combined(matrices, which)
