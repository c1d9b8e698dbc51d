"""A communication step by matrices: pieces as long as their motion is smooth, with integrated events between them.

A piece lasts a step, half of it, a quarter and so on. If a contact event may occur in it, or a force is not smooth, a
shorter piece is tried; after a smooth one, twice its length. Where the shortest piece fails, `events` integrates over
its length; in contact under a force law, which the matrices do not know, over the rest of the step.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy, is_near, same_bits
from fmi_export.jit import kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.bodies import RACE_SPEED_SCALE
from rotor_contact.compliant import is_any_compliant
from rotor_contact.contact import is_any_constrained
from rotor_contact.dynamics import Motion, accelerations, collect_coefficients, forces
from rotor_contact.enumerations import EVENTS, EXACT, PIECES
from rotor_contact.events import advance
from rotor_contact.matrix_levels import choose_levels
from rotor_contact.matrix_rows import are_complete, build_slot, is_complete, share_of
from rotor_contact.passive_bearings import same_passive, set_passive
from rotor_contact.piece_energy import (
    ShaftDamping,
    add_energies,
    add_slope,
    damping_of_shaft,
    energy_taken,
    known_damping,
)
from rotor_contact.propagator import STEP_TOLERANCE, STEPS_BEFORE_BUILD
from rotor_contact.site import Sites
from rotor_contact.smooth_piece import begin_piece, end_piece, find_contact_forces, smooth_share, solve_piece
from rotor_contact.speed_grid import note_use, place_on_grid, spacing_for
from rotor_contact.step_matrices import MatricesKey, StepMatrices, is_for
from rotor_contact.structure import Structure
from rotor_contact.workspace import Workspace, stages_of

STEPS_PER_SPEED = 16.0  # steps that count less for every speed of the grid that is passed
FEW_SUBSTEPS = 4.0  # of a rotor without modes, that cost less than matrices
NO_MATRICES_YET = -1
OF_TWICE_THE_LENGTH = 8.0  # roughness of a piece, that of its half being 1
TOO_ROUGH = 2.0  # of a piece whose forces do not settle
FASTEST_DRIVE = 0.3  # of a piece, times how fast drive and drag change the speed


@kernel
def steps_with_matrices(
    motion: Motion, sites: Sites, step_size: float, origin: float, key: MatricesKey, memory: np.record
) -> float:
    """Return the number of steps with an unchanged key of the matrices, at most a few more than STEPS_BEFORE_BUILD.

    `key` is updated; `origin` is a speed (rad/s) of the grid. Each passed speed of the grid counts against
    `STEPS_PER_SPEED` steps, so fast speed changes are integrated: building the matrices costs as much as about thirty
    steps.
    """
    same = is_near(step_size, key.step_size[0], STEP_TOLERANCE) and key.origin[0] == origin
    if not same:
        key.step_size[0], key.origin[0] = step_size, origin
    given = forces(motion)
    for k in range(motion.bearings.shape[0]):
        if not same_passive(motion.bearings[k], key.bearings[k], 0.0):
            same = False
            set_passive(key.bearings[k], motion.bearings[k])
    for k in range(sites.shape[0]):
        same = _housing_is_unchanged(sites[k], key.sites[k]) and same
    for i in range(3):
        force = given.without_magnets if i == 0 else (given.cosine if i == 1 else given.sine)
        if not same_bits(force, key.forces[i]):
            same = False
            copy(force, key.forces[i])
    place = math.floor((motion.Omega - origin) / spacing_for(key.step_size[0]))
    moved = abs(place - float(memory.place))
    memory.place = place
    n_steps = 0.0
    if same and moved <= 1.0:
        n_steps = min(
            max(float(memory.n_matrix_steps) + 1.0 - STEPS_PER_SPEED * moved, 0.0), STEPS_BEFORE_BUILD + STEPS_PER_SPEED
        )
    memory.n_matrix_steps = n_steps
    return n_steps


@kernel
def _housing_is_unchanged(site: np.record, known: np.record) -> bool:
    """Return whether the housing of a site is unchanged; update its stored parameters."""
    moves = site.housing >= 0
    row = float(site.housing)
    same = known.row == row
    if moves:
        same = same and known.mobility == site.mobility
        same = same and known.stiffness[0] == site.mount_stiffness_x and known.stiffness[1] == site.mount_stiffness_y
        same = same and known.damping[0] == site.mount_damping_x and known.damping[1] == site.mount_damping_y
        same = same and known.base_acceleration[0] == site.base_x and known.base_acceleration[1] == site.base_y
    if not same:
        known.row, known.mobility = row, site.mobility
        known.stiffness[0], known.stiffness[1] = site.mount_stiffness_x, site.mount_stiffness_y
        known.damping[0], known.damping[1] = site.mount_damping_x, site.mount_damping_y
        known.base_acceleration[0], known.base_acceleration[1] = site.base_x, site.base_y
    return bool(same)


@kernel
def update_matrices(
    structure: Structure, motion: Motion, sites: Sites, key: MatricesKey, matrices: StepMatrices, share: float
) -> bool:
    """Build the matrices around the motion's speed up to a share; return whether they can be used.

    Then the next speed of the grid is built while the present speed approaches it.
    """
    if not is_for(matrices, key):
        collect_coefficients(structure, motion)
        choose_levels(structure, motion, sites, key, matrices)
    sizes = matrices.sizes[0]
    if sizes.n_levels == 0.0:
        return False
    index = place_on_grid(matrices, motion.Omega)
    low = float(math.floor(index))  # the type of `ahead`: for two types all that follows is compiled twice
    n_slots = 1 if index == low else 2
    for i in range(n_slots):
        part_of_it = min(max(n_slots * share - i, 0.0), 1.0)
        if part_of_it > 0.0 and not is_complete(matrices, low + i):
            build_slot(structure, motion, sites, matrices, low + i, part_of_it)
    if share < 1.0:
        return False
    beyond = index - low - 0.5
    ahead = low + 2.0 if beyond > 0.0 else low - 1.0
    if index != low and abs(beyond) > 0.1 and not is_complete(matrices, ahead):
        share = min(2.5 * abs(beyond) - 0.25, share_of(matrices, ahead) + 1.0 / STEPS_BEFORE_BUILD)
        build_slot(structure, motion, sites, matrices, ahead, min(share, 1.0))
    copy(matrices.effects[0], accelerations(motion).cosine)
    copy(matrices.effects[1], accelerations(motion).sine)
    return True


@noinline_kernel
def advance_by_pieces(
    structure: Structure,
    w: Workspace,
    matrices: StepMatrices,
    key: MatricesKey,
    solver: np.record,
    law: int,
    step_size: float,
    is_steady: bool,
    memory: np.record,
) -> int:
    """Advance z over a communication step; return a fault code, or NO_MATRICES_YET with z as it was.

    `is_steady` states whether the speed is prescribed and constant: then it is on the grid.

    `memory.method` is set to one piece, several, or partly integrated.
    """
    is_rigid = structure.K.shape[0] == structure.n_translations
    if (is_rigid and step_size <= FEW_SUBSTEPS * solver.max_substep) or is_any_compliant(w.sites):
        return NO_MATRICES_YET
    origin = w.motion.Omega if is_steady else 0.0
    share = steps_with_matrices(w.motion, w.sites, step_size, origin, key, memory) / STEPS_BEFORE_BUILD
    if share == 0.0 or not update_matrices(structure, w.motion, w.sites, key, matrices, min(share, 1.0)):
        return NO_MATRICES_YET
    sizes, stages = matrices.sizes[0], stages_of(w.stages)
    total = 2 ** (int(sizes.n_levels) - 1)
    unit = sizes.step_size / total
    at, event = 0, math.inf  # both in units; where the next event is expected
    z, n = stages.z, w.n
    theta, Omega = w.motion.theta, w.motion.Omega
    known, damping = find_forces_at(w, matrices, z, theta, Omega)
    memory.method = EXACT
    while at < total:
        yields = is_any_compliant(w.sites)
        level = _level_at(at, min(event - at, float(total - at)), int(memory.level), int(sizes.n_levels))
        length = total - at if yields else total >> level
        h = length * unit
        index = place_on_grid(matrices, Omega + 0.5 * h * w.motion.Omega_dot)
        begun, done, roughness = False, False, 0.0
        if not yields and at + length <= event and known and _is_slow(w, h) and are_complete(matrices, index):
            begun = True
            note_use(matrices, level, index)
            begin_piece(w, matrices, level, index)
            share, roughness = 1.0, TOO_ROUGH
            if solve_piece(w, matrices, level, index, h, theta, Omega, damping.torque):
                share, roughness = smooth_share(w, matrices, h)
            done = share == 1.0 and roughness <= 1.0 and end_piece(w, matrices, level, index, h)
            if share < 1.0:
                event = at + share * length
        if done:
            taken = energy_taken(matrices, level, index)
            new_theta, new_Omega = angle_and_speed_after(w, stages.z_new, theta, Omega, h)
            holds, after = find_forces_at(w, matrices, stages.z_new, new_theta, new_Omega)
            if holds:
                add_energies(w, matrices, h, taken, damping, after)
                copy(stages.z_new, z)
                theta, Omega, damping = new_theta, new_Omega, after
                at += length
                if level == int(memory.level) and roughness * OF_TWICE_THE_LENGTH <= 1.0:
                    memory.level = max(level - 1.0, 0.0)
                if level > 0:
                    memory.method = max(memory.method, PIECES)
                continue
            known, damping = find_forces_at(w, matrices, z, theta, Omega)
        if begun and level < int(sizes.n_levels) - 1:
            if not event < at + length:
                memory.level = level_for(level, roughness, int(sizes.n_levels))
            continue
        part = Motion(
            w.motion.rows,
            w.motion.bearings,
            w.motion.over_speed,
            w.motion.is_damped,
            w.motion.seals,
            theta,
            Omega,
            w.motion.Omega_dot,
        )
        collect_coefficients(structure, part)
        within = Workspace(n, w.forms, w.Minv, part, w.spin, w.sites, w.equations, w.stages, w.n_translations)
        fault = advance(within, solver, law, h, memory)
        if fault != 0:
            return fault
        memory.method = EVENTS
        memory.level = sizes.n_levels - 1.0 if is_any_constrained(w.sites) else 0.0
        theta, Omega = angle_and_speed_after(w, z, theta, Omega, h)
        at, event = at + length, math.inf
        known, damping = find_forces_at(w, matrices, z, theta, Omega)
    return 0


@kernel
def level_for(level: int, roughness: float, n_levels: int) -> float:
    """Return the level, of `n_levels`, whose pieces are likely to be smooth if one of `level` has this roughness."""
    level += 1
    while roughness > OF_TWICE_THE_LENGTH and level < n_levels - 1:
        roughness /= OF_TWICE_THE_LENGTH
        level += 1
    return float(level)


@kernel
def _level_at(at: int, room: float, level: int, n_levels: int) -> int:
    """Return the level, at least `level`, of the longest piece from `at` that ends within `room`, in units.

    A piece of 2^k units begins at a multiple of its length. If none is short enough, the shortest is returned.
    """
    length = 2 ** (n_levels - 1 - level)
    while length > 1 and (at % length != 0 or length > room):
        level += 1
        length = length // 2
    return level


@kernel
def find_forces_at(
    w: Workspace, matrices: StepMatrices, z: Array, theta: float, Omega: float
) -> tuple[bool, ShaftDamping]:
    """Find the contact forces at z; return whether they are valid, and the torque of damping with the seals' power."""
    index = place_on_grid(matrices, Omega)
    if not are_complete(matrices, index):
        return False, ShaftDamping(0.0, 0.0, 0.0, 0.0, 0.0)
    has_seals = w.motion.seals.records.shape[1] > 0
    damping = damping_of_shaft(w, Omega, z) if has_seals else known_damping(w, matrices, Omega, z)
    holds = find_contact_forces(w, matrices, z, index, theta, Omega, damping.torque)
    if has_seals:
        damping = add_slope(w, matrices, z, index, theta, Omega, damping)
    return holds, damping


@kernel
def _is_slow(w: Workspace, h: float) -> bool:
    """Return whether drive, drag and races change the speeds only slightly over a piece of length h (s)."""
    spin = w.spin[0]
    if spin.row >= 0 and not h * (spin.gain + spin.drag) <= FASTEST_DRIVE * spin.inertia:
        return False
    for site in w.sites:
        if site.race >= 0:
            slope = site.race_drag / RACE_SPEED_SCALE + site.race_viscous_drag
            if not h * slope <= FASTEST_DRIVE * site.race_inertia:
                return False
    return True


@kernel
def angle_and_speed_after(w: Workspace, z: Array, theta: float, Omega: float, h: float) -> tuple[float, float]:
    """Return angle (rad) and speed (rad/s) after a time h (s): prescribed, or those of the state z there."""
    row = w.spin[0].row
    if row >= 0:
        return z[row], z[w.n + row]
    gain = w.motion.Omega_dot * h
    return theta + (Omega + 0.5 * gain) * h, Omega + gain
