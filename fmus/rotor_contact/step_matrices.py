"""Matrices of exact motion for a step, a half, a quarter and so on, at speeds on a grid.

Between events, the lateral motion of shaft and housings (N coordinates) is linear except for forces at a few of them:
the ports, that is, planes of sites and bearings, and housings. If these forces are cubic over a piece of length h,
through values F_j at its Lobatto points, matrices map the present state to the next,

    (q, v)(h) = x P,    (a(0), (q, v)(c_i h), i = 1..3) at the ports = x S,    x = (q, v, 1, 0, A, B, F_j)(0)

as in `exact_motion`; 1 multiplies the steady non-magnetic forces, 0 the same turned by a right angle, so that x
consists of pairs along x and y; A + i B is the direction of the unbalance. In addition to the ports, S observes
cosine . q and sine . q, which give the unbalance's work and its torque on a free spin. Level l is for a piece of h/2^l;
`matrix_rows` builds the levels, starting from a piece so short that the series converges fast. Levels shorter than
h/2^(MAX_LEVELS - 1) are not stored.

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
MAX_TERMS = 40  # of the series of a piece (`piece_series`)
PORT_COLUMNS = 4 * (N_LOBATTO - 1)  # of S: x and y of q and v at each Lobatto point after the first

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
)
# What is stored for a speed: its number on the grid, how many rows of all levels are complete, the number of terms of
# the series of a shortest piece, and whether y responds as x does.
SLOT = record(("index", np.float64), ("n_rows", np.float64), ("n_terms", np.float64), ("isotropic", np.float64))
# What motion depends on, per site: 1/m, stiffness and damping in x and y, base acceleration.
SITE_KEY = record(
    ("mobility", np.float64),
    ("stiffness", np.float64, 2),
    ("damping", np.float64, 2),
    ("base_acceleration", np.float64, 2),
    ("row", np.float64),
)
# Speed of a level, as a position on the grid, and the pieces that it was used for there.
BLEND = record(("index", np.float64), ("n_uses", np.float64))
N_SIZES, N_SLOT, N_SITE_KEY, N_BLEND = size_of(SIZES), size_of(SLOT), size_of(SITE_KEY), size_of(BLEND)
N_NODE = size_of(NODE)

Records = np.ndarray[tuple[int], np.dtype[np.record]]


class MatricesKey(NamedTuple):
    """Key of the matrices without the speed: all numbers, and named views into them.

    `step_size`, in an array of length 1, records of types `BEARING`, without magnets and rows, and `SITE_KEY`, and the
    forces (N) multiplied by 1, A and B, shape (3, n).
    """

    values: Array
    step_size: Array
    bearings: Bearings
    sites: Records
    forces: Array


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
    effects
        Accelerations due to the forces multiplied by A, B and 1, shape (3, n).
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
    effects: Array
    damping: Array
    pieces: Array
    nodes: Nodes
    equations: Equations


class Level(NamedTuple):
    """P, shape (n_x, 2 N), S, shape (n_x, n_columns), and H (`matrix_dampers`), shape (n_x, n_x)."""

    P: Array
    S: Array
    H: Array


class SlotCoefficients(NamedTuple):
    """The columns of K and of C, stacked, shape (2 N, N)."""

    columns: Array


class InnerMotion(NamedTuple):
    """P up to the first and the second inner Lobatto point, shape (n_x, 2 N) each."""

    first: Array
    second: Array


@views
def n_rows(n: int, n_ports: int) -> int:
    """Return n_x, the size of x."""
    return 2 * n + 4 + 2 * N_LOBATTO * n_ports


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
def level_size(n: int, n_ports: int) -> int:
    """Return the number of float64 in a level, an even number."""
    return n_rows(n, n_ports) * (2 * n + n_columns(n_ports) + n_rows(n, n_ports))


@views
def slot_size(n: int, n_ports: int) -> int:
    """Return the number of float64 in a slot: K and C, levels, and the motion up to the inner Lobatto points, twice."""
    return 2 * n * n + MAX_LEVELS * level_size(n, n_ports) + 4 * n_rows(n, n_ports) * 2 * n


@views
def level_of(matrices: StepMatrices, slot: int, level: int) -> Level:
    """Return the matrices of a level at the speed of a slot.

    Levels beyond the stored ones alternate in the memory of the last two, which are built after them.
    """
    sizes = matrices.sizes[0]
    n, n_ports = int(sizes.n), int(sizes.n_ports)
    rows = n_rows(n, n_ports)
    place = level if level < MAX_LEVELS else MAX_LEVELS - 2 + level % 2
    at = slot * slot_size(n, n_ports) + 2 * n * n + place * level_size(n, n_ports)
    return Level(
        part(matrices.memory, at, REAL, (rows, 2 * n)),
        part(matrices.memory, at + rows * 2 * n, REAL, (rows, n_columns(n_ports))),
        part(matrices.memory, at + rows * (2 * n + n_columns(n_ports)), REAL, (rows, rows)),
    )


@views
def coefficients_at(matrices: StepMatrices, slot: int) -> SlotCoefficients:
    """Return K and C at the speed of a slot."""
    n = int(matrices.sizes[0].n)
    return SlotCoefficients(
        part(matrices.memory, slot * slot_size(n, int(matrices.sizes[0].n_ports)), REAL, (2 * n, n)),
    )


@views
def inner_motion(matrices: StepMatrices, slot: int, level: int) -> InnerMotion:
    """Return P up to the inner Lobatto points of a level; those of two levels at a time are stored."""
    n, n_ports = int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports)
    rows = n_rows(n, n_ports)
    at = slot * slot_size(n, n_ports) + 2 * n * n + MAX_LEVELS * level_size(n, n_ports) + 2 * (level % 2) * rows * 2 * n
    return InnerMotion(
        part(matrices.memory, at, REAL, (rows, 2 * n)),
        part(matrices.memory, at + rows * 2 * n, REAL, (rows, 2 * n)),
    )


@views
def most_ports(n_bearings: int, n_sites: int) -> int:
    return n_bearings + 2 * n_sites


@views
def matrices_key_size(n: int, n_bearings: int, n_sites: int) -> int:
    """Return the number of float64 in a `MatricesKey`, an even number."""
    return 2 + bearings_size(n_bearings) + N_SITE_KEY * n_sites + 4 * n


@views
def matrices_key_of(array: Array, at: int, n: int, n_bearings: int, n_sites: int) -> MatricesKey:
    """Return a `MatricesKey` in an array, from `at`."""
    bearings = at + 2
    sites = bearings + bearings_size(n_bearings)
    return MatricesKey(
        part(array, at, REAL, matrices_key_size(n, n_bearings, n_sites)),
        part(array, at, REAL, 1),
        part(array, bearings, BEARING, n_bearings),
        part(array, sites, SITE_KEY, n_sites),
        part(array, sites + N_SITE_KEY * n_sites, REAL, (3, n)),
    )


@views
def series_size(n: int) -> int:
    """Return the number of float64 in the series of a piece."""
    return (MAX_TERMS + 2) * 2 * n


@views
def pieces_size(n: int, n_bearings: int, n_sites: int) -> int:
    """Return the largest number of float64 in the scratch of a piece."""
    n_ports = most_ports(n_bearings, n_sites)
    n, rows, columns = n + 2 * n_sites, n_rows(n + 2 * n_sites, n_ports), n_columns(n_ports)
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
def matrices_size(n: int, n_bearings: int, n_sites: int) -> int:
    """Return the number of float64 in a `StepMatrices`, an even number."""
    n_ports, n_equations = most_ports(n_bearings, n_sites), 2 * (N_LOBATTO - 1) * n_sites
    size = N_SIZES + matrices_key_size(n, n_bearings, n_sites) + ALL_SLOTS * N_SLOT + MAX_LEVELS * N_BLEND
    size += 2 * (n_ports + n_bearings + 2 * n_sites) + 2 * pieces_size(n, n_bearings, n_sites)
    size += N_CONSTANT * (1 + 2 * n_bearings + flight_size(n + 2 * n_sites, n_bearings)) + 2 * n_bearings
    size += series_size(n + 2 * n_sites) + 6 * n + 4 + n_sites * N_LOBATTO * N_NODE + n_equations * (n_equations + 1)
    return size + (ALL_SLOTS * slot_size(n + 2 * n_sites, n_ports) if n <= MAX_COORDINATES else 0)


@views
def step_matrices_of(work: Array, at: int, n: int, n_bearings: int, n_sites: int) -> StepMatrices:
    """Return a `StepMatrices` in an array, from `at`."""
    n_ports, n_equations = most_ports(n_bearings, n_sites), 2 * (N_LOBATTO - 1) * n_sites
    n_pieces = 2 * pieces_size(n, n_bearings, n_sites) + series_size(n + 2 * n_sites)
    key = at + N_SIZES
    slots = key + matrices_key_size(n, n_bearings, n_sites)
    blends = slots + ALL_SLOTS * N_SLOT
    ports = blends + MAX_LEVELS * N_BLEND
    constant = ports + 2 * (n_ports + n_bearings + 2 * n_sites)
    flights, n_flight = constant + N_CONSTANT * (1 + 2 * n_bearings), flight_size(n + 2 * n_sites, n_bearings)
    gradients = flights + N_CONSTANT * n_flight
    effects = gradients + 2 * n_bearings
    damping = effects + 4 * n
    pieces = damping + 2 * n + 4
    nodes = pieces + n_pieces
    equations = nodes + n_sites * N_LOBATTO * N_NODE
    memory = equations + n_equations * (n_equations + 1)
    return StepMatrices(
        part(work, at, SIZES, 1),
        matrices_key_of(work, key, n, n_bearings, n_sites),
        part(work, slots, SLOT, ALL_SLOTS),
        part(work, blends, BLEND, MAX_LEVELS),
        part(work, ports, REAL, 2 * n_ports),
        part(work, memory, REAL, ALL_SLOTS * slot_size(n + 2 * n_sites, n_ports) if n <= MAX_COORDINATES else 0),
        part(work, constant, REAL, (N_CONSTANT, 1 + 2 * n_bearings)),
        part(work, flights, REAL, (N_CONSTANT, n_flight)),
        part(work, gradients, REAL, 2 * n_bearings),
        part(work, effects, REAL, (3, n)),
        part(work, damping, REAL, 2 * n + 4),
        part(work, pieces, REAL, n_pieces),
        part(work, nodes, NODE, (n_sites, N_LOBATTO)),
        equations_of(work, equations, n_equations),
    )


@kernel
def is_for(matrices: StepMatrices, key: MatricesKey) -> bool:
    """Return whether the matrices are for this key."""
    return same_bits(matrices.key.values, key.values)
