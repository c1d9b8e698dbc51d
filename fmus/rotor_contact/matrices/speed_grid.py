"""Matrices of exact motion between the speeds for which they are built.

P and S (`step_matrices`) depend on the speed through gyroscopic terms, rotating damping and the rotation of the
unbalance. A constant prescribed speed uses separate matrices (`constant_speed`). Other speeds are rounded to multiples
of `QUANTUM` d (see below), with an error of g d h/4096. A level in use can therefore be interpolated once for many
pieces. The result has the same bits as an interpolation in each product.

Matrices are built for speeds m d apart. The matrices for the speeds of the grid, which are d/4 apart, follow from the
parabola through the nearest three that are built. A speed of the grid is t m d above the middle one of these three,
with -1/2 <= t <= 1/2. The matrices between two speeds of the grid follow from the line through the matrices at these
two speeds:

    P(t) = t (t - 1)/2 P(-1) + (1 - t^2) P(0) + t (t + 1)/2 P(1),    errors (g m d h)^3/16 and (g d h/4)^2/8

The errors are relative to P, and g <= 2 is the rate at which gyroscopic moments turn the velocity, divided by the speed
(2 for a thin disc). Most steps need only one or two levels, so a level is interpolated, for the present inputs, only
when a step first uses it. If seals depend on the speed, matrices are built for all speeds of the grid, which are then d
apart.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.model import Array
from rotor_contact.matrices.matrix_sizes import FIRST_CONSTANT, MAX_LEVELS, N_BUILT, N_NEAR, N_SLOTS
from rotor_contact.matrices.step_matrices import (
    Level,
    Powers,
    StepMatrices,
    coefficients_at,
    forget_combined,
    level_of,
    powers_of,
    rows_of_x,
)
from rotor_contact.shaft.products import interpolate
from rotor_contact.shaft.seals import Seals

INTERPOLATION_ERROR = 1e-6  # of the velocities, between two speeds d apart
GYROSCOPIC = 2.0  # largest g, see above
FINER = 4  # spacing of the grid over that for all of whose speeds matrices are built
STRIDE = 8 * FINER  # of the grid, from one speed whose matrices are built to the next
BLENDS = N_SLOTS  # slot of the levels that are interpolated
CONSTANT = 2.0**40  # place of the first slot of a constant speed, beyond all speeds of the grid
QUANTUM = 2.0**-11  # of d, to which speeds are rounded
USES_BEFORE_BLEND = 3.0  # pieces of a level at a speed before it is interpolated, which costs as much as some pieces


class LevelsAround(NamedTuple):
    """The matrices of a level at the grid speeds below and above a speed; `share` is its position between them, 0 to 1.

    If `share` is 0, `low` is for the speed itself, whether or not it is on the grid.
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
def grid_speed(matrices: StepMatrices, index: float) -> float:
    """Return the speed (rad/s) at a position on the grid."""
    if index >= CONSTANT:
        constant: float = matrices.constant[int(index - CONSTANT), 0]
        return constant
    speed: float = index * matrices.sizes[0].spacing
    return speed


@kernel
def place_on_grid(matrices: StepMatrices, Omega: float) -> float:
    """Return the position of a speed (rad/s) on the grid, rounded to a multiple of the quantum.

    The position is infinite if the speed is beyond the grid or is not a number.
    """
    sizes = matrices.sizes[0]
    place: float = sizes.place
    if place == 0.0:
        if not abs(Omega) < CONSTANT * sizes.spacing:
            return math.inf
        place = math.floor(Omega / sizes.spacing / sizes.quantum + 0.5) * sizes.quantum
    return place


@kernel
def stride_for(seals: Seals) -> int:
    """Return the stride between the grid speeds with built matrices: 1 if seals depend on the speed, else `STRIDE`."""
    return 1 if seals.records.shape[0] > 1 else STRIDE


@kernel
def slot_of(index: float) -> int:
    """Return the slot of a point of the grid, or of a constant speed."""
    if index >= CONSTANT:
        return FIRST_CONSTANT + int(index - CONSTANT)
    return int(index - N_NEAR * math.floor(index / N_NEAR))


@kernel
def built_slot_of(number: float) -> int:
    """Return the slot of speed `number` among the speeds for which matrices are built, which are `STRIDE` apart."""
    return N_NEAR + int(number - N_BUILT * math.floor(number / N_BUILT))


@kernel
def middle_of(index: float) -> float:
    """Return the number of the middle one of the three built speeds around a point of the grid."""
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


@views
def powers_around(matrices: StepMatrices, level: int, index: float) -> tuple[Powers, Powers]:
    """Return the forms of spin and seals that belong to `levels_around`."""
    low = math.floor(index)
    if index == low or is_blended(matrices, level, index):
        of_speed = powers_of(matrices, slot_of(low) if index == low else BLENDS, level)
        return of_speed, of_speed
    return powers_of(matrices, slot_of(low), level), powers_of(matrices, slot_of(low + 1.0), level)


@kernel
def note_use(matrices: StepMatrices, level: int, index: float) -> None:
    """Count a piece of a level at a point of the grid; after several pieces the level is interpolated."""
    if index == math.floor(index):
        return
    blend = matrices.blends[level]
    if blend.index != index:
        blend.index, blend.n_uses = index, 0.0
        matrices.combined[BLENDS * MAX_LEVELS + level] = 0.0
    blend.n_uses += 1.0


@noinline_kernel
def interpolate_level(matrices: StepMatrices, level: int, index: float) -> None:
    """Interpolate a combined level between the grid speeds around a point, and write it to the blends."""
    low = math.floor(index)
    below, above = level_of(matrices, slot_of(low), level), level_of(matrices, slot_of(low + 1.0), level)
    target, share = level_of(matrices, BLENDS, level), index - low
    for row in range(rows_of_x(matrices)):
        interpolate(below.P[row], above.P[row], share, target.P[row], below.P.shape[1])
        interpolate(below.S[row], above.S[row], share, target.S[row], below.S.shape[1])
        if matrices.sizes[0].damped != 0.0:
            interpolate(below.H[row], above.H[row], share, target.H[row], _up_to_diagonal(row))
    if matrices.sizes[0].powered == 0.0:
        return
    of_below, of_above = powers_of(matrices, slot_of(low), level), powers_of(matrices, slot_of(low + 1.0), level)
    of_target, weight = powers_of(matrices, BLENDS, level), share * (1.0 - share) * matrices.sizes[0].spacing
    for row in range(rows_of_x(matrices)):
        size = _up_to_diagonal(row)
        interpolate(of_below.spin[row], of_above.spin[row], share, of_target.spin[row], size)
        for i in range(size):
            target.H[row, i] += weight * (of_above.spin[row, i] - of_below.spin[row, i])
        if matrices.sizes[0].powered == 2.0:
            interpolate(of_below.seals[row], of_above.seals[row], share, of_target.seals[row], size)


@noinline_kernel
def begin_interpolation(matrices: StepMatrices, index: float) -> None:
    """Assign a slot to a point of the grid between three built ones; write its K and C, but no level."""
    which, middle = slot_of(index), middle_of(index)
    if matrices.slots[which].index == index:
        return
    matrices.slots[which].index = index
    forget_combined(matrices, which)
    below = coefficients_at(matrices, built_slot_of(middle - 1.0)).columns
    at = coefficients_at(matrices, built_slot_of(middle)).columns
    above = coefficients_at(matrices, built_slot_of(middle + 1.0)).columns
    target, t = coefficients_at(matrices, which).columns, index / STRIDE - middle
    for row in range(target.shape[0]):
        _parabola(below[row], at[row], above[row], t, target[row], target.shape[1])


@noinline_kernel
def interpolate_from_built(matrices: StepMatrices, level: int, index: float) -> None:
    """Interpolate a level at a grid speed from three speeds for which it is combined, without rows of unit inputs."""
    middle, target = middle_of(index), level_of(matrices, slot_of(index), level)
    below = level_of(matrices, built_slot_of(middle - 1.0), level)
    at = level_of(matrices, built_slot_of(middle), level)
    above = level_of(matrices, built_slot_of(middle + 1.0), level)
    t = index / STRIDE - middle
    for row in range(rows_of_x(matrices)):
        _parabola(below.P[row], at.P[row], above.P[row], t, target.P[row], target.P.shape[1])
        _parabola(below.S[row], at.S[row], above.S[row], t, target.S[row], target.S.shape[1])
        if matrices.sizes[0].damped != 0.0:
            _parabola(below.H[row], at.H[row], above.H[row], t, target.H[row], _up_to_diagonal(row))
    if matrices.sizes[0].powered != 0.0:
        spin = powers_of(matrices, slot_of(index), level).spin
        of_below = powers_of(matrices, built_slot_of(middle - 1.0), level).spin
        of_middle = powers_of(matrices, built_slot_of(middle), level).spin
        of_above = powers_of(matrices, built_slot_of(middle + 1.0), level).spin
        for row in range(rows_of_x(matrices)):
            _parabola(of_below[row], of_middle[row], of_above[row], t, spin[row], _up_to_diagonal(row))
        if matrices.sizes[0].powered == 2.0:
            _interpolate_seals(matrices, level, index, t)


@noinline_kernel
def _interpolate_seals(matrices: StepMatrices, level: int, index: float, t: float) -> None:
    """Interpolate the form of seals whose coefficients do not depend on the speed."""
    middle, target = middle_of(index), powers_of(matrices, slot_of(index), level).seals
    below = powers_of(matrices, built_slot_of(middle - 1.0), level).seals
    at = powers_of(matrices, built_slot_of(middle), level).seals
    above = powers_of(matrices, built_slot_of(middle + 1.0), level).seals
    for row in range(rows_of_x(matrices)):
        _parabola(below[row], at[row], above[row], t, target[row], _up_to_diagonal(row))


@kernel
def _up_to_diagonal(row: int) -> int:
    """Return how many elements of a row of H are read: those up to the diagonal, rounded up to an even number."""
    return row // 2 * 2 + 2


@noinline_kernel
def _parabola(below: Array, at: Array, above: Array, t: float, target: Array, size: int) -> None:
    """Write into `target` the values at t of `size` parabolas, each through three points at -1, 0 and 1."""
    of_below, of_middle, of_above = 0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)
    for i in range(size):
        target[i] = of_middle * at[i] + (of_below * below[i] + of_above * above[i])
