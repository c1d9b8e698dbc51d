"""Contact forces at the Lobatto points of a piece: the equations of `collocation`, with moving bodies.

At each point after the first, the normal velocity of the journal relative to its housing vanishes, and a rolling
journal does not slip on its race. Spin and races respond to friction (`piece`). Forces of magnets depend on the
displacements at these points (`piece_ports`), so the equations are solved repeatedly until they converge. Whole steps
write their own equations, but start, locate and solve their nodes with the functions of this module.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rotor_contact.contact.friction import friction_ratio
from rotor_contact.contact.path import Point
from rotor_contact.contact.site import Site, is_constrained, race_radius
from rotor_contact.contact.site_totals import Nodes
from rotor_contact.contact.workspace import Workspace
from rotor_contact.matrices.matrix_sizes import place_index, velocity_index
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece import INTEGRALS, Piece, piece_of
from rotor_contact.pieces.piece_ports import columns_in_use, port_of_housing, port_of_site
from rotor_contact.shaft.linear_solver import solve
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.products import add_combination, add_multiples
from rotor_contact.variables.enumerations import ROLLING

NEGLIGIBLE = 1e-6  # of the largest force: a change for which the equations are not solved again


@kernel
def observe(w: Workspace, matrices: StepMatrices, of_forces: Array, A: float, B: float) -> None:
    """Compute the observations at the ports under node forces and an unbalance in the direction A + i B.

    `of_forces` contains the observations due to unit forces, here and in the functions below.
    """
    piece = piece_of(matrices)
    observed, axes = piece.observed, piece.magnets.shape[0] // N_LOBATTO
    first, columns = columns_in_use(w, matrices)
    of_state, of_A, of_B = observed[0, first:], observed[2, first:], observed[3, first:]
    of_bearings, of_contact, of_all = observed[4, first:], observed[5, first:], observed[6, first:]
    add_multiples(of_state, A, of_A, B, of_B, of_bearings, columns)
    of_contact[:columns] = 0.0
    add_combination(piece.magnets, of_forces, of_bearings, first, columns)
    add_combination(piece.contact[:axes], of_forces, of_bearings, first, columns)
    add_combination(piece.contact[axes:], of_forces[axes:], of_contact, first, columns)
    add_multiples(of_bearings, 1.0, of_contact, 0.0, of_contact, of_all, columns)


@kernel
def observed_journal(site: Site, matrices: StepMatrices, k: int, point: int) -> Point:
    """Return the motion of journal k relative to its retainer's centre, at a Lobatto point after the first."""
    at = _observed_at(site, matrices, piece_of(matrices).observed[6], k, point)
    return Point(at.x - site.offset_x, at.y - site.offset_y, at.v_x, at.v_y)


@kernel
def _observed_at(site: Site, matrices: StepMatrices, observed: Array, k: int, point: int) -> Point:
    """Return the observed motion of journal k relative to its housing, at a Lobatto point after the first."""
    n_ports = int(matrices.sizes[0].n_ports)
    housing = port_of_housing(matrices, k) if site.housing >= 0 else -1
    return _observed_from(observed, n_ports, point, port_of_site(matrices, k), housing)


@kernel
def _observed_from(observed: Array, n_ports: int, point: int, port: int, housing: int) -> Point:
    """Return the observation at a port, relative to the port `housing` if `housing` >= 0."""
    at = place_index(n_ports, point, port)
    x, y, v_x, v_y = observed[at], observed[at + 1], observed[at + 2], observed[at + 3]
    if housing >= 0:
        at = place_index(n_ports, point, housing)
        x -= observed[at]
        y -= observed[at + 1]
        v_x -= observed[at + 2]
        v_y -= observed[at + 3]
    return Point(x, y, v_x, v_y)


@inlined_kernel
def start_nodes(site: Site, nodes: Nodes) -> None:
    """Write the normal, slip and forces of a site to all its nodes, as a guess for those after the first."""
    for node in nodes:
        node.n_x, node.n_y, node.slip = site.n_x, site.n_y, site.slip
        node.f_n, node.f_t = site.f_n, site.f_t


@inlined_kernel
def locate_node(site: Site, node: np.record, at: Point, Omega: float, omega_r: float) -> None:
    """Write the normal, slip and friction ratio of a node at the speeds Omega of the spin and omega_r of the race.

    `at` is the motion of the journal relative to the centre of its retainer.
    """
    r = math.sqrt(at.x * at.x + at.y * at.y)
    node.n_x, node.n_y = at.x / r, at.y / r
    node.slip = Omega * site.journal_radius + node.n_x * at.v_y - node.n_y * at.v_x - omega_r * race_radius(site)
    site.slip = node.slip
    node.ratio = friction_ratio(site, 1.0)


@inlined_kernel
def solve_equations(w: Workspace, matrices: StepMatrices, size: int) -> tuple[float, float]:
    """Solve the written equations, with `size` unknowns at a point, for the forces at all points after the first.

    Returns the largest change of a force, and the largest force (N), which is 0 if the equations are not solvable.
    """
    if not solve(matrices.equations, (N_LOBATTO - 1) * size):
        return 0.0, 0.0
    b = matrices.equations.right_side
    change = largest = 0.0
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if is_constrained(site):
            for point in range(1, N_LOBATTO):
                row, node = (point - 1) * size + site.unknown, matrices.nodes[k, point]
                f_n, f_t = b[row], b[row + 1] if site.mode == ROLLING else node.ratio * b[row]
                change = max(change, max(abs(f_n - node.f_n), abs(f_t - node.f_t)))
                largest = max(largest, abs(f_n))
                node.f_n, node.f_t = f_n, f_t
    return change, largest


@kernel
def locate_nodes(w: Workspace, matrices: StepMatrices) -> None:
    """Write the normal, slip and friction ratio of each constrained site at the Lobatto points after the first."""
    piece = piece_of(matrices)
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if not is_constrained(site):
            continue
        for point in range(1, N_LOBATTO):
            node, at = matrices.nodes[k, point], observed_journal(site, matrices, k, point)
            locate_node(site, node, at, piece.spin[0, point], piece.races[k, point])


@kernel
def moves_on_circles(w: Workspace, matrices: StepMatrices, of_forces: Array, largest: float) -> bool:
    """Return whether the journals in contact move along their circles, and roll or slide as assumed, at all points.

    In this case, solving the equations again in the present directions would change the forces by no more than about
    `NEGLIGIBLE` of the `largest` (N). The change is estimated as the velocity deviations divided by the responses to a
    unit force at the same point.
    """
    n_ports = int(matrices.sizes[0].n_ports)
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if not is_constrained(site):
            continue
        port = port_of_site(matrices, k)
        for point in range(1, N_LOBATTO):
            node, at = matrices.nodes[k, point], observed_journal(site, matrices, k, point)
            response = of_forces[2 * (n_ports * point + port), velocity_index(n_ports, point, port)]
            allowed = NEGLIGIBLE * largest * abs(response)
            if abs(node.n_x * at.v_x + node.n_y * at.v_y) > allowed:
                return False
            if site.mode == ROLLING and abs(node.slip) > allowed:
                return False
            if site.mode != ROLLING and abs(node.ratio * node.f_n - node.f_t) > NEGLIGIBLE * largest:
                return False
    return True


@kernel
def set_contact_forces(w: Workspace, matrices: StepMatrices) -> None:
    """Write the node forces to the ports."""
    piece, n_ports = piece_of(matrices), int(matrices.sizes[0].n_ports)
    piece.contact[:] = 0.0
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if not is_constrained(site):
            continue
        for point in range(N_LOBATTO):
            node = matrices.nodes[k, point]
            f_x = -node.f_n * node.n_x - node.f_t * node.n_y
            f_y = -node.f_n * node.n_y + node.f_t * node.n_x
            unit = 2 * (n_ports * point + port_of_site(matrices, k))
            piece.contact[unit] += f_x
            piece.contact[unit + 1] += f_y
            if site.housing >= 0:
                unit = 2 * (n_ports * point + port_of_housing(matrices, k))
                piece.contact[unit] -= f_x
                piece.contact[unit + 1] -= f_y


@kernel
def solve_nodes(w: Workspace, matrices: StepMatrices, of_forces: Array, size: int, h: float) -> tuple[float, float]:
    """Solve for the forces, in their directions, at all points after the first; return what `solve_equations` does."""
    for k in range(w.sites.shape[0]):
        if is_constrained(w.sites[k]):
            for point in range(1, N_LOBATTO):
                _write_equations(w, matrices, of_forces, k, point, size, h)
    return solve_equations(w, matrices, size)


@kernel
def _write_equations(
    w: Workspace, matrices: StepMatrices, of_forces: Array, k: int, point: int, size: int, h: float
) -> None:
    """Write the equations of site k at a Lobatto point after the first."""
    piece = piece_of(matrices)
    A, b = matrices.equations
    site, node = w.sites[k], matrices.nodes[k, point]
    of_bearings = _observed_at(site, matrices, piece.observed[4], k, point)
    of_contact = _observed_at(site, matrices, piece.observed[5], k, point)
    row, rolling = (point - 1) * size + site.unknown, site.mode == ROLLING
    n_x, n_y = node.n_x, node.n_y
    turn = (-n_y * (of_bearings.v_x + of_contact.v_x) + n_x * (of_bearings.v_y + of_contact.v_y)) / site.clearance
    t_x, t_y = -turn * n_y, turn * n_x
    b[row] = t_x * of_contact.x + t_y * of_contact.y - n_x * of_bearings.v_x - n_y * of_bearings.v_y
    if rolling:
        b[row + 1] = n_y * of_bearings.v_x - n_x * of_bearings.v_y - _surface_speed(w, matrices, piece, k, point, h)
    n_ports = int(matrices.sizes[0].n_ports)
    port, housing = port_of_site(matrices, k), port_of_housing(matrices, k) if site.housing >= 0 else -1
    for other in range(w.sites.shape[0]):
        if not is_constrained(w.sites[other]):
            continue
        other_port, n_unknowns = 2 * port_of_site(matrices, other), 2 if w.sites[other].mode == ROLLING else 1
        other_housing = 2 * port_of_housing(matrices, other) if w.sites[other].housing >= 0 else -1
        slip_response = _slip_response(w, k, other, h) if rolling else 0.0
        for source in range(1, N_LOBATTO):
            cause, column = matrices.nodes[other, source], (source - 1) * size + w.sites[other].unknown
            unit = 2 * n_ports * source + other_port
            of_x = _observed_from(of_forces[unit], n_ports, point, port, housing)
            of_y = _observed_from(of_forces[unit + 1], n_ports, point, port, housing)
            if other_housing >= 0:
                unit = 2 * n_ports * source + other_housing
                x = _observed_from(of_forces[unit], n_ports, point, port, housing)
                y = _observed_from(of_forces[unit + 1], n_ports, point, port, housing)
                of_x = Point(of_x.x - x.x, of_x.y - x.y, of_x.v_x - x.v_x, of_x.v_y - x.v_y)
                of_y = Point(of_y.x - y.x, of_y.y - y.y, of_y.v_x - y.v_x, of_y.v_y - y.v_y)
            f_x, f_y, f_t = -cause.n_x - cause.ratio * cause.n_y, -cause.n_y + cause.ratio * cause.n_x, cause.ratio
            for i in range(n_unknowns):
                if i == 1:
                    f_x, f_y, f_t = -cause.n_y, cause.n_x, 1.0
                q_x, q_y = of_x.x * f_x + of_y.x * f_y, of_x.y * f_x + of_y.y * f_y
                v_x, v_y = of_x.v_x * f_x + of_y.v_x * f_y, of_x.v_y * f_x + of_y.v_y * f_y
                A[row, column + i] = n_x * v_x + n_y * v_y + t_x * q_x + t_y * q_y
                if rolling:
                    slip = f_t * INTEGRALS[point][source] * slip_response
                    A[row + 1, column + i] = n_x * v_y - n_y * v_x + slip


@kernel
def _slip_response(w: Workspace, k: int, other: int, h: float) -> float:
    """Return the change of slip at site k, through spin and race, if unit friction acts at `other` for h (s)."""
    site, cause = w.sites[k], w.sites[other]
    rate = 0.0
    if site.spin >= 0:
        rate = site.journal_radius * cause.journal_radius / w.spin[0].inertia
    if k == other and site.race >= 0:
        rate += site.race_mobility
    return h * rate


@kernel
def _surface_speed(w: Workspace, matrices: StepMatrices, piece: Piece, k: int, point: int, h: float) -> float:
    """Return the surface velocity (m/s) of journal k relative to its race, without the friction at later points."""
    site = w.sites[k]
    speed = piece.spin[0, point] * site.journal_radius - piece.races[k, point] * race_radius(site)
    for other in range(w.sites.shape[0]):
        if is_constrained(w.sites[other]):
            response = _slip_response(w, k, other, h)
            for source in range(1, N_LOBATTO):
                speed -= INTEGRALS[point][source] * response * matrices.nodes[other, source].f_t
    return speed
