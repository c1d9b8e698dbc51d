"""Sizes of the matrices of a step and of their parts in memory (`step_matrices`), as numbers of float64 values."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import views
from fmi_export.records import record, size_of
from rotor_contact.forces.excitation import first_unbalance, n_pairs
from rotor_contact.forces.passive_bearings import bearings_size
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.structure import Structure

MAX_LEVELS = 6  # that are stored
MOST_LEVELS = 14  # that are built: with more, rounding would matter
MAX_COORDINATES = 128  # of a shaft; memory and time to build grow with their square and cube
N_NEAR = 3  # slots of the speeds of the grid around the present one, and of the next
N_BUILT = 4  # slots of speeds from which those are interpolated
N_SLOTS = N_NEAR + N_BUILT
N_CONSTANT = 2  # slots of a constant speed: the one in use, and the next
FIRST_CONSTANT = N_SLOTS + 1  # after that of the levels that are interpolated
ALL_SLOTS = FIRST_CONSTANT + N_CONSTANT
N_COMBINED = ALL_SLOTS * MAX_LEVELS + N_CONSTANT
N_SITE_KEY = 6  # what the motion depends on, of each site (`matrix_schedule`)
MAX_TERMS = 40  # of the series of a piece (`piece_series`)
PORT_COLUMNS = 4 * (N_LOBATTO - 1)  # of S: x and y of q and v at each Lobatto point after the first
PLANE_COLUMNS = 2 + PORT_COLUMNS  # of U: the initial acceleration before these

SIZES = record(
    ("n", np.float64),  # coordinates N of shaft and housings
    ("n_ports", np.float64),
    ("n_site_ports", np.float64),  # the first ones; the last ones are those of bearings alone
    ("n_levels", np.float64),  # that are stored
    ("n_built", np.float64),  # that are built
    ("step_size", np.float64),  # s
    ("spacing", np.float64),  # of the speeds on the grid (rad/s)
    ("stride", np.float64),  # number of them from one that is built to the next
    ("quantum", np.float64),  # share of the spacing to which speeds are rounded
    ("damped", np.float64),  # whether dampers or seals dissipate energy
    ("powered", np.float64),  # whether the spin or seals do work: 0, 1 (spin) or 2 (with seals)
    ("reach", np.float64),  # length of a step times the highest rate of change, for speeds on the grid
    ("grid_isotropic", np.float64),  # whether y responds as x does, turned by a right angle, for speeds on the grid
    ("place", np.float64),  # of a constant speed in use (`speed_grid`), else 0
    ("isotropic", np.float64),  # whether y responds as x does with the matrices in use
    ("n_rows", np.float64),  # of the matrices, those for unit inputs included
    ("inputs", np.float64),  # number of different amplitudes of the inputs so far
)
# What is stored for a speed: its number on the grid, how many rows of all levels are complete, the reach of a step, and
# whether y responds as x does.
SLOT = record(("index", np.float64), ("n_rows", np.float64), ("reach", np.float64), ("isotropic", np.float64))
# Observations of a journal for the equations of its contact: the acceleration without contact at the start (m/s^2),
# position and velocity at the Lobatto points after that, and the acceleration without contact at the end.
JOURNAL = record(("x", np.float64), ("y", np.float64), ("v_x", np.float64), ("v_y", np.float64))
OBSERVED = record(("a_start", np.float64, 2), ("journal", JOURNAL, N_LOBATTO - 1), ("a_end", np.float64, 2))
NODE = record(  # a site at a Lobatto point
    ("n_x", np.float64),  # normal
    ("n_y", np.float64),
    ("slip", np.float64),  # m/s
    ("ratio", np.float64),  # T/N of sliding
    ("f_n", np.float64),  # N
    ("f_t", np.float64),
)
# Speed of a level, as a position on the grid, and the pieces that it was used for there.
BLEND = record(("index", np.float64), ("n_uses", np.float64))
N_SIZES = size_of(SIZES) + size_of(SIZES) % 2  # even, as all places of parts
N_SLOT, N_BLEND = size_of(SLOT), size_of(BLEND)
N_OBSERVED, N_NODE = size_of(OBSERVED), size_of(NODE)


@views
def n_rows(n: int, n_ports: int) -> int:
    """Return n_x, the size of x."""
    return 2 * n + 4 + 2 * N_LOBATTO * n_ports


@views
def all_rows(n: int, n_ports: int, inputs: int) -> int:
    """Return the number of rows, including those for unit inputs; `inputs` is the number of pairs of inputs."""
    return n_rows(n, n_ports) + 2 * inputs


@views
def n_columns(n_ports: int) -> int:
    """Return the number of columns of S: accelerations, then q and v at later Lobatto points (`place_index`).

    The number is rounded up to a multiple of eight, because products process eight columns at once.
    """
    return ((1 + n_ports) * (2 + PORT_COLUMNS) + 7) // 8 * 8


@views
def place_index(n_ports: int, point: int, port: int) -> int:
    """Return the first column of S with a port's displacements at a Lobatto point after the first.

    The columns of the unbalance, which count as port -1, precede those of the first port.
    """
    return 2 * (1 + n_ports) + PORT_COLUMNS * (1 + port) + 4 * (point - 1)


@views
def velocity_index(n_ports: int, point: int, port: int) -> int:
    """Return the first column of S with a port's velocities at a Lobatto point after the first."""
    return place_index(n_ports, point, port) + 2


@views
def level_size(n: int, n_ports: int, n_bearings: int, inputs: int) -> int:
    """Return how many float64 values a level occupies; the number is even."""
    rows, unbalances = all_rows(n, n_ports, inputs), inputs - first_unbalance(inputs, n_bearings)
    return rows * (2 * n + n_columns(n_ports) + rows + PLANE_COLUMNS * unbalances)


@views
def slot_size(n: int, n_ports: int, n_bearings: int, inputs: int) -> int:
    """Return how many float64 values a slot occupies: K, C, levels, and P to the inner Lobatto points of two levels."""
    levels = MAX_LEVELS * level_size(n, n_ports, n_bearings, inputs)
    return 2 * n * n + levels + 4 * all_rows(n, n_ports, inputs) * 2 * n


@views
def most_equations(s: Structure) -> int:
    """Return the largest number of unknown forces in a piece: those of all sites, or those of one face."""
    of_face = 4 * (N_LOBATTO - 1) if s.n_faces > 0 else 0
    return max(2 * (N_LOBATTO - 1) * s.sites.shape[0], of_face)


@views
def matrices_key_size(n_bearings: int, n_sites: int) -> int:
    """Return how many float64 values a `MatricesKey` occupies; the number is even."""
    return 2 + bearings_size(n_bearings) + N_SITE_KEY * n_sites


@views
def series_size(n: int) -> int:
    """Return how many float64 values the series of a piece occupies."""
    return (MAX_TERMS + 2) * 2 * n


@views
def whole_rows(n: int, n_bearings: int, n_sites: int) -> int:
    """Return the size of x in a whole step (`whole_step`)."""
    return 2 * n + 4 + 2 * N_LOBATTO * (n_bearings + n_sites)


@views
def whole_columns(n: int) -> int:
    """Return the size of the result at the end of a whole step."""
    return 2 * n + 2


@views
def places_of_matrices(s: Structure) -> tuple[int, ...]:
    """Return the positions of the parts of a `StepMatrices` after its sizes, in their order, and its total size.

    All numbers are even. A shaft with too many coordinates has no slots. Power forms exist
    only if there is shaft damping or a seal. The scratch of pieces also serves to build the matrices.
    """
    m, n_bearings, n_sites, inputs = s.K.shape[0], s.bearings.shape[0], s.sites.shape[0], n_pairs(s)
    n, n_ports = m + 2 * n_sites, n_bearings + 2 * (n_sites + s.n_faces)  # at most
    rows, columns, n_equations = all_rows(n, n_ports, inputs), n_columns(n_ports), most_equations(s)
    whole, has_slots = whole_rows(n, n_bearings, n_sites), m <= MAX_COORDINATES
    slots = N_SIZES + matrices_key_size(n_bearings, n_sites)
    blends = slots + ALL_SLOTS * N_SLOT
    ports = blends + MAX_LEVELS * N_BLEND
    constant = ports + 2 * n_ports
    whole_steps = constant + N_CONSTANT * (1 + 2 * n_bearings)
    of_whole = (whole + 1) * whole_columns(n) + 2 * whole * whole + whole + (whole + 2) * n_sites * N_OBSERVED
    powers = whole_steps + N_CONSTANT * of_whole
    forms = 2 if s.seals.records.shape[1] > 0 else 1
    gradients = powers + (forms * ALL_SLOTS * MAX_LEVELS * rows * rows if s.is_damped and has_slots else 0)
    amplitudes = gradients + 2 * n_bearings
    combined = amplitudes + 2 * inputs
    pieces = combined + N_COMBINED
    of_ports = 8 * columns + 2 * N_LOBATTO * n_ports * (columns + 3)
    of_piece = rows + 8 * n + of_ports + (8 + n_sites) * N_LOBATTO
    nodes = pieces + 2 * of_piece + series_size(n)
    equations = nodes + n_sites * N_LOBATTO * N_NODE
    memory = equations + n_equations * (n_equations + 1)
    end = memory + (ALL_SLOTS * slot_size(n, n_ports, n_bearings, inputs) if has_slots else 0)
    return (
        *(slots, blends, ports, constant, whole_steps, powers, gradients, amplitudes, combined),
        *(pieces, nodes, equations, memory, end),
    )
