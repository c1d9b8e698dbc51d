"""The end of a solved piece that is cut short, at an event or at the end of the step.

The forces remain unchanged, so their cubics are evaluated at the Lobatto points of the part [0, s h]. The motion at
these points follows from its series, and so do slip and the work of the unbalance. Spin and races, whose torques are
such cubics, are advanced again, so that work and energy agree.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.constraints import project
from rotor_contact.contact.site import Site, Sites, is_constrained
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.forces.dynamics import Motion, damping_power, forces, shaft_damping
from rotor_contact.matrices.matrix_sizes import place_index
from rotor_contact.matrices.speed_grid import grid_speed
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece import advance_rotations, end_rotations, piece_of
from rotor_contact.pieces.piece_energy import Damping
from rotor_contact.pieces.piece_series import series_of, slip_at, state_at
from rotor_contact.shaft.lobatto import LOBATTO_POINTS, N_LOBATTO, restrict, value_at
from rotor_contact.shaft.products import dot
from rotor_contact.shaft.seals import seal_power

N_GAUSS = 4  # points of Gauss's quadrature, in [0, 1]
GAUSS_POINTS = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)
GAUSS_WEIGHTS = (0.17392742256872692, 0.3260725774312731, 0.3260725774312731, 0.17392742256872692)


@noinline_kernel
def cut_piece(
    w: Workspace,
    matrices: StepMatrices,
    index: float,
    n_terms: int,
    h: float,
    share: float,
    on_event: bool,
) -> Damping:
    """Write the state at the end of the first part of a piece to z_new; return heat and work of damping in it.

    The nodes of the piece become the nodes of this part, because `piece_energy` needs them. `index` is the position of
    the speed on the grid. After an event, the journals in contact are put on their circles later, when the modes are
    found.
    """
    piece, stages, n = piece_of(matrices), stages_of(w.stages), int(matrices.sizes[0].n)
    z_new, y = stages.z_new, series_of(matrices).y
    of_damping = _damping_in_part(w, matrices, index, n_terms, h, share)
    for k in range(w.sites.shape[0]):
        if is_constrained(w.sites[k]):
            _restrict_nodes(matrices, w.sites[k], k, n_terms, share)
    for point in range(1, N_LOBATTO):
        state_at(matrices, n_terms, share * LOBATTO_POINTS[point], y)
        _observe_unbalance(w.motion, matrices, point, y)
    for row in range(2):
        restrict(piece.spin[row], share)
    for k in range(w.sites.shape[0]):
        restrict(piece.races[k], share)
    advance_rotations(w, matrices, share * h, of_damping.impulse / (share * h))
    copy(stages.z, z_new)
    copy(y[:n], z_new)
    copy(y[n:], z_new[w.n :])
    end_rotations(w, matrices, index, share * h)
    if not on_event:
        project(w, z_new[: w.n], z_new[w.n : 2 * w.n], piece.spin[0, N_LOBATTO - 1])
    return of_damping


@kernel
def _observe_unbalance(motion: Motion, matrices: StepMatrices, point: int, y: Array) -> None:
    """Write cosine . q and sine . q of the state y, and their rates, to the observations at a Lobatto point."""
    observed, force, n = piece_of(matrices).observed[6], forces(motion), y.shape[0] // 2
    at, size = place_index(int(matrices.sizes[0].n_ports), point, -1), force.cosine.shape[0]
    for of_velocity in range(2):
        first = n * of_velocity
        observed[at + 2 * of_velocity] = dot(force.cosine, y[first : first + size])
        observed[at + 2 * of_velocity + 1] = dot(force.sine, y[first : first + size])


@kernel
def _restrict_nodes(matrices: StepMatrices, site: Site, k: int, n_terms: int, s: float) -> None:
    """Replace forces and slip of a site at the Lobatto points by their values at the Lobatto points of [0, s h]."""
    nodes = matrices.nodes[k]
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    f_n, f_t = (a.f_n, b.f_n, c.f_n, d.f_n), (a.f_t, b.f_t, c.f_t, d.f_t)
    for point in range(1, N_LOBATTO):
        at, node = s * LOBATTO_POINTS[point], nodes[point]
        node.f_n = value_at(f_n[0], f_n[1], f_n[2], f_n[3], at)
        node.f_t = value_at(f_t[0], f_t[1], f_t[2], f_t[3], at)
        node.slip = slip_at(matrices, site, k, n_terms, at)


@kernel
def _damping_in_part(
    w: Workspace, matrices: StepMatrices, index: float, n_terms: int, h: float, share: float
) -> Damping:
    """Return heat, impulse and work in the first `share` of the piece, by Gauss's quadrature over its parts.

    The forms of the shortest piece come from Lobatto's quadrature. A part is at most twice as long as this piece, so
    that both quadratures have the same error.
    """
    sizes = matrices.sizes[0]
    if sizes.damped == 0.0 and (sizes.powered == 0.0 or w.spin[0].row < 0):
        return Damping(0.0, 0.0, 0.0)
    n, m, y, Omega = int(sizes.n), w.Minv.shape[0], series_of(matrices).y, grid_speed(matrices, index)
    longest = sizes.step_size * 0.5 ** (sizes.n_built - 2.0)
    parts = max(math.ceil(share * h / longest), 1)
    length, heat, impulse, work = share / parts, 0.0, 0.0, 0.0
    for number in range(parts):
        for point in range(N_GAUSS):
            state_at(matrices, n_terms, length * (number + GAUSS_POINTS[point]), y)
            q, v, weight = y[:n], y[n:], GAUSS_WEIGHTS[point] * length * h
            of_shaft, torque = shaft_damping(w.forms, Omega, q, v) if w.motion.is_damped else (0.0, 0.0)
            of_seals, _, of_skew = seal_power(w.motion.seals, Omega, q[:m], v)
            heat += weight * (of_shaft + of_seals + damping_power(w.motion, v) + mount_heat_of(w.sites, v))
            impulse += weight * torque
            work += weight * of_skew
    return Damping(heat, impulse, work if w.spin[0].row >= 0 else work - Omega * impulse)


@kernel
def mount_heat_of(sites: Sites, v: Array) -> float:
    """Return the heat (W) of the mounts."""
    power = 0.0
    for site in sites:
        if site.housing >= 0:
            v_x, v_y = v[site.housing], v[site.housing + 1]
            power += site.mount_damping_x * v_x * v_x + site.mount_damping_y * v_y * v_y
    return power
