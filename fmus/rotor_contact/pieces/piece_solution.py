"""One piece of a step by the matrices: the exact motion with node forces, without contact events."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.parts import part
from rotor_contact.contact.bodies import couple_spin, drive_torque, race_drag
from rotor_contact.contact.constraints import find_multipliers, is_any_constrained, number_unknowns, put_on_circles
from rotor_contact.contact.face_forces import is_any_pressing, torque_on_race, torque_on_spin
from rotor_contact.contact.faces import faces_of
from rotor_contact.contact.friction import friction_excess
from rotor_contact.contact.site import is_constrained, slip_velocity
from rotor_contact.contact.workspace import Workspace, stages_of
from rotor_contact.forces.dynamics import spin_coupling, unbalance_direction
from rotor_contact.matrices.matrix_inputs import combine_around
from rotor_contact.matrices.speed_grid import LevelsAround, grid_speed, levels_around
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.face_in_piece import (
    begin_face_forces,
    observe_face_forces,
    settle_face_forces,
)
from rotor_contact.pieces.piece import advance_rotations, end_rotations, piece_of, start_rotations
from rotor_contact.pieces.piece_contact import (
    locate_nodes,
    moves_on_circles,
    observe,
    set_contact_forces,
    solve_nodes,
    start_nodes,
)
from rotor_contact.pieces.piece_ports import (
    columns_in_use,
    gradients_change,
    magnet_force,
    magnets_act,
    port_of_bearing,
    port_of_face,
    port_of_housing,
    port_of_site,
    set_magnet_forces,
)
from rotor_contact.shaft.lobatto import LOBATTO_WEIGHTS, N_LOBATTO
from rotor_contact.shaft.products import (
    combination,
    combination_between,
    interpolate,
    isotropic_combination,
    isotropic_combination_between,
)
from rotor_contact.shaft.structure import REAL
from rotor_contact.variables.enumerations import ROLLING

MAX_SWEEPS = 8
SETTLED = 1e-5  # of the largest force: change of the forces in the last sweep; that of another would be a thousandth
FACES_SETTLED = 1e-5  # of the largest normal force: error of the forces of faces before their last correction


@kernel
def find_contact_forces(
    w: Workspace, matrices: StepMatrices, z: Array, index: float, theta: float, Omega: float, torque: float
) -> bool:
    """Find the contact forces at z from the acceleration there; return False if a constrained site is in tension.

    `index` is the position of the speed on the grid, and `torque` is the torque (N m) of rotating damping on the spin.
    """
    if not is_any_constrained(w.sites):
        return True
    piece = piece_of(matrices)
    n, n_ports, level = int(matrices.sizes[0].n), int(matrices.sizes[0].n_ports), int(matrices.sizes[0].n_levels) - 1
    observed, m = piece.observed, 2 * n_ports + 2
    combine_around(matrices, level, index)
    around = levels_around(matrices, level, index)
    direction = unbalance_direction(theta, Omega, w.motion.Omega_dot)
    x = piece.x[: 2 * n + 4]
    copy(z[:n], x)
    copy(z[w.n : w.n + n], x[n:])
    x[2 * n], x[2 * n + 1], x[2 * n + 2], x[2 * n + 3] = 1.0, 0.0, direction.real, direction.imag
    S, S_high, share = around.low.S, around.high.S, around.share
    _combine(matrices, x, S, S_high, share, observed[0], observed[1], 0, m)
    for b in range(w.motion.bearings.shape[0]):
        port, row = port_of_bearing(matrices, b), w.motion.bearings[b].row
        for axis in range(2):
            force = magnet_force(w, matrices, b, axis, z[row + axis])
            if force != 0.0:
                unit = 2 * n + 4 + 2 * port + axis
                for c in range(m):
                    observed[0, c] += force * ((1.0 - share) * S[unit, c] + share * S_high[unit, c])
    if is_any_pressing(w):
        observe_face_forces(w, matrices, around, z, Omega, observed[0, :m])
        torque += torque_on_spin(w)
    a = stages_of(w.stages).k_1[w.n :]
    for k in range(w.sites.shape[0]):
        site, port = w.sites[k], 2 * port_of_site(matrices, k)
        a[site.row], a[site.row + 1] = observed[0, 2 + port], observed[0, 3 + port]
        if site.housing >= 0:
            port = 2 * port_of_housing(matrices, k)
            a[site.housing], a[site.housing + 1] = observed[0, 2 + port], observed[0, 3 + port]
        if site.race >= 0:
            from_faces = torque_on_race(w, k)
            a[site.race] = (from_faces - race_drag(site, z[w.n + site.race])) / site.race_inertia
    if w.spin[0].row >= 0:
        _accelerate_spin(w, observed[0], theta, Omega, torque, a)
    if not find_multipliers(w, z[: w.n], z[w.n : 2 * w.n], Omega, a):
        return False
    for site in w.sites:
        if is_constrained(site):
            if not site.f_n > 0.0:
                return False
            if site.mode == ROLLING and friction_excess(site, site.f_n, site.f_t) > 0.0:
                return False
    return True


@kernel
def _combine(
    matrices: StepMatrices,
    x: Array,
    low: Array,
    high: Array,
    share: float,
    y: Array,
    room: Array,
    first: int,
    columns: int,
) -> None:
    """Write `columns` numbers of x A, from column `first`, into y, with A interpolated between two speeds.

    `room` is scratch of the same size.
    """
    sizes = matrices.sizes[0]
    if sizes.isotropic != 0.0 and share == 0.0:
        isotropic_combination(x, low, y, room, first, columns)
    elif sizes.isotropic != 0.0:
        isotropic_combination_between(x, low, high, share, y, room, first, columns)
    elif share == 0.0:
        combination(x, low, y, first, columns)
    else:
        combination_between(x, low, high, share, y, first, columns)


@kernel
def _accelerate_spin(w: Workspace, observed: Array, theta: float, Omega: float, torque: float, a: Array) -> None:
    """Write the free spin's acceleration, and add its effect on the shaft at the sites (see `bodies`)."""
    spin = w.spin[0]
    couple_spin(w.motion, spin, theta)
    torque += drive_torque(spin, Omega) - spin.drag * Omega
    torque -= math.cos(theta) * observed[1] - math.sin(theta) * observed[0]
    a[spin.row] = torque * spin.scale * spin.scale
    s = spin_coupling(w.motion).s
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        for axis in range(2):
            is_first = True
            for other in range(k):
                is_first = is_first and w.sites[other].row != site.row
            if is_first:
                a[site.row + axis] -= s[site.row + axis] * (torque * spin.scale)


@kernel
def begin_piece(w: Workspace, matrices: StepMatrices, level: int, index: float) -> None:
    """Compute the observations due to z and to unit forces, with matrices interpolated to `index`."""
    piece, z = piece_of(matrices), stages_of(w.stages).z
    n = int(matrices.sizes[0].n)
    observed = piece.observed
    first, columns = columns_in_use(w, matrices)
    x = piece.x[: 2 * n + 2]
    copy(z[:n], x)
    copy(z[w.n : w.n + n], x[n:])
    x[2 * n], x[2 * n + 1] = 1.0, 0.0
    combine_around(matrices, level, index)
    around = levels_around(matrices, level, index)
    S, S_high, share = around.low.S, around.high.S, around.share
    _combine(matrices, x, S, S_high, share, observed[0, first:], observed[5], first, columns)
    for direction in range(2):
        row = 2 * n + 2 + direction
        low, high, target = S[row, first:], S_high[row, first:], observed[2 + direction, first:]
        interpolate(low, high, share, target, columns)
    if share == 0.0:
        return
    for k in range(w.sites.shape[0]):
        if is_constrained(w.sites[k]):
            _observe_units(matrices, around, port_of_site(matrices, k), first, columns)
            if w.sites[k].housing >= 0:
                _observe_units(matrices, around, port_of_housing(matrices, k), first, columns)
    if is_any_pressing(w):
        _observe_faces(w, matrices, around, first, columns)
    if magnets_act(w, matrices):
        for b in range(w.motion.bearings.shape[0]):
            _observe_units(matrices, around, port_of_bearing(matrices, b), first, columns)


@kernel
def _observe_faces(w: Workspace, matrices: StepMatrices, around: LevelsAround, first: int, columns: int) -> None:
    """Compute the observations due to unit forces at the faces and the housings that carry them."""
    for k in range(w.sites.shape[0]):
        if w.sites[k].housing >= 0 and not is_constrained(w.sites[k]):
            _observe_units(matrices, around, port_of_housing(matrices, k), first, columns)
    for k in range(faces_of(w.faces, w.Minv.shape[0]).records.shape[0]):
        for of_slope in range(2):
            _observe_units(matrices, around, port_of_face(matrices, k, of_slope), first, columns)


@kernel
def _observe_units(matrices: StepMatrices, around: LevelsAround, port: int, first: int, columns: int) -> None:
    """Compute the observations due to unit forces at a port."""
    sizes, of_forces = matrices.sizes[0], piece_of(matrices).of_forces
    n_ports = int(sizes.n_ports)
    for point in range(N_LOBATTO):
        for axis in range(2):
            unit = 2 * (n_ports * point + port) + axis
            at = 2 * int(sizes.n) + 4 + unit
            low, high, target = around.low.S[at, first:], around.high.S[at, first:], of_forces[unit, first:]
            interpolate(low, high, around.share, target, columns)


@kernel
def solve_piece(
    w: Workspace,
    matrices: StepMatrices,
    level: int,
    index: float,
    h: float,
    theta: float,
    Omega: float,
    torque: float,
) -> bool:
    """Find all node forces, with spin and races; return False if they do not converge.

    The sites must contain the contact forces at z.
    """
    piece, in_contact = piece_of(matrices), is_any_constrained(w.sites)
    around, of_forces = levels_around(matrices, level, index), piece.of_forces
    if around.share == 0.0:  # rows of S; else `_observe_units` has interpolated them
        first = 2 * int(matrices.sizes[0].n) + 4
        of_forces = part(around.low.S, first * of_forces.shape[1], REAL, of_forces.shape)
    size = number_unknowns(w.sites) if in_contact else 0
    v = stages_of(w.stages).z[w.n : 2 * w.n]
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if is_constrained(site):
            site.slip = slip_velocity(site, v, Omega)  # a piece that was given up has left another
            start_nodes(site, matrices.nodes[k])
    set_contact_forces(w, matrices)
    start_rotations(w, matrices, theta, Omega)
    with_magnets, axes = gradients_change(w.motion, matrices), 2 * int(matrices.sizes[0].n_ports)
    responds = in_contact or _has_rotations(w)  # otherwise only the forces of magnets and faces change
    piece.magnets[:] = 0.0
    are_magnets, are_faces = magnets_act(w, matrices), is_any_pressing(w)
    if are_magnets:
        set_magnet_forces(w, matrices, 0)
        for unit in range(axes):
            for point in range(1, N_LOBATTO):
                piece.magnets[axes * point + unit] = piece.magnets[unit]
    if are_faces:
        begin_face_forces(w, matrices, h)
    largest = change = faces_changed = of_faces = 0.0
    for sweep in range(MAX_SWEEPS):
        if sweep == 0 or responds:
            advance_rotations(w, matrices, h, torque)
        direction = _direction(w, matrices, index, h, theta)
        piece.x[piece.x.shape[0] - piece.magnets.shape[0] - 2] = direction.real
        piece.x[piece.x.shape[0] - piece.magnets.shape[0] - 1] = direction.imag
        observe(w, matrices, of_forces, direction.real, direction.imag)
        if in_contact:
            locate_nodes(w, matrices)
        if sweep > 0 and change <= SETTLED * largest + 1e-300 and faces_changed <= FACES_SETTLED * of_faces:
            return True
        if sweep > 0 and not are_magnets and not are_faces and moves_on_circles(w, matrices, of_forces, largest):
            return True
        change = largest = faces_changed = of_faces = 0.0
        if are_faces:
            solved, faces_changed, of_faces = settle_face_forces(w, matrices, of_forces)
            if not solved:
                return False
        if with_magnets:
            for point in range(1, N_LOBATTO):
                change = max(change, set_magnet_forces(w, matrices, point))
            for unit in range(axes):
                largest = max(largest, abs(piece.magnets[unit]))
        if in_contact:
            of_contact, force = solve_nodes(w, matrices, of_forces, size, h)
            if not force > 0.0:
                return False
            change, largest = max(change, of_contact), max(largest, force)
            set_contact_forces(w, matrices)
        if not responds and not are_faces and change <= SETTLED * largest:
            return True  # the observations lag by this change, too little for gaps and work to depend on it
    return False


@kernel
def _has_rotations(w: Workspace) -> bool:
    """Return whether the spin is free or a site has a race, so that forces can change their speeds."""
    if w.spin[0].row >= 0:
        return True
    for site in w.sites:
        if site.race >= 0:
            return True
    return False


@kernel
def _direction(w: Workspace, matrices: StepMatrices, index: float, h: float, theta: float) -> complex:
    """Return the initial direction of the unbalance, computed with the mean speed and acceleration of the piece.

    The matrices assume that the unbalance turns at Omega_g, a speed on the grid. Its initial angle is theta plus the
    mean deviation of the rotor's angle from this rotation,

        1/h int theta(t) - theta(0) - Omega_g t dt

    so that its mean phase is right. Otherwise the unbalance would lead or lag in every step of a run-up.
    """
    spin = piece_of(matrices).spin
    speed, gain = (spin[1, 3] - spin[1, 0]) / h, (spin[0, 3] - spin[0, 0]) / h
    ahead = -0.5 * h * grid_speed(matrices, index)
    for point in range(1, N_LOBATTO):
        ahead += LOBATTO_WEIGHTS[point] * (spin[1, point] - spin[1, 0])
    return unbalance_direction(theta + ahead, speed, gain)


@kernel
def complete_forces(matrices: StepMatrices) -> None:
    """Write the solved node forces to x."""
    piece = piece_of(matrices)
    units = piece.magnets.shape[0]
    first = piece.x.shape[0] - units
    for unit in range(units):
        piece.x[first + unit] = piece.magnets[unit] + piece.contact[unit]


@kernel
def end_piece(w: Workspace, matrices: StepMatrices, level: int, index: float, h: float) -> bool:
    """Write the state at the end of the piece to z_new, with journals on their circles; return False if this fails."""
    piece, stages = piece_of(matrices), stages_of(w.stages)
    z_new, n, ends = stages.z_new, int(matrices.sizes[0].n), piece.ends
    around = levels_around(matrices, level, index)
    _combine(matrices, piece.x, around.low.P, around.high.P, around.share, ends[0], ends[1], 0, 2 * n)
    copy(stages.z, z_new)
    copy(ends[0, :n], z_new)
    copy(ends[0, n:], z_new[w.n :])
    end_rotations(w, matrices, index, h)
    return not is_any_constrained(w.sites) or put_on_circles(w, z_new[: w.n])
