"""Matrices of exact motion between the speeds for which they are built.

P and S (`step_matrices`) depend on the speed through gyroscopic terms, rotating damping and the rotation of the
unbalance. They are interpolated between speeds on a grid of spacing d, with a relative error of (g d h)^2/8, where
g <= 2 is the rate of gyroscopic rotation of the velocity per speed (2 for a thin disc). A constant prescribed speed is
on the grid. Other speeds are rounded to d/2048, an error of g d h/4096, so that a level in use is interpolated once for
many pieces; it gives the bits of an interpolation in each product.

Matrices are built for every `STRIDE`-th speed of the grid, m d apart. Those of the speeds between follow from the
parabola through three that are built, nearest first, at t of m d from the middle one, -1/2 <= t <= 1/2,

    P(t) = t (t - 1)/2 P(-1) + (1 - t^2) P(0) + t (t + 1)/2 P(1),    error (g m d h)^3/16 at most

which is 0.7 of that between speeds of the grid. If seals depend on the speed, all speeds of the grid are built.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.parts import part
from rotor_contact.products import interpolate
from rotor_contact.seals import Seals
from rotor_contact.step_matrices import (
    N_BUILT,
    N_NEAR,
    N_SLOTS,
    Level,
    StepMatrices,
    level_of,
    level_size,
    n_rows,
    slot_size,
)
from rotor_contact.structure import REAL

INTERPOLATION_ERROR = 1e-6  # of the velocities, by speeds between those on the grid
GYROSCOPIC = 2.0  # largest g, see above
STRIDE = 8  # of the grid, from one speed whose matrices are built to the next
BLENDS = N_SLOTS  # slot of the levels that are interpolated
QUANTUM = 2.0**-11  # of the spacing, to which speeds are rounded
USES_BEFORE_BLEND = 3.0  # pieces of a level at a speed before it is interpolated, which costs as much as some pieces


class LevelsAround(NamedTuple):
    """The matrices of a level at the speeds of the grid below and above a speed, at the fraction `share`.

    If the fraction is 0, `low` is for the speed itself, on the grid or between.
    """

    low: Level
    high: Level
    share: float


@kernel
def spacing_for(step_size: float) -> float:
    """Return the spacing of the speeds (rad/s) for steps of this length (s)."""
    return math.sqrt(8.0 * INTERPOLATION_ERROR) / (GYROSCOPIC * step_size)


@kernel
def grid_speed(matrices: StepMatrices, index: float) -> float:
    """Return a speed (rad/s) of the grid."""
    speed: float = matrices.key.origin[0] + index * matrices.sizes[0].spacing
    return speed


@kernel
def place_on_grid(matrices: StepMatrices, Omega: float) -> float:
    """Return the position of a speed (rad/s) on the grid, rounded to a multiple of `QUANTUM`."""
    place: float = (Omega - matrices.key.origin[0]) / matrices.sizes[0].spacing
    return math.floor(place / QUANTUM + 0.5) * QUANTUM


@kernel
def stride_for(seals: Seals) -> int:
    """Return how many speeds of the grid apart matrices are built: 1 if seals depend on the speed, else `STRIDE`."""
    return 1 if seals.records.shape[0] > 1 else STRIDE


@kernel
def slot_of(index: float) -> int:
    """Return the slot of a point of the grid."""
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
def levels_around(matrices: StepMatrices, level: int, index: float) -> LevelsAround:
    """Return the matrices of a level around a point of the grid."""
    low, blend = math.floor(index), matrices.blends[level]
    if index == low or (blend.index == index and blend.n_uses >= USES_BEFORE_BLEND):
        of_speed = level_of(matrices, slot_of(low) if index == low else BLENDS, level)
        return LevelsAround(of_speed, of_speed, 0.0)
    return LevelsAround(
        level_of(matrices, slot_of(low), level), level_of(matrices, slot_of(low + 1.0), level), index - low
    )


@kernel
def note_use(matrices: StepMatrices, level: int, index: float) -> None:
    """Count a piece of a level at a point of the grid; interpolate the level if there have been several."""
    if index == math.floor(index):
        return
    blend = matrices.blends[level]
    if blend.index != index:
        blend.index, blend.n_uses = index, 0.0
    blend.n_uses += 1.0
    if blend.n_uses == USES_BEFORE_BLEND:
        _interpolate(matrices, level, index)


@noinline_kernel
def _interpolate(matrices: StepMatrices, level: int, index: float) -> None:
    """Write a level between the speeds around a point of the grid to the blends."""
    n, n_ports, low = int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports), math.floor(index)
    size, slot = level_size(n, n_ports), slot_size(n, n_ports)
    at = 2 * n * n + level * size
    target = part(matrices.memory, BLENDS * slot + at, REAL, size)
    below = part(matrices.memory, slot_of(low) * slot + at, REAL, size)
    above = part(matrices.memory, slot_of(low + 1.0) * slot + at, REAL, size)
    interpolate(below, above, index - low, target, size)


@noinline_kernel
def interpolate_slot(matrices: StepMatrices, index: float, share: float) -> None:
    """Interpolate the slot of a point of the grid until a share (0 to 1) is complete; K and C are the first in it."""
    sizes, which, middle = matrices.sizes[0], slot_of(index), middle_of(index)
    slot, n, n_ports = matrices.slots[which], int(sizes.n), int(sizes.n_ports)
    if slot.index != index:
        slot.index, slot.n_rows = index, 0.0
    rows, size = n_rows(n, n_ports) * int(sizes.n_built), slot_size(n, n_ports)
    used = 2 * n * n + int(sizes.n_levels) * level_size(n, n_ports)
    first, end = int(slot.n_rows) * used // rows, int(share * rows) * used // rows
    if end <= first:
        return
    target = part(matrices.memory, which * size + first, REAL, end - first)
    below = part(matrices.memory, built_slot_of(middle - 1.0) * size + first, REAL, end - first)
    at = part(matrices.memory, built_slot_of(middle) * size + first, REAL, end - first)
    above = part(matrices.memory, built_slot_of(middle + 1.0) * size + first, REAL, end - first)
    t = index / STRIDE - middle
    of_below, of_middle, of_above = 0.5 * t * (t - 1.0), 1.0 - t * t, 0.5 * t * (t + 1.0)
    for i in range(end - first):
        target[i] = of_middle * at[i] + (of_below * below[i] + of_above * above[i])
    slot.n_rows = math.floor(share * rows)
