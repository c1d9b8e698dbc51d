"""Matrices of exact motion for a step, a half, a quarter and so on, at speeds on a grid.

Between events, the lateral motion of shaft and housings (N coordinates) is linear except for forces at a few of them:
the ports, that is, planes of sites and bearings, and housings. If these forces are cubic over a piece of length h,
through values F_j at its Lobatto points, matrices map the present state to the next,

    (q, v)(h) = x P,    (a(0), (q, v)(c_i h), i = 1..3) at the ports = x S,    x = (q, v, 1, 0, A, B, F_j)(0)

as in `exact_motion`; 1 multiplies the steady non-magnetic forces, 0 the same turned by a right angle, so that x
consists of pairs along x and y; A + i B is the direction of the unbalance. In addition to the ports, S observes
cosine . q and sine . q, which give the unbalance's work and its torque on a free spin. These rows and columns depend on
the present inputs: `matrix_inputs` combines them from those for unit inputs (`excitation`), which follow the n_x rows
of x. Level l is for a piece of h/2^l; `matrix_rows` builds the levels, starting from a piece so short that the series
converges fast. Levels shorter than h/2^(MAX_LEVELS - 1) are not stored.

P and S depend on the speed: slots of memory have them for speeds on a grid (`speed_grid`), and two for a constant
speed, with the gradients of the magnets (`constant_speed`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.flat import same_bits
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rotor_contact.excitation import first_unbalance
from rotor_contact.linear_solver import Equations, equations_of
from rotor_contact.lobatto import N_LOBATTO
from rotor_contact.passive_bearings import BEARING, Bearings, bearings_size
from rotor_contact.propagator import NODE, Nodes
from rotor_contact.structure import REAL

MAX_LEVELS = 6  # that are stored
MOST_LEVELS = 14  # that are built: with more, rounding would matter
MAX_COORDINATES = 128  # of a shaft; memory and time to build grow with their square and cube
N_NEAR = 3  # slots of the speeds of the grid around the present one, and of the next
N_BUILT = 4  # slots of speeds from which those are interpolated
N_SLOTS = N_NEAR + N_BUILT
N_CONSTANT = 2  # slots of a constant speed: the one in use, and the next
ALL_SLOTS = N_SLOTS + 1 + N_CONSTANT  # with that of the levels that are interpolated
N_COMBINED = ALL_SLOTS * MAX_LEVELS + N_CONSTANT
MAX_TERMS = 40  # of the series of a piece (`piece_series`)
PORT_COLUMNS = 4 * (N_LOBATTO - 1)  # of S: x and y of q and v at each Lobatto point after the first
PLANE_COLUMNS = 2 + PORT_COLUMNS  # of U: the initial acceleration before these

# Coordinates N of shaft and housings, ports (those of bearings alone come last, after `n_site_ports`), levels (those
# built, `n_built`, and those stored); length of a step (s), spacing of the speeds (rad/s), number of them from one that
# is built to the next, share of the spacing to which speeds are rounded; whether there are dampers. Of the matrices for
# speeds on the grid: terms of the series, and whether y responds as x does, turned by a right angle. Of the matrices in
# use: the place of a constant speed (`speed_grid`), else 0, and whether y responds as x does.
SIZES = record(
    ("n", np.float64),
    ("n_ports", np.float64),
    ("n_site_ports", np.float64),
    ("n_levels", np.float64),
    ("n_built", np.float64),
    ("step_size", np.float64),
    ("spacing", np.float64),
    ("stride", np.float64),
    ("quantum", np.float64),
    ("damped", np.float64),  # whether dampers other than seals dissipate energy
    ("n_terms", np.float64),
    ("grid_isotropic", np.float64),
    ("place", np.float64),
    ("isotropic", np.float64),
    ("n_rows", np.float64),  # of the matrices, those for unit inputs included
    ("inputs", np.float64),  # number of different amplitudes of the inputs so far
)
# What is stored for a speed: its number on the grid, how many rows of all levels are complete, the number of terms of
# the series of a shortest piece, and whether y responds as x does.
SLOT = record(("index", np.float64), ("n_rows", np.float64), ("n_terms", np.float64), ("isotropic", np.float64))
# What motion depends on, per site: 1/m, stiffness and damping in x and y.
SITE_KEY = record(
    ("mobility", np.float64),
    ("stiffness", np.float64, 2),
    ("damping", np.float64, 2),
    ("row", np.float64),
)
# Speed of a level, as a position on the grid, and the pieces that it was used for there.
BLEND = record(("index", np.float64), ("n_uses", np.float64))
N_SIZES, N_SLOT, N_SITE_KEY, N_BLEND = size_of(SIZES), size_of(SLOT), size_of(SITE_KEY), size_of(BLEND)
N_NODE = size_of(NODE)

Records = np.ndarray[tuple[int], np.dtype[np.record]]


class MatricesKey(NamedTuple):
    """Key of the matrices without the speed: all numbers, and named views into them.

    `step_size`, in an array of length 1, and records of types `BEARING`, without magnets and rows, and `SITE_KEY`.
    """

    values: Array
    step_size: Array
    bearings: Bearings
    sites: Records


class StepMatrices(NamedTuple):
    """The matrices in memory, with their key and the scratch of a piece.

    sizes, key
        Record of type `SIZES`, in an array of length 1; key of the matrices, empty if unknown.
    slots, blends
        Records of type `SLOT`, and of type `BLEND`, one for each stored level.
    ports
        Coordinate of x of each port; the ports of the sites, of their housings (-1: none) and of the bearings.
    memory
        Matrices of all slots and of the blends, see `level_of`.
    constant
        Constant speeds (rad/s) of their slots, each with the gradients (N/m) of the magnets there, in x and y of each
        bearing, shape (N_CONSTANT, 1 + 2 n_bearings).
    flights
        Matrices of free flight at these speeds, see `flight`.
    gradients
        Those in the matrices in use, shape (2 n_bearings,).
    amplitudes
        Those of the inputs (`excitation`), shape (2 n_pairs,).
    combined
        Number of the amplitudes (`SIZES.inputs`) for which each level of each slot is combined, then for which each
        flight was derived, shape (N_COMBINED,).
    damping
        Speed and state at which `piece_energy` last computed the power of damping, and its result, shape (2 n + 4,).
    pieces
        Scratch of a piece, see `piece`.
    nodes
        Records of type `NODE`, shape (n_sites, N_LOBATTO).
    equations
        Room for the equations of all Lobatto points after the first.
    """

    sizes: Records
    key: MatricesKey
    slots: Records
    blends: Records
    ports: Array
    memory: Array
    constant: Array
    flights: Array
    gradients: Array
    amplitudes: Array
    combined: Array
    damping: Array
    pieces: Array
    nodes: Nodes
    equations: Equations


class Level(NamedTuple):
    """Matrices of a level; the rows for unit inputs follow those of x.

    P, S
        Shapes (all_rows, 2 N) and (all_rows, n_columns).
    H
        See `matrix_dampers`, shape (all_rows, all_rows).
    U
        Observations as S, by the unit forces of each unbalance, shape (all_rows, PLANE_COLUMNS n_unbalances).
    """

    P: Array
    S: Array
    H: Array
    U: Array


class SlotCoefficients(NamedTuple):
    """The columns of K and of C, stacked, shape (2 N, N)."""

    columns: Array


class InnerMotion(NamedTuple):
    """P up to the first and the second inner Lobatto point, shape (all_rows, 2 N) each."""

    first: Array
    second: Array


@views
def n_rows(n: int, n_ports: int) -> int:
    """Return n_x, the size of x."""
    return 2 * n + 4 + 2 * N_LOBATTO * n_ports


@views
def all_rows(n: int, n_ports: int, inputs: int) -> int:
    """Return the number of rows, those for unit inputs included; `inputs` is the number of pairs of these."""
    return n_rows(n, n_ports) + 2 * inputs


@views
def n_columns(n_ports: int) -> int:
    """Return the number of columns of S: accelerations, then q and v at later Lobatto points (`place_index`).

    It is rounded up to a multiple of eight, which products process at once.
    """
    return ((1 + n_ports) * (2 + PORT_COLUMNS) + 7) // 8 * 8


@views
def place_index(n_ports: int, point: int, port: int) -> int:
    """Return the first column of S with displacements at a Lobatto point after the first.

    Those of the unbalance, which count as port -1, precede the first port.
    """
    return 2 * (1 + n_ports) + PORT_COLUMNS * (1 + port) + 4 * (point - 1)


@views
def velocity_index(n_ports: int, point: int, port: int) -> int:
    """Return the first column of S with velocities there."""
    return place_index(n_ports, point, port) + 2


@views
def level_size(n: int, n_ports: int, n_bearings: int, inputs: int) -> int:
    """Return the number of float64 in a level, an even number."""
    rows, unbalances = all_rows(n, n_ports, inputs), inputs - first_unbalance(inputs, n_bearings)
    return rows * (2 * n + n_columns(n_ports) + rows + PLANE_COLUMNS * unbalances)


@views
def slot_size(n: int, n_ports: int, n_bearings: int, inputs: int) -> int:
    """Return the number of float64 in a slot: K and C, levels, and the motion up to the inner Lobatto points, twice."""
    levels = MAX_LEVELS * level_size(n, n_ports, n_bearings, inputs)
    return 2 * n * n + levels + 4 * all_rows(n, n_ports, inputs) * 2 * n


@views
def place_of_slot(matrices: StepMatrices, slot: int) -> int:
    """Return where a slot begins in the memory."""
    sizes = matrices.sizes[0]
    n, n_ports, inputs = int(sizes.n), int(sizes.n_ports), matrices.amplitudes.shape[0] // 2
    return slot * slot_size(n, n_ports, matrices.gradients.shape[0] // 2, inputs)


@views
def level_of(matrices: StepMatrices, slot: int, level: int) -> Level:
    """Return the matrices of a level at the speed of a slot, which follow K and C in the memory.

    Levels beyond the stored ones alternate in the memory of the last two, which are built after them.
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
    """Return P up to the inner Lobatto points of a level; those of two levels at a time are stored."""
    n, rows = int(matrices.sizes[0].n), int(matrices.sizes[0].n_rows)
    at = place_of_slot(matrices, slot + 1) - (4 - 2 * (level % 2)) * rows * 2 * n
    return InnerMotion(
        part(matrices.memory, at, REAL, (rows, 2 * n)),
        part(matrices.memory, at + rows * 2 * n, REAL, (rows, 2 * n)),
    )


@views
def most_ports(n_bearings: int, n_sites: int) -> int:
    return n_bearings + 2 * n_sites


@views
def matrices_key_size(n_bearings: int, n_sites: int) -> int:
    """Return the number of float64 in a `MatricesKey`, an even number."""
    return 2 + bearings_size(n_bearings) + N_SITE_KEY * n_sites


@views
def matrices_key_of(array: Array, at: int, n_bearings: int, n_sites: int) -> MatricesKey:
    """Return a `MatricesKey` in an array, from `at`."""
    bearings = at + 2
    sites = bearings + bearings_size(n_bearings)
    return MatricesKey(
        part(array, at, REAL, matrices_key_size(n_bearings, n_sites)),
        part(array, at, REAL, 1),
        part(array, bearings, BEARING, n_bearings),
        part(array, sites, SITE_KEY, n_sites),
    )


@views
def series_size(n: int) -> int:
    """Return the number of float64 in the series of a piece."""
    return (MAX_TERMS + 2) * 2 * n


@views
def pieces_size(n: int, n_bearings: int, n_sites: int, inputs: int) -> int:
    """Return the largest number of float64 in the scratch of a piece, with which the matrices are built, too."""
    n_ports = most_ports(n_bearings, n_sites)
    n, rows, columns = n + 2 * n_sites, all_rows(n + 2 * n_sites, n_ports, inputs), n_columns(n_ports)
    return rows + 8 * n + 8 * columns + (2 * N_LOBATTO * n_ports) * (columns + 3) + (8 + n_sites) * N_LOBATTO


@views
def flight_rows(n: int, n_bearings: int) -> int:
    """Return the size of x in free flight (`flight`)."""
    return 2 * n + 4 + 2 * N_LOBATTO * n_bearings


@views
def flight_columns(n: int) -> int:
    """Return the size of its end."""
    return 2 * n + 2


@views
def flight_size(n: int, n_bearings: int) -> int:
    """Return the number of float64, even, of a flight at a constant speed."""
    rows, columns = flight_rows(n, n_bearings), flight_columns(n)
    return rows * columns + rows * rows + rows + columns


@views
def memory_size(n: int, n_bearings: int, n_sites: int, inputs: int) -> int:
    """Return the largest number of float64 in all slots; there are none for a shaft with too many coordinates."""
    n_ports = most_ports(n_bearings, n_sites)
    return ALL_SLOTS * slot_size(n + 2 * n_sites, n_ports, n_bearings, inputs) if n <= MAX_COORDINATES else 0


@views
def matrices_size(n: int, n_bearings: int, n_sites: int, inputs: int) -> int:
    """Return the number of float64 in a `StepMatrices`, an even number; `inputs` is the number of pairs of inputs."""
    n_ports, n_equations = most_ports(n_bearings, n_sites), 2 * (N_LOBATTO - 1) * n_sites
    size = N_SIZES + matrices_key_size(n_bearings, n_sites) + ALL_SLOTS * N_SLOT + MAX_LEVELS * N_BLEND
    size += 2 * (n_ports + n_bearings + 2 * n_sites) + 2 * pieces_size(n, n_bearings, n_sites, inputs)
    size += N_CONSTANT * (1 + 2 * n_bearings + flight_size(n + 2 * n_sites, n_bearings)) + 2 * n_bearings
    size += 2 * inputs + N_COMBINED + 2 * n + 4
    size += series_size(n + 2 * n_sites) + n_sites * N_LOBATTO * N_NODE + n_equations * (n_equations + 1)
    return size + memory_size(n, n_bearings, n_sites, inputs)


@views
def step_matrices_of(work: Array, at: int, n: int, n_bearings: int, n_sites: int, inputs: int) -> StepMatrices:
    """Return a `StepMatrices` in an array, from `at`."""
    n_ports, n_equations = most_ports(n_bearings, n_sites), 2 * (N_LOBATTO - 1) * n_sites
    n_pieces = 2 * pieces_size(n, n_bearings, n_sites, inputs) + series_size(n + 2 * n_sites)
    key = at + N_SIZES
    slots = key + matrices_key_size(n_bearings, n_sites)
    blends = slots + ALL_SLOTS * N_SLOT
    ports = blends + MAX_LEVELS * N_BLEND
    constant = ports + 2 * (n_ports + n_bearings + 2 * n_sites)
    flights, n_flight = constant + N_CONSTANT * (1 + 2 * n_bearings), flight_size(n + 2 * n_sites, n_bearings)
    gradients = flights + N_CONSTANT * n_flight
    amplitudes = gradients + 2 * n_bearings
    combined = amplitudes + 2 * inputs
    damping = combined + N_COMBINED
    pieces = damping + 2 * n + 4
    nodes = pieces + n_pieces
    equations = nodes + n_sites * N_LOBATTO * N_NODE
    memory = equations + n_equations * (n_equations + 1)
    return StepMatrices(
        part(work, at, SIZES, 1),
        matrices_key_of(work, key, n_bearings, n_sites),
        part(work, slots, SLOT, ALL_SLOTS),
        part(work, blends, BLEND, MAX_LEVELS),
        part(work, ports, REAL, 2 * n_ports),
        part(work, memory, REAL, memory_size(n, n_bearings, n_sites, inputs)),
        part(work, constant, REAL, (N_CONSTANT, 1 + 2 * n_bearings)),
        part(work, flights, REAL, (N_CONSTANT, n_flight)),
        part(work, gradients, REAL, 2 * n_bearings),
        part(work, amplitudes, REAL, 2 * inputs),
        part(work, combined, REAL, N_COMBINED),
        part(work, damping, REAL, 2 * n + 4),
        part(work, pieces, REAL, n_pieces),
        part(work, nodes, NODE, (n_sites, N_LOBATTO)),
        equations_of(work, equations, n_equations),
    )


@kernel
def forget_combined(matrices: StepMatrices, slot: int) -> None:
    """Note that no level of a slot is combined."""
    for level in range(MAX_LEVELS):
        matrices.combined[slot * MAX_LEVELS + level] = 0.0


@kernel
def is_for(matrices: StepMatrices, key: MatricesKey) -> bool:
    """Return whether the matrices are for this key."""
    return same_bits(matrices.key.values, key.values)
