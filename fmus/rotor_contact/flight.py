"""A whole step of free flight at a constant speed: one product with matrices that are derived from those of the step.

    (q, v, w_A, w_B)(h) = x F,    x = (q, v, 1, 0, A, B, f, d_1, d_2, d_3)(0),    D = x . H x

f are the forces of the magnets with the gradients in the matrices (`constant_speed`), held over the step, and d_j their
changes at the later Lobatto points because the present gradients differ from those:

    d_j = (g - g_0) (q(c_j h) - q(0)),    q(c_j h) by the cubic through q and q' at both ends

A w_A + B w_B is the work of the unbalance (`piece_energy`), D the energy that dampers take (`matrix_dampers`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.dynamics import Motion, forces, unbalance_direction
from rotor_contact.enumerations import FREE
from rotor_contact.lobatto import LOBATTO_POINTS, LOBATTO_WEIGHTS, N_LOBATTO
from rotor_contact.matrix_inputs import combine, flight_is_current, note_flight
from rotor_contact.matrix_sizes import flight_columns, flight_rows, place_index
from rotor_contact.node_forces import gradient_change, magnet_force, port_of_bearing
from rotor_contact.path import journal_of, keeps_distance
from rotor_contact.piece import advance_rotations, start_rotations
from rotor_contact.products import add_combination, row_combination, triangular_form
from rotor_contact.site import can_touch
from rotor_contact.speed_grid import CONSTANT, FIRST_CONSTANT, grid_speed
from rotor_contact.step_matrices import Level, StepMatrices, level_of
from rotor_contact.structure import REAL
from rotor_contact.workspace import Workspace, stages_of

MARGIN = 0.02  # of the clearance, within which a piece observes the path at Lobatto points
SETTLED = 1e-6  # of the largest force: how far a force at the end may be from that at the end of the cubic
# The cubic at the later Lobatto points: shares of the rise, of h v(0) and of h v(h).
OF_RISE = tuple(s * s * (3.0 - 2.0 * s) for s in LOBATTO_POINTS[1:])
OF_START = tuple(s * (1.0 - s) * (1.0 - s) for s in LOBATTO_POINTS[1:])
OF_END = tuple(-s * s * (1.0 - s) for s in LOBATTO_POINTS[1:])


class Flight(NamedTuple):
    """F, shape (rows, 2 N + 2), H, shape (rows, rows), and room for x and its end."""

    F: Array
    H: Array
    x: Array
    end: Array


@views
def flight_of(matrices: StepMatrices, which: int) -> Flight:
    """Return the flight at a constant speed; `which` is the number of its slot."""
    n, n_bearings, memory = int(matrices.sizes[0].n), matrices.gradients.shape[0] // 2, matrices.flights[which]
    rows, columns = flight_rows(n, n_bearings), flight_columns(n)
    H = rows * columns
    x = H + rows * rows
    return Flight(
        part(memory, 0, REAL, (rows, columns)),
        part(memory, H, REAL, (rows, rows)),
        part(memory, x, REAL, rows),
        part(memory, x + rows, REAL, columns),
    )


@noinline_kernel
def build_flight(motion: Motion, matrices: StepMatrices, which: int) -> None:
    """Derive F and H from the matrices of a whole step at a constant speed, which are complete, for present inputs."""
    combine(matrices, FIRST_CONSTANT + which, 0)
    note_flight(matrices, which)
    flight, level = flight_of(matrices, which), level_of(matrices, FIRST_CONSTANT + which, 0)
    F, H, n, is_damped = flight.F, flight.H, int(matrices.sizes[0].n), matrices.sizes[0].damped != 0.0
    turn = grid_speed(matrices, CONSTANT + which) * matrices.sizes[0].step_size
    F[:, :] = 0.0
    H[:, :] = 0.0
    for row in range(F.shape[0]):
        for i in range(_count(matrices, row)):
            u = _row_of(matrices, row, i)
            for c in range(2 * n):
                F[row, c] += level.P[u, c]
            a, b = _work_of_unbalance(motion, matrices, level, u, turn)
            F[row, 2 * n] += a
            F[row, 2 * n + 1] += b
            for other in range(row + 1 if is_damped else 0):
                for j in range(_count(matrices, other)):
                    v = _row_of(matrices, other, j)
                    value = level.H[u, u] if u == v else 0.5 * level.H[max(u, v), min(u, v)]
                    H[row, other] += value if row == other else 2.0 * value


@kernel
def _count(matrices: StepMatrices, row: int) -> int:
    """Return how many rows of the matrices of a step are summed in a row of the flight: those of held forces."""
    held = row - (2 * int(matrices.sizes[0].n) + 4)
    return N_LOBATTO if 0 <= held < matrices.gradients.shape[0] else 1


@kernel
def _row_of(matrices: StepMatrices, row: int, number: int) -> int:
    """Return the row of the matrices of a step that is the one of this number in a row of the flight."""
    first = 2 * int(matrices.sizes[0].n) + 4
    if row < first:
        return row
    axes, n_ports = matrices.gradients.shape[0], int(matrices.sizes[0].n_ports)
    axis, point = (row - first) % axes, (row - first) // axes + number
    return first + 2 * (n_ports * point + port_of_bearing(matrices, axis // 2)) + axis % 2


@kernel
def _work_of_unbalance(
    motion: Motion, matrices: StepMatrices, level: Level, row: int, turn: float
) -> tuple[float, float]:
    """Return w_A and w_B of a row of the matrices of a step, in which the rotor turns by an angle (rad).

    With C = cosine . q and S = sine . q at an angle phi from the beginning, and D = A + i B,

        p . q = A (C cos(phi) + S sin(phi)) + B (S cos(phi) - C sin(phi)),    p' = i Omega p
    """
    n_ports, force = int(matrices.sizes[0].n_ports), forces(motion)
    a = b = 0.0
    for point in range(N_LOBATTO):
        cosine = sine = 0.0
        if point > 0:
            at = place_index(n_ports, point, -1)
            cosine, sine = level.S[row, at], level.S[row, at + 1]
        elif row < force.cosine.shape[0]:
            cosine, sine = force.cosine[row], force.sine[row]
        phi, share = turn * LOBATTO_POINTS[point], turn * LOBATTO_WEIGHTS[point]
        along = cosine * math.cos(phi) + sine * math.sin(phi)
        across = sine * math.cos(phi) - cosine * math.sin(phi)
        a -= share * across
        b += share * along
        if point == 0:
            a -= along
            b -= across
        elif point == N_LOBATTO - 1:
            a += along
            b += across
    return a, b


@kernel
def can_fly(w: Workspace, matrices: StepMatrices) -> bool:
    """Return whether no site is in contact, no race turns, and the speed is constant."""
    if matrices.sizes[0].place == 0.0:
        return False
    v = stages_of(w.stages).z[w.n :]
    for site in w.sites:
        if site.mode != FREE or (site.race >= 0 and v[site.race] != 0.0):
            return False
    return True


@noinline_kernel
def fly(w: Workspace, matrices: StepMatrices, theta: float, h: float) -> tuple[bool, float, float]:
    """Write the end of a step of length h (s) to z_new; return energy taken by dampers, and work of the unbalance (J).

    The first result states whether the flight is accurate, and clear of all sites.
    """
    motion, sizes, stages = w.motion, matrices.sizes[0], stages_of(w.stages)
    z, z_new, n, n_bearings = stages.z, stages.z_new, int(sizes.n), motion.bearings.shape[0]
    which = int(sizes.place - CONSTANT)
    if not flight_is_current(matrices, which):
        build_flight(motion, matrices, which)
    flight = flight_of(matrices, which)
    F, x, end, axes, first = flight.F, flight.x, flight.end, 2 * n_bearings, 2 * n + 4
    direction = unbalance_direction(theta, motion.Omega, 0.0)
    copy(z[:n], x)
    copy(z[w.n : w.n + n], x[n:])
    x[2 * n], x[2 * n + 1], x[2 * n + 2], x[2 * n + 3] = 1.0, 0.0, direction.real, direction.imag
    largest, varies = 0.0, False
    for b in range(n_bearings):
        for axis in range(2):
            force = magnet_force(w, matrices, b, axis, z[motion.bearings[b].row + axis])
            x[first + 2 * b + axis] = force
            largest, varies = max(largest, abs(force)), varies or gradient_change(motion, matrices, b, axis) != 0.0
    held = first + axes
    row_combination(x[:held], F, end, 2 * n + 2)
    if varies:
        for b in range(n_bearings):
            for axis in range(2):
                row, change = motion.bearings[b].row + axis, gradient_change(motion, matrices, b, axis)
                rise, start, last = end[row] - x[row], h * x[n + row], h * end[n + row]
                for k in range(N_LOBATTO - 1):
                    place = OF_RISE[k] * rise + OF_START[k] * start + OF_END[k] * last
                    x[held + axes * k + 2 * b + axis] = change * place
        add_combination(x[held:], F[held:], end, 0, 2 * n + 2)
        for b in range(n_bearings):
            for axis in range(2):
                row, change = motion.bearings[b].row + axis, gradient_change(motion, matrices, b, axis)
                missed = change * (end[row] - x[row]) - x[held + axes * (N_LOBATTO - 2) + 2 * b + axis]
                if not abs(missed) <= SETTLED * largest:
                    return False, 0.0, 0.0
    copy(z, z_new)
    copy(end[:n], z_new)
    copy(end[n : 2 * n], z_new[w.n :])
    for site in w.sites:
        if can_touch(site):
            begin, last_point = journal_of(site, z, w.n), journal_of(site, z_new, w.n)
            if not keeps_distance(site, begin, last_point, h, MARGIN):
                return False, 0.0, 0.0
    start_rotations(w, matrices, theta, motion.Omega)
    advance_rotations(w, matrices, h, 0.0)
    taken = triangular_form(flight.H, x, x.shape[0] if varies else held) if sizes.damped != 0.0 else 0.0
    return True, taken, direction.real * end[2 * n] + direction.imag * end[2 * n + 1]
