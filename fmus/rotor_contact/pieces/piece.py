"""Scratch of a piece, and the motion of spin and races in it.

Spin and races turn under torques that, like the forces, are cubics through their values at the Lobatto points:

    Omega_j = Omega_0 + h sum_i a_ji M_i/J,    a_ji = int_0^c_j l_i ds

Unbalance couples the momentum of a free spin to the momentum of the shaft. With p = -sin(theta) cosine + cos(theta)
sine (`bodies`),

    (J Omega + p . v)' = M + p' . v,    p' = -Omega (cos(theta) cosine + sin(theta) sine)

where M is the torque of drive, drag, friction and rotating damping.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.contact.bodies import drag_slope, drive_slope, drive_torque, race_drag
from rotor_contact.contact.face_forces import torque_on_race, torque_on_spin
from rotor_contact.contact.site import Site, is_constrained, race_radius
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.forces.dynamics import Motion, forces
from rotor_contact.matrices.matrix_sizes import n_columns, n_rows, place_index, velocity_index
from rotor_contact.matrices.speed_grid import grid_speed
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.shaft.lobatto import LAGRANGE, LOBATTO_POINTS, LOBATTO_WEIGHTS, N_LOBATTO
from rotor_contact.shaft.seals import add_missed_between_speeds
from rotor_contact.shaft.structure import REAL

MOST_REPETITIONS = 12  # of torques that depend on the speeds
RACE_ERROR = 1e-6  # rad/s, by which the drag of a race may still change its speed
SPIN_ERROR = 1e-12  # of the speed, by which drive and drag may still change it


def _integral(j: int, i: int) -> float:
    """Return a_ji."""
    return sum(c * LOBATTO_POINTS[j] ** (k + 1) / (k + 1) for k, c in enumerate(LAGRANGE[i]))


INTEGRALS = tuple(tuple(_integral(j, i) for i in range(N_LOBATTO)) for j in range(N_LOBATTO))


class Piece(NamedTuple):
    """A piece of a step; columns of bearings without force are omitted from the observations."""

    x: Array  # see `step_matrices`, shape (n_x,)
    ends: Array  # the end of the piece, and scratch of the same size, shape (2, 2 N)
    # Observations (S), shape (7, n_columns). Row 1 is scratch. Row 0 is due to the state and the steady forces, row 2
    # to A = 1, and row 3 to B = 1. Row 4 is due to all of these and to the forces of magnets and contact at the first
    # point, row 5 to contact at the other points, and row 6 to everything.
    observed: Array
    of_forces: Array  # observations of unit forces at the ports, ordered as in x, shape (8 n_ports, n_columns)
    magnets: Array  # forces of magnets and faces at the ports (N), shape (8 n_ports,)
    contact: Array  # and of contacts
    # Speed, angle, torque without contact and torque of friction at the Lobatto points; then cosine . v and sine . v at
    # the first, shape (5, 4).
    spin: Array
    races: Array  # speeds of the races, 0 where there is none, shape (n_sites, 4)


@views
def piece_of(matrices: StepMatrices) -> Piece:
    """Return the scratch of a piece."""
    n, n_ports, n_sites = int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports), matrices.nodes.shape[0]
    rows, columns, units = n_rows(n, n_ports), n_columns(n_ports), 2 * N_LOBATTO * n_ports
    observed = rows + 4 * n
    of_forces = observed + 7 * columns
    magnets_at = of_forces + units * columns
    return Piece(
        part(matrices.pieces, 0, REAL, rows),
        part(matrices.pieces, rows, REAL, (2, 2 * n)),
        part(matrices.pieces, observed, REAL, (7, columns)),
        part(matrices.pieces, of_forces, REAL, (units, columns)),
        part(matrices.pieces, magnets_at, REAL, units),
        part(matrices.pieces, magnets_at + units, REAL, units),
        part(matrices.pieces, magnets_at + 2 * units, REAL, (5, N_LOBATTO)),
        part(matrices.pieces, magnets_at + 2 * units + 5 * N_LOBATTO, REAL, (n_sites, N_LOBATTO)),
    )


@kernel
def start_rotations(w: Workspace, matrices: StepMatrices, theta: float, Omega: float) -> None:
    """Set the initial guess: spin, races and unbalance continue unchanged (values of an earlier piece are not used)."""
    piece, z = piece_of(matrices), stages_of(w.stages).z
    for point in range(N_LOBATTO):
        piece.spin[0, point], piece.spin[1, point] = Omega, theta
        piece.spin[2, point] = piece.spin[3, point] = 0.0
        for k in range(w.sites.shape[0]):
            race = w.sites[k].race
            piece.races[k, point] = z[w.n + race] if race >= 0 else 0.0
    if w.spin[0].row < 0:
        return  # its torque alone depends on the rest
    cosine, sine = _along_unbalance(w.motion, z[w.n :])
    piece.spin[4, 0], piece.spin[4, 1] = cosine, sine
    n_ports = int(matrices.sizes[0].n_ports)
    for point in range(1, N_LOBATTO):
        at = velocity_index(n_ports, point, -1)
        piece.observed[6, at], piece.observed[6, at + 1] = cosine, sine


@kernel
def advance_rotations(w: Workspace, matrices: StepMatrices, h: float, damping_torque: float) -> None:
    """Advance spin and races over a piece of length h (s) under the friction at the nodes; iterate to convergence.

    The function itself iterates the torques of drive and drag, because without contact forces a caller would not notice
    that these torques have not converged.
    """
    piece = piece_of(matrices)
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if site.race >= 0:
            from_faces = torque_on_race(w, k)
            for _ in range(MOST_REPETITIONS):
                before = piece.races[k, N_LOBATTO - 1]
                _advance_race(matrices, piece.races[k], k, site, h, from_faces)
                now = piece.races[k, N_LOBATTO - 1]
                if h * drag_slope(site, now) * abs(now - before) <= RACE_ERROR * site.race_inertia:
                    break
    if w.spin[0].row >= 0:
        rate = drive_slope(w.spin[0]) / w.spin[0].inertia
        for _ in range(MOST_REPETITIONS):
            before = piece.spin[0, N_LOBATTO - 1]
            _advance_spin(w, matrices, piece, h, damping_torque)
            if h * rate * abs(piece.spin[0, N_LOBATTO - 1] - before) <= SPIN_ERROR * abs(before):
                break
    else:
        motion, spin = w.motion, piece.spin
        for point in range(1, N_LOBATTO):
            t = LOBATTO_POINTS[point] * h
            spin[0, point] = spin[0, 0] + motion.Omega_dot * t
            spin[1, point] = spin[1, 0] + (spin[0, 0] + 0.5 * motion.Omega_dot * t) * t


@kernel
def _advance_race(matrices: StepMatrices, speeds: Array, k: int, site: Site, h: float, from_faces: float) -> None:
    """Advance the race of site k, under a torque (N m) that faces exert on it."""
    a = b = c = 0.0
    for i in range(N_LOBATTO):
        torque = from_faces - race_drag(site, speeds[i])
        if is_constrained(site):
            torque -= matrices.nodes[k, i].f_t * race_radius(site)
        torque *= h / site.race_inertia
        a += INTEGRALS[1][i] * torque
        b += INTEGRALS[2][i] * torque
        c += INTEGRALS[3][i] * torque
    speeds[1], speeds[2], speeds[3] = speeds[0] + a, speeds[0] + b, speeds[0] + c


@kernel
def _advance_spin(w: Workspace, matrices: StepMatrices, piece: Piece, h: float, damping_torque: float) -> None:
    """Advance the free spin."""
    spin = w.spin[0]
    speed, angle, torque, friction = piece.spin[0], piece.spin[1], piece.spin[2], piece.spin[3]
    shared, from_faces = (0.0, 0.0, 0.0, 0.0), torque_on_spin(w)
    for i in range(N_LOBATTO):
        cosine, sine = unbalance_velocity(matrices, i)
        c, s = math.cos(angle[i]), math.sin(angle[i])
        torque[i] = drive_torque(spin, speed[i]) - spin.drag * speed[i] + damping_torque
        torque[i] -= speed[i] * (c * cosine + s * sine)
        shared = (shared[1], shared[2], shared[3], c * sine - s * cosine)
        friction[i] = from_faces
        for k in range(w.sites.shape[0]):
            if is_constrained(w.sites[k]):
                friction[i] += matrices.nodes[k, i].f_t * w.sites[k].journal_radius
    first, second, last = 0.0, 0.0, 0.0
    for i in range(N_LOBATTO):
        total = h * (torque[i] + friction[i])
        first += INTEGRALS[1][i] * total
        second += INTEGRALS[2][i] * total
        last += INTEGRALS[3][i] * total
    start = speed[0] * spin.inertia + shared[0]
    speed[1] = (start + first - shared[1]) / spin.inertia
    speed[2] = (start + second - shared[2]) / spin.inertia
    speed[3] = (start + last - shared[3]) / spin.inertia
    a = b = c = 0.0
    for i in range(N_LOBATTO):
        a += INTEGRALS[1][i] * speed[i]
        b += INTEGRALS[2][i] * speed[i]
        c += INTEGRALS[3][i] * speed[i]
    angle[1], angle[2], angle[3] = angle[0] + h * a, angle[0] + h * b, angle[0] + h * c


@kernel
def end_rotations(w: Workspace, matrices: StepMatrices, index: float, h: float) -> None:
    """Write spin and races after a time h (s) to z_new; correct z_new for seals between two speeds of the grid."""
    piece, stages = piece_of(matrices), stages_of(w.stages)
    z_new, low = stages.z_new, float(math.floor(index))
    if index > low:
        below, above = grid_speed(matrices, low), grid_speed(matrices, low + 1.0)
        add_missed_between_speeds(w.motion.seals, below, above, grid_speed(matrices, index), h, stages.z, z_new, w.n)
    for k in range(w.sites.shape[0]):
        race = w.sites[k].race
        if race >= 0:
            z_new[w.n + race] = piece.races[k, 3]
            for point in range(N_LOBATTO):
                z_new[race] += h * LOBATTO_WEIGHTS[point] * piece.races[k, point]
    if w.spin[0].row >= 0:
        z_new[w.spin[0].row], z_new[w.n + w.spin[0].row] = piece.spin[1, 3], piece.spin[0, 3]


@kernel
def unbalance_velocity(matrices: StepMatrices, point: int) -> tuple[float, float]:
    """Return cosine . v and sine . v (kg m^2/s) at a Lobatto point."""
    piece, n_ports = piece_of(matrices), int(matrices.sizes[0].n_ports)
    if point == 0:
        return piece.spin[4, 0], piece.spin[4, 1]
    at = velocity_index(n_ports, point, -1)
    return piece.observed[6, at], piece.observed[6, at + 1]


@kernel
def unbalance_place(w: Workspace, matrices: StepMatrices, point: int) -> tuple[float, float]:
    """Return cosine . q and sine . q (kg m^2) at a Lobatto point."""
    if point > 0:
        observed, at = piece_of(matrices).observed, place_index(int(matrices.sizes[0].n_ports), point, -1)
        return observed[6, at], observed[6, at + 1]
    return _along_unbalance(w.motion, stages_of(w.stages).z)


@kernel
def _along_unbalance(motion: Motion, x: Array) -> tuple[float, float]:
    """Return cosine . x and sine . x of displacements or velocities of the shaft."""
    force = forces(motion)
    cosine = sine = 0.0
    for i in range(force.cosine.shape[0]):
        cosine += force.cosine[i] * x[i]
        sine += force.sine[i] * x[i]
    return cosine, sine


@kernel
def phase_error(piece: Piece) -> float:
    """Return the deviations (rad) of the rotor's angle at the inner points from its angle at the mean speed."""
    angle = piece.spin[1]
    largest = 0.0
    for point in range(1, N_LOBATTO - 1):
        mean = angle[0] + LOBATTO_POINTS[point] * (angle[3] - angle[0])
        largest = max(largest, abs(angle[point] - mean))
    return largest
