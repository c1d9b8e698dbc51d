"""Matrices of exact motion for a step, half a step, a quarter and so on, at speeds on a grid.

Between events, the lateral motion of the shaft and the housings (N coordinates) is linear except for forces at a few
places, called ports. The ports are the planes of sites and bearings, the housings, and the place and the slope of each
face. If these forces are cubics over a piece of length h, through the values F_j at its Lobatto points, matrices map
the present state to the next one,

    (q, v)(h) = x P,    (a(0), (q, v)(c_i h), i = 1..3) at the ports = x S,    x = (q, v, 1, 0, A, B, F_j)(0)

where 1 multiplies the steady non-magnetic forces, and 0 multiplies the same forces turned by a right angle, so that x
consists of pairs along x and y. The direction of the unbalance is A + i B. In addition to the motion at the ports, S
yields cosine . q and sine . q, from which the unbalance's work and its torque on a free spin follow. The columns for
these two, and the rows for 1, 0, A and B, depend on the present inputs. `matrix_inputs` combines them from the rows for
unit inputs (`excitation`), which follow the n_x rows of x. Level l is for a piece of length h/2^l; `matrix_rows` builds
the levels, starting from a piece so short that the series converges fast. Levels for pieces shorter than
h/2^(MAX_LEVELS - 1) are not stored.

Because P and S depend on the speed, slots of memory hold them for speeds on a grid (`speed_grid`). Two more slots hold
them for a constant speed, with the gradients of the magnets (`constant_speed`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.flat import same_bits
from fmi_export.jit import inlined_kernel, kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.forces.excitation import first_unbalance
from rotor_contact.forces.passive_bearings import BEARING, Bearings, bearings_size
from rotor_contact.matrices.matrix_sizes import (
    ALL_SLOTS,
    BLEND,
    MAX_LEVELS,
    N_COMBINED,
    N_CONSTANT,
    N_SITE_KEY,
    N_SIZES,
    NODE,
    PLANE_COLUMNS,
    SIZES,
    SLOT,
    level_size,
    matrices_key_size,
    most_equations,
    n_columns,
    n_rows,
    places_of_matrices,
    slot_size,
)
from rotor_contact.shaft.linear_solver import Equations, equations_of
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.structure import REAL, Structure

Records = np.ndarray[tuple[int], np.dtype[np.record]]
Nodes = np.ndarray[tuple[int, int], np.dtype[np.record]]


class MatricesKey(NamedTuple):
    """Key of the matrices without the speed: all numbers, and views into them."""

    values: Array
    step_size: Array  # in an array of length 1
    bearings: Bearings  # without magnets and rows
    sites: Array  # what the motion depends on, of each site, shape (n_sites, N_SITE_KEY)


class StepMatrices(NamedTuple):
    """The matrices in memory, with their key and the scratch of a piece."""

    sizes: Records  # of type `SIZES`, in an array of length 1
    key: MatricesKey
    slots: Records  # of type `SLOT`
    blends: Records  # of type `BLEND`, one for each stored level
    # For each port, the coordinate of its x, or a negative number for a face (`row_of_face`); then the ports of the
    # sites, of their housings (-1 if there is none), of the bearings, and of the place and slope of each face.
    ports: Array
    memory: Array  # matrices of all slots and of the blends (see `level_of`)
    # The constant speed (rad/s) of each slot for constant speeds, followed by the gradients (N/m) of the magnets in x
    # and y of each bearing, shape (N_CONSTANT, 1 + 2 n_bearings).
    constant: Array
    whole_steps: Array  # matrices of a whole step at these speeds (see `whole_step`)
    powers: Array  # power forms of spin and seals of all slots (see `matrix_powers`), or none
    gradients: Array  # of the magnets (N/m) in the matrices in use, shape (2 n_bearings,)
    amplitudes: Array  # of the inputs (`excitation`), shape (2 n_pairs,)
    # Number of the amplitudes (`SIZES.inputs`) for which each level of each slot is combined, followed by the number
    # for which the matrices of each whole step were derived, shape (N_COMBINED,).
    combined: Array
    pieces: Array  # scratch of a piece (see `piece`)
    nodes: Nodes  # of type `NODE`, shape (n_sites, N_LOBATTO)
    equations: Equations  # at all Lobatto points after the first, for all sites or for one face


class Level(NamedTuple):
    """Matrices of a level; the rows for unit inputs follow the rows of x."""

    P: Array  # shape (all_rows, 2 N)
    S: Array  # shape (all_rows, n_columns)
    H: Array  # see `matrix_dampers`, shape (all_rows, all_rows)
    U: Array  # products of the motion with the unit forces of each unbalance, (all_rows, PLANE_COLUMNS n_unbalances)


class Powers(NamedTuple):
    """Forms of the impulse on the spin and of the work of seals in a piece, shape (all_rows, all_rows) each.

    If there are no seals, `seals` is not used.
    """

    spin: Array
    seals: Array


class SlotCoefficients(NamedTuple):
    """The columns of K and of C, stacked, shape (2 N, N)."""

    columns: Array


class InnerMotion(NamedTuple):
    """P up to the first and the second inner Lobatto point, shape (all_rows, 2 N) each."""

    first: Array
    second: Array


@views
def place_of_slot(matrices: StepMatrices, slot: int) -> int:
    """Return the position in the memory at which a slot begins."""
    sizes = matrices.sizes[0]
    n, n_ports, inputs = int(sizes.n), int(sizes.n_ports), matrices.amplitudes.shape[0] // 2
    return slot * slot_size(n, n_ports, matrices.gradients.shape[0] // 2, inputs)


@views
def level_of(matrices: StepMatrices, slot: int, level: int) -> Level:
    """Return the matrices of a level at the speed of a slot, which follow K and C in the memory.

    Levels that are not stored alternate in the memory of the last two stored levels, which are built after them.
    """
    n, n_ports, rows = int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports), int(matrices.sizes[0].n_rows)
    inputs, n_bearings = matrices.amplitudes.shape[0] // 2, matrices.gradients.shape[0] // 2
    place = level if level < MAX_LEVELS else MAX_LEVELS - 2 + level % 2
    P = place_of_slot(matrices, slot) + 2 * n * n + place * level_size(n, n_ports, n_bearings, inputs)
    S = P + rows * 2 * n
    H = S + rows * n_columns(n_ports)
    return Level(
        part(matrices.memory, P, REAL, (rows, 2 * n)),
        part(matrices.memory, S, REAL, (rows, n_columns(n_ports))),
        part(matrices.memory, H, REAL, (rows, rows)),
        part(matrices.memory, H + rows * rows, REAL, (rows, PLANE_COLUMNS * (inputs - unbalances_of(matrices)))),
    )


@views
def powers_of(matrices: StepMatrices, slot: int, level: int) -> Powers:
    """Return the quadratic forms of spin and seals for pieces of a level."""
    rows, place = int(matrices.sizes[0].n_rows), level if level < MAX_LEVELS else MAX_LEVELS - 2 + level % 2
    forms = int(matrices.sizes[0].powered)
    at = forms * (slot * MAX_LEVELS + place) * rows * rows
    return Powers(
        part(matrices.powers, at, REAL, (rows, rows)),
        part(matrices.powers, at + (forms - 1) * rows * rows, REAL, (rows, rows)),
    )


@views
def rows_of_x(matrices: StepMatrices) -> int:
    """Return n_x; the rows for unit inputs follow."""
    return n_rows(int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports))


@views
def unbalances_of(matrices: StepMatrices) -> int:
    """Return the first pair of inputs that is an unbalance."""
    return first_unbalance(matrices.amplitudes.shape[0] // 2, matrices.gradients.shape[0] // 2)


@views
def coefficients_at(matrices: StepMatrices, slot: int) -> SlotCoefficients:
    """Return K and C at the speed of a slot."""
    n = int(matrices.sizes[0].n)
    return SlotCoefficients(part(matrices.memory, place_of_slot(matrices, slot), REAL, (2 * n, n)))


@views
def inner_motion(matrices: StepMatrices, slot: int, level: int) -> InnerMotion:
    """Return P up to the inner Lobatto points of a level; only two levels at a time are stored."""
    n, rows = int(matrices.sizes[0].n), int(matrices.sizes[0].n_rows)
    at = place_of_slot(matrices, slot + 1) - (4 - 2 * (level % 2)) * rows * 2 * n
    return InnerMotion(
        part(matrices.memory, at, REAL, (rows, 2 * n)),
        part(matrices.memory, at + rows * 2 * n, REAL, (rows, 2 * n)),
    )


@views
def matrices_key_of(array: Array, at: int, n_bearings: int, n_sites: int) -> MatricesKey:
    """Return a `MatricesKey` as views into an array, from position `at`."""
    bearings = at + 2
    sites = bearings + bearings_size(n_bearings)
    return MatricesKey(
        part(array, at, REAL, matrices_key_size(n_bearings, n_sites)),
        part(array, at, REAL, 1),
        part(array, bearings, BEARING, n_bearings),
        part(array, sites, REAL, (n_sites, N_SITE_KEY)),
    )


@views
def step_matrices_of(work: Array, at: int, structure: Structure) -> StepMatrices:
    """Return a `StepMatrices` as views into an array, from position `at`."""
    n_bearings, n_sites, places = structure.bearings.shape[0], structure.sites.shape[0], places_of_matrices(structure)
    slots, blends, ports, constant, whole_steps, powers, gradients, amplitudes, combined = places[:9]
    pieces, nodes, equations, memory, end = places[9:]
    return StepMatrices(
        part(work, at, SIZES, 1),
        matrices_key_of(work, at + N_SIZES, n_bearings, n_sites),
        part(work, at + slots, SLOT, ALL_SLOTS),
        part(work, at + blends, BLEND, MAX_LEVELS),
        part(work, at + ports, REAL, constant - ports),
        part(work, at + memory, REAL, end - memory),
        part(work, at + constant, REAL, (N_CONSTANT, 1 + 2 * n_bearings)),
        part(work, at + whole_steps, REAL, (N_CONSTANT, (powers - whole_steps) // N_CONSTANT)),
        part(work, at + powers, REAL, gradients - powers),
        part(work, at + gradients, REAL, 2 * n_bearings),
        part(work, at + amplitudes, REAL, combined - amplitudes),
        part(work, at + combined, REAL, N_COMBINED),
        part(work, at + pieces, REAL, nodes - pieces),
        part(work, at + nodes, NODE, (n_sites, N_LOBATTO)),
        equations_of(work, at + equations, most_equations(structure)),
    )


@kernel
def forget_combined(matrices: StepMatrices, slot: int) -> None:
    """Record that no level of a slot is combined."""
    for level in range(MAX_LEVELS):
        matrices.combined[slot * MAX_LEVELS + level] = 0.0


@inlined_kernel
def is_for(matrices: StepMatrices, key: MatricesKey) -> bool:
    """Return whether the matrices are for this key."""
    return same_bits(matrices.key.values, key.values)
