"""Contact forces by collocation on the exact motion, for a whole step in which the constraint persists.

Between events the force at a site is smooth. Over a step of length h it is approximated by the cubic through its values
at the Lobatto points, F_j = -N_j n_j + T_j t_j. The motion follows exactly from this cubic (`whole_step`). The values
follow from

    j = 0    n . a = -|v|^2/r        the constraint on the acceleration (4.15), as `constraints` solves it
    j > 0    n_j . v_j = 0           the constraint on the velocity
             T_j = -mu_j sign N_j    sliding, or slip_j = 0 for a journal that rolls

v_j is linear in x and in all forces; S has the coefficients. The equations of all sites and points are thus linear
except for the directions n_j, which depend on the displacements q_j and hence on the forces. They are solved repeatedly
until the directions converge. Each sweep includes the rotation of the directions with the displacements,

    n_j . v_j + (t_j . v_j/c) (q_j - q_j_before) . t_j = 0        (1)

which saves a sweep. The journals are not constrained to their circles at the inner points. The distance of a journal
from its circle at these points measures the error; the error at the end of the step is much smaller.

Lobatto collocation of index-2 systems: Hairer, Lubich and Roche, The Numerical Solution of Differential-Algebraic
Systems by Runge-Kutta Methods, Springer 1989.
"""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.constraints import find_multipliers, number_unknowns, put_on_circles
from rotor_contact.contact.path import Point
from rotor_contact.contact.site import Site, is_constrained
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.matrices.matrix_sizes import N_OBSERVED
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece_contact import locate_node, solve_equations, start_nodes
from rotor_contact.pieces.site_in_piece import follows_circle, keeps_mode
from rotor_contact.shaft.lobatto import N_LOBATTO
from rotor_contact.shaft.products import inlined_row_combination
from rotor_contact.variables.enumerations import ROLLING
from rotor_contact.whole_steps.whole_step_rows import WholeStep, first_contact, observed

MAX_SWEEPS = 8
SETTLED = 1e-5  # of the largest force: change of the forces in the last sweep; that of another would be a fiftieth


@noinline_kernel
def find_forces(w: Workspace, matrices: StepMatrices, whole: WholeStep) -> bool:
    """Write the contact forces at the later points of a step into x; return False if the step may contain an event.

    Call `find_first_forces` first. The function also returns False if the forces cannot be computed with sufficient
    accuracy.
    """
    size = number_unknowns(w.sites)
    _locate_nodes(w, matrices, whole)
    for _ in range(MAX_SWEEPS):
        solved, change = _solve_nodes(w, matrices, whole, size)
        if not solved:
            return False
        _locate_nodes(w, matrices, whole)
        if change <= SETTLED:
            return _is_smooth(w, matrices, whole)
    return False


@kernel
def find_first_forces(w: Workspace, matrices: StepMatrices, whole: WholeStep) -> bool:
    """Write the initial forces to the first point and, as a guess, to the others; return False if any is tensile."""
    n, n_sites = w.Minv.shape[0], w.sites.shape[0]
    start, free = whole.x, first_contact(matrices)
    later = free + 2 * n_sites
    start[free:] = 0.0
    a = stages_of(w.stages).k_1[n : 2 * n]
    for k in range(n_sites):
        site = w.sites[k]
        if is_constrained(site):
            inlined_row_combination(start[:free], whole.S[k], whole.free_response[k], N_OBSERVED)
            acceleration = observed(whole.free_response[k]).a_start
            a[site.row], a[site.row + 1] = acceleration[0], acceleration[1]
    if not find_multipliers(w, start[:n], start[n : 2 * n], w.motion.Omega, a):
        return False
    for k in range(n_sites):
        site = w.sites[k]
        if is_constrained(site):
            if not site.f_n > 0.0:
                return False
            start_nodes(site, matrices.nodes[k])
            _set_forces(matrices, whole, k)
    for k in range(n_sites):
        if is_constrained(w.sites[k]):
            response, of_first = whole.free_response[k], whole.contact_response[k]
            inlined_row_combination(start[free:later], whole.S[k, free:later], of_first, N_OBSERVED)
            for i in range(N_OBSERVED):
                response[i] += of_first[i]
    return True


@kernel
def _set_forces(matrices: StepMatrices, whole: WholeStep, k: int) -> None:
    """Write the forces at the nodes of site k to x."""
    for point in range(N_LOBATTO):
        node, unit = matrices.nodes[k, point], first_contact(matrices) + 2 * (matrices.nodes.shape[0] * point + k)
        whole.x[unit] = -node.f_n * node.n_x - node.f_t * node.n_y
        whole.x[unit + 1] = -node.f_n * node.n_y + node.f_t * node.n_x


@kernel
def _locate_nodes(w: Workspace, matrices: StepMatrices, whole: WholeStep) -> None:
    """Locate the journals at the Lobatto points under the forces in x; write their normals and slip."""
    later = first_contact(matrices) + 2 * w.sites.shape[0]
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if is_constrained(site):
            free, contact = whole.free_response[k], whole.contact_response[k]
            inlined_row_combination(whole.x[later:], whole.S[k, later:], contact, N_OBSERVED)
            of_free, of_contact = observed(free), observed(contact)
            for point in range(1, N_LOBATTO):
                at = _journal(site, of_free, of_contact, point - 1)
                locate_node(site, matrices.nodes[k, point], at, w.motion.Omega, 0.0)


@kernel
def _solve_nodes(w: Workspace, matrices: StepMatrices, whole: WholeStep, size: int) -> tuple[bool, float]:
    """Solve for the forces, in their directions, at all points after the first.

    `size` is the number of unknowns at a point. Returns whether the equations are solvable, and the largest change of a
    force relative to the largest force.
    """
    for k in range(w.sites.shape[0]):
        if is_constrained(w.sites[k]):
            for point in range(1, N_LOBATTO):
                _write_equations(w, matrices, whole, k, point, size)
    change, largest = solve_equations(w, matrices, size)
    if not largest > 0.0:
        return False, 0.0
    for k in range(w.sites.shape[0]):
        if is_constrained(w.sites[k]):
            _set_forces(matrices, whole, k)
    return True, change / largest


@kernel
def _write_equations(w: Workspace, matrices: StepMatrices, whole: WholeStep, k: int, point: int, size: int) -> None:
    """Write the equations (1) of site k at a Lobatto point after the first."""
    n_sites = w.sites.shape[0]
    A, b = matrices.equations
    site, node = w.sites[k], matrices.nodes[k, point]
    of_free = observed(whole.free_response[k]).journal[point - 1]
    of_contact = observed(whole.contact_response[k]).journal[point - 1]
    row, rolling = (point - 1) * size + site.unknown, site.mode == ROLLING
    n_x, n_y = node.n_x, node.n_y
    turn = (node.slip - w.motion.Omega * site.journal_radius) / site.clearance  # the speed of whirl
    t_x, t_y = -turn * n_y, turn * n_x
    b[row] = t_x * of_contact.x + t_y * of_contact.y - n_x * of_free.v_x - n_y * of_free.v_y
    if rolling:
        b[row + 1] = n_y * of_free.v_x - n_x * of_free.v_y - w.motion.Omega * site.journal_radius
    for other in range(n_sites):
        if not is_constrained(w.sites[other]):
            continue
        for source in range(1, N_LOBATTO):
            cause, column = matrices.nodes[other, source], (source - 1) * size + w.sites[other].unknown
            unit = first_contact(matrices) + 2 * (n_sites * source + other)
            of_x = observed(whole.S[k, unit]).journal[point - 1]
            of_y = observed(whole.S[k, unit + 1]).journal[point - 1]
            f_x, f_y = -cause.n_x - cause.ratio * cause.n_y, -cause.n_y + cause.ratio * cause.n_x
            for i in range(2 if w.sites[other].mode == ROLLING else 1):
                if i == 1:
                    f_x, f_y = -cause.n_y, cause.n_x
                q_x, q_y = of_x.x * f_x + of_y.x * f_y, of_x.y * f_x + of_y.y * f_y
                v_x, v_y = of_x.v_x * f_x + of_y.v_x * f_y, of_x.v_y * f_x + of_y.v_y * f_y
                A[row, column + i] = n_x * v_x + n_y * v_y + t_x * q_x + t_y * q_y
                if rolling:
                    A[row + 1, column + i] = n_x * v_y - n_y * v_x


@kernel
def _is_smooth(w: Workspace, matrices: StepMatrices, whole: WholeStep) -> bool:
    """Return whether no site opens, sticks or slips in the piece, and all stay close enough to their circles."""
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if is_constrained(site):
            free, contact = observed(whole.free_response[k]), observed(whole.contact_response[k])
            first, second = _journal(site, free, contact, 0), _journal(site, free, contact, 1)
            if not (keeps_mode(site, matrices.nodes[k]) and follows_circle(site, first, second)):
                return False
    return True


@kernel
def _journal(site: Site, free: np.record, contact: np.record, number: int) -> Point:
    """Return the motion of a journal relative to its retainer's centre at a Lobatto point after the first."""
    a, b = free.journal[number], contact.journal[number]
    return Point(a.x + b.x - site.offset_x, a.y + b.y - site.offset_y, a.v_x + b.v_x, a.v_y + b.v_y)


@noinline_kernel
def find_end_forces(w: Workspace, whole: WholeStep, end: Array) -> bool:
    """Project the end of a piece onto the circles and store the forces at the sites; return False if any is tensile.

    The forces follow from the acceleration at the end and are therefore as accurate as the motion, and more accurate
    than the cubic.
    """
    n = w.Minv.shape[0]
    a = stages_of(w.stages).k_1[n : 2 * n]
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if is_constrained(site):
            of_free, of_contact = whole.free_response[k], whole.contact_response[k]
            for axis in range(2):
                a[site.row + axis] = observed(of_free).a_end[axis] + observed(of_contact).a_end[axis]
    if not put_on_circles(w, end):
        return False
    if not find_multipliers(w, end[:n], end[n : 2 * n], w.motion.Omega, a):
        return False
    for site in w.sites:
        if is_constrained(site) and not site.f_n > 0.0:
            return False
    return True
