"""The end of a solved piece before its length is over: at an event, or at the end of the step.

The forces remain those of the piece: their cubics are taken at the Lobatto points of the part [0, s h], and the motion
from its series. Spin and races, whose torques are such cubics, are advanced anew, so that work and energy agree.
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact import project
from rotor_contact.dynamics import Motion, damping_power, forces, shaft_damping
from rotor_contact.lobatto import LOBATTO_POINTS, N_LOBATTO, restrict, value_at
from rotor_contact.matrix_sizes import place_index
from rotor_contact.over_step import Nodes
from rotor_contact.piece import advance_rotations, end_rotations, piece_of
from rotor_contact.piece_energy import GAUSS_WEIGHTS
from rotor_contact.piece_series import series_of, state_at
from rotor_contact.propagator import N_GAUSS
from rotor_contact.series import GAUSS_POINTS
from rotor_contact.site import is_constrained
from rotor_contact.speed_grid import grid_speed
from rotor_contact.step_matrices import StepMatrices
from rotor_contact.workspace import Workspace, stages_of


@noinline_kernel
def cut_piece(
    w: Workspace,
    matrices: StepMatrices,
    index: float,
    n_terms: int,
    h: float,
    share: float,
    torque: float,
    on_event: bool,
) -> float:
    """Write the state after a share of a piece of length h (s) to z_new; return what dampers take until then (J).

    The nodes of the piece become those of this part, as `piece_energy` needs them. `torque` is that of rotating damping
    on the spin (N m); `index` is the position of the speed on the grid. On an event, sites are put on their circles
    later, when the modes are found.
    """
    piece, stages, n = piece_of(matrices), stages_of(w.stages), int(matrices.sizes[0].n)
    z_new, y = stages.z_new, series_of(matrices).y
    state_at(matrices, n_terms, share, y)
    _restrict_observations(w.motion, matrices, share)
    for row in range(2):
        restrict(piece.spin[row], share)
    for k in range(w.sites.shape[0]):
        restrict(piece.races[k], share)
        if is_constrained(w.sites[k]):
            _restrict_nodes(matrices.nodes[k], share)
    advance_rotations(w, matrices, share * h, torque)
    copy(stages.z, z_new)
    copy(y[:n], z_new)
    copy(y[n:], z_new[w.n :])
    end_rotations(w, matrices, index, share * h)
    if not on_event:
        project(w, z_new[: w.n], z_new[w.n : 2 * w.n], piece.spin[0, N_LOBATTO - 1])
    return _taken_by_dampers(w, matrices, index, n_terms, h, share)


@kernel
def _restrict_observations(motion: Motion, matrices: StepMatrices, share: float) -> None:
    """Replace cosine . q, sine . q and their rates at the Lobatto points by those at the points of [0, s h]."""
    piece, n_ports, force = piece_of(matrices), int(matrices.sizes[0].n_ports), forces(motion)
    observed, y = piece.observed[6], piece.x[: 2 * int(matrices.sizes[0].n)]
    n, a, b, c = y.shape[0] // 2, place_index(n_ports, 1, -1), place_index(n_ports, 2, -1), place_index(n_ports, 3, -1)
    for of_velocity in range(2):
        for direction in range(2):
            start, at, of_direction = 0.0, 2 * of_velocity + direction, force.cosine if direction == 0 else force.sine
            for i in range(of_direction.shape[0]):
                start += of_direction[i] * y[n * of_velocity + i]
            first, second, last = observed[a + at], observed[b + at], observed[c + at]
            observed[a + at] = value_at(start, first, second, last, share * LOBATTO_POINTS[1])
            observed[b + at] = value_at(start, first, second, last, share * LOBATTO_POINTS[2])
            observed[c + at] = value_at(start, first, second, last, share)


@kernel
def _restrict_nodes(nodes: Nodes, s: float) -> None:
    """Replace forces and slip of a site at the Lobatto points by those at the points of [0, s h]."""
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    f_n, f_t, slip = (a.f_n, b.f_n, c.f_n, d.f_n), (a.f_t, b.f_t, c.f_t, d.f_t), (a.slip, b.slip, c.slip, d.slip)
    for point in range(1, N_LOBATTO):
        at, node = s * LOBATTO_POINTS[point], nodes[point]
        node.f_n = value_at(f_n[0], f_n[1], f_n[2], f_n[3], at)
        node.f_t = value_at(f_t[0], f_t[1], f_t[2], f_t[3], at)
        node.slip = value_at(slip[0], slip[1], slip[2], slip[3], at)


@kernel
def _taken_by_dampers(
    w: Workspace, matrices: StepMatrices, index: float, n_terms: int, h: float, share: float
) -> float:
    """Return the energy (J) that the dampers take until `share` of the piece, by Gauss's quadrature over parts.

    A part is at most twice as long as the shortest piece, whose H is by Lobatto's quadrature: both have the same error.
    """
    sizes = matrices.sizes[0]
    if sizes.damped == 0.0:
        return 0.0
    n, y, Omega = int(sizes.n), series_of(matrices).y, grid_speed(matrices, index)
    longest = sizes.step_size * 0.5 ** (sizes.n_built - 2.0)
    parts = max(math.ceil(share * h / longest), 1)
    length, total = share / parts, 0.0
    for number in range(parts):
        for point in range(N_GAUSS):
            state_at(matrices, n_terms, length * (number + GAUSS_POINTS[point]), y)
            total += GAUSS_WEIGHTS[point] * _power_of_dampers(w, n, Omega, y)
    return total * length * h


@kernel
def _power_of_dampers(w: Workspace, n: int, Omega: float, y: Array) -> float:
    """Return the power (W) that the dampers take from the motion (q, v) = y."""
    q, v = y[:n], y[n:]
    heat, torque = shaft_damping(w.forms, Omega, q, v) if w.motion.is_damped else (0.0, 0.0)
    power = heat + Omega * torque + damping_power(w.motion, v)
    for site in w.sites:
        if site.housing >= 0:
            v_x, v_y = v[site.housing], v[site.housing + 1]
            power += site.mount_damping_x * v_x * v_x + site.mount_damping_y * v_y * v_y
    return power
