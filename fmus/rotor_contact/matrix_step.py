"""A communication step by matrices, in pieces so short that their motion is smooth; a contact event ends a piece.

At a constant speed, a whole step is one product if no contact event occurs in it (`exact_motion`). Otherwise a piece
covers a step, half a step, a quarter and so on, and begins where the last one ended. If its forces are not smooth, a
shorter piece is tried; after a smooth piece, one of twice the length is tried. If a contact event occurs in a piece, or
the step ends before the piece does, the piece is cut at that time (`piece_cut`). This is possible if the piece is short
enough for a series of its motion; otherwise, shorter pieces lead up to the event. `substeps` integrates the motion
where the shortest piece cannot be solved, and wherever contact follows a force law, because the matrices do not contain
such laws.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.bodies import couple_spin, drag_slope, drive_slope, drive_torque
from rotor_contact.contact.compliant import is_any_compliant
from rotor_contact.contact.constraints import is_any_constrained
from rotor_contact.contact.face_forces import torque_on_spin
from rotor_contact.contact.site import is_constrained
from rotor_contact.contact.workspace import Workspace, stages_of, with_motion
from rotor_contact.forces.dynamics import collect_coefficients, motion_at
from rotor_contact.layout import State
from rotor_contact.matrices.matrix_schedule import (
    STEPS_BEFORE_BUILD,
    complete_speeds,
    steps_with_matrices,
    update_matrices,
)
from rotor_contact.matrices.speed_grid import note_use, place_on_grid
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece import advance_rotations
from rotor_contact.pieces.piece_cut import cut_piece
from rotor_contact.pieces.piece_energy import (
    Damping,
    add_energies,
    damping_in_piece,
    torque_of_damping,
    with_missed,
)
from rotor_contact.pieces.piece_events import find_event
from rotor_contact.pieces.piece_solution import (
    begin_piece,
    complete_forces,
    end_piece,
    find_contact_forces,
    solve_piece,
)
from rotor_contact.pieces.site_in_piece import smooth_share
from rotor_contact.shaft.structure import Structure
from rotor_contact.substeps.contact_modes import FAULT_SINGULAR, resolve_modes
from rotor_contact.substeps.substeps import EVENT_LIMIT, SHORTEST_FLIGHT, advance, apply_impacts
from rotor_contact.variables.enumerations import EVENTS, EXACT, PIECES
from rotor_contact.whole_steps.constant_speed import follow, use_constant_speed, use_grid
from rotor_contact.whole_steps.exact_motion import take_whole_step

NO_MATRICES_YET = -1
STEPS_AHEAD = 128.0  # at a constant speed, in which the matrices of the grid are built for a speed that may change
REJECTED, ENDS, HAS_EVENT = range(3)  # result of a piece: not smooth or too long for its event; no event; an event
SERIES_REACH = 2.4  # length of a piece, short enough for a series of the motion, times the highest rate of change
TIME_TOLERANCE = 1e-12  # of a step
OF_TWICE_THE_LENGTH = 8.0  # roughness of a piece over that of its half
LONGER_BELOW = 0.4  # expected roughness, at which twice the length is tried
ROUGHEST = 8.0  # roughness of a shortest piece, at which it is still more accurate than a substep
ROUGHEST_CUT = 0.15  # of a piece that is cut: over a part, errors do not cancel as they do between collocation points
TOO_ROUGH = 2.0  # of a piece whose forces do not settle
FASTEST_DRIVE = 0.3  # largest length of a piece times the rate at which drive and drag change the speed


@noinline_kernel
def advance_by_matrices(
    structure: Structure, w: Workspace, matrices: StepMatrices, x: State, settings: np.record, step_size: float
) -> int:
    """Advance z over a communication step; return a fault code, or NO_MATRICES_YET with z unchanged.

    `State.head.method` records whether the step was one piece, several pieces, or partly integrated. `settings` are
    the single parameters.
    """
    if is_any_compliant(w.sites) or not choose_matrices(structure, w, matrices, x, settings, step_size):
        return NO_MATRICES_YET
    x.head[0].method = EXACT
    if take_whole_step(w, matrices, step_size):
        return 0
    fault: int = _advance_by_pieces(structure, w, matrices, settings, step_size, x.head[0])
    return fault


@noinline_kernel
def _advance_by_pieces(
    structure: Structure, w: Workspace, matrices: StepMatrices, settings: np.record, step_size: float, memory: np.record
) -> int:
    """Advance z by pieces where the matrices are complete; return a fault code."""
    sizes, stages = matrices.sizes[0], stages_of(w.stages)
    z, z_new, finest, series = stages.z, stages.z_new, int(sizes.n_levels) - 1, series_level(matrices)
    shortest = SHORTEST_FLIGHT * 0.5**finest * step_size
    theta, Omega = w.motion.theta, w.motion.Omega
    are_valid, torque = find_forces_at(w, matrices, z, theta, Omega)
    # shares of the step: the part done, and that before which no event is expected; the least level of the next piece
    done, next_event, least_level, n_events = 0.0, 1.0, 0, 0
    while done < 1.0 - TIME_TOLERANCE:
        left, compliant = 1.0 - done, is_any_compliant(w.sites)
        level = max(int(memory.level) if is_any_constrained(w.sites) else 0, least_level)
        level = _level_for(left, next_event - done, level, finest, series)
        can_solve = not compliant and are_valid and n_events <= EVENT_LIMIT and is_slow(w, 0.5**finest * step_size)
        while can_solve and not is_slow(w, 0.5**level * step_size):
            level += 1
        h = 0.5**level * step_size
        latest = min(left * 2.0**level, 1.0)
        index = place_on_grid(matrices, Omega + 0.5 * latest * h * spin_acceleration(w, Omega, torque))
        if can_solve and complete_speeds(matrices, index):
            outcome, share, roughness, of_damping = try_piece(
                w, matrices, level, index, h, latest, theta, Omega, torque, series
            )
            if outcome != REJECTED:
                new_theta, new_Omega = angle_and_speed_after(w, z_new, theta, Omega, share * h)
                valid_after, after = find_forces_at(w, matrices, z_new, new_theta, new_Omega)
                ends_in_tension = outcome == ENDS and share == 1.0 and not valid_after and level < finest
                if ends_in_tension or not complete_speeds(matrices, place_on_grid(matrices, new_Omega)):
                    outcome, share, roughness = REJECTED, 1.0, TOO_ROUGH
                    are_valid, torque = find_forces_at(w, matrices, z, theta, Omega)
            if outcome != REJECTED:
                add_energies(w, matrices, share * h, of_damping, math.nan)
                copy(z_new, z)
                theta, Omega, torque, are_valid = new_theta, new_Omega, after, True
                done, least_level = done + share * 0.5**level, 0
                if level > 0 or outcome == HAS_EVENT:
                    memory.method = max(memory.method, PIECES)
                if outcome == HAS_EVENT or not valid_after:
                    n_events, next_event = n_events + 1, 1.0
                    fault = _pass_event(structure, w, theta, Omega, int(settings.contact.impact_law), shortest)
                    if fault != 0:
                        return fault
                    theta, Omega = angle_and_speed_after(w, z, theta, Omega, 0.0)
                    are_valid, torque = find_forces_at(w, matrices, z, theta, Omega)
                elif level == int(memory.level) and roughness * OF_TWICE_THE_LENGTH <= LONGER_BELOW:
                    memory.level = max(level - 1.0, 0.0)
                continue
            if level < finest:
                if share < 1.0:
                    next_event = done + share * 0.5**level
                    least_level = level + 1 if level >= series else 0
                else:
                    least_level = int(level_for(level, roughness, finest + 1))
                    memory.level = float(least_level)
                continue
        length = left if not can_solve and are_valid else min(left, 0.5 ** (level if are_valid else finest))
        fault, theta, Omega = integrate(structure, w, settings, theta, Omega, length * step_size, memory)
        if fault != 0:
            return fault
        memory.method = EVENTS
        memory.level = float(finest) if is_any_constrained(w.sites) else 0.0
        done, next_event, least_level = done + length, 1.0, 0
        are_valid, torque = find_forces_at(w, matrices, z, theta, Omega)
    return 0


@kernel
def integrate(
    structure: Structure, w: Workspace, settings: np.record, theta: float, Omega: float, t: float, memory: np.record
) -> tuple[int, float, float]:
    """Advance z over a time t (s) in substeps; return a fault code, and angle and speed of the rotor afterwards."""
    part = motion_at(w.motion, theta, Omega)
    collect_coefficients(structure, part)
    fault = advance(with_motion(w, part), settings, t, memory)
    theta, Omega = angle_and_speed_after(w, stages_of(w.stages).z, theta, Omega, t)
    return fault, theta, Omega


@inlined_kernel
def choose_matrices(
    structure: Structure, w: Workspace, matrices: StepMatrices, x: State, settings: np.record, step_size: float
) -> bool:
    """Build and choose the matrices of a step, for a constant speed or on the grid; return whether they can be used.

    At a constant speed, matrices of the grid are built in advance: within `STEPS_AHEAD` steps for a speed that may
    change, and sooner for a spin that may be released.
    """
    motion, key, constant, speed = w.motion, x.matrices_key, x.constant, x.constant.speed[0]
    is_prescribed = w.spin[0].row < 0
    is_same, n_steps = steps_with_matrices(motion, w.sites, step_size, key, x.head[0])
    is_constant = is_prescribed and motion.Omega_dot == 0.0
    follow(motion, is_constant, is_same, constant, x.head[0])
    is_constant = is_constant and motion.Omega == speed.Omega and is_same
    may_turn = is_prescribed and settings.spin.free != 0.0
    share, is_known = min(n_steps / STEPS_BEFORE_BUILD, 1.0), is_constant and speed.is_known != 0.0
    use_grid(matrices)
    can_use = False
    needs_grid = not is_constant or may_turn or (not is_known and share == 1.0 and speed.uses_grid != 0.0)
    is_ahead = is_known and is_prescribed and speed.n_grid < STEPS_AHEAD
    if share == 0.0:
        speed.n_grid = 0.0
    elif is_ahead and not needs_grid:
        speed.n_grid += 1.0
    if share > 0.0 and (needs_grid or is_ahead):
        ahead = share if needs_grid else min(share, speed.n_grid / STEPS_AHEAD)
        can_use = update_matrices(structure, motion, w.sites, key, matrices, ahead)
    if is_constant and use_constant_speed(structure, motion, w.sites, key, matrices, constant):
        return True
    if can_use:
        speed.uses_grid = 1.0
    return can_use


@inlined_kernel
def try_piece(
    w: Workspace,
    matrices: StepMatrices,
    level: int,
    index: float,
    h: float,
    latest: float,
    theta: float,
    Omega: float,
    torque: float,
    first_cut: int,
) -> tuple[int, float, float, Damping]:
    """Solve a piece of length h (s) up to its share `latest` or an earlier event; write the state there to z_new.

    Returns how and after which share the piece ended, the roughness of its forces, and heat and work of damping. A
    piece that has to be cut is rejected if its level is less than `first_cut`. In that case, no event occurs before the
    returned share.
    """
    note_use(matrices, level, index)
    nothing = Damping(0.0, 0.0, 0.0)
    begin_piece(w, matrices, level, index)
    if not solve_piece(w, matrices, level, index, h, theta, Omega, torque):
        return REJECTED, 1.0, TOO_ROUGH, nothing
    share, roughness = smooth_share(w, matrices, h)
    if roughness > (1.0 if level + 1.0 < matrices.sizes[0].n_levels else ROUGHEST):
        return REJECTED, 1.0, roughness, nothing
    complete_forces(matrices)
    if share < latest or latest < 1.0:
        if level < first_cut or (roughness > ROUGHEST_CUT and level + 1.0 < matrices.sizes[0].n_levels):
            return REJECTED, share, roughness, nothing
        n_terms, event = find_event(w, matrices, index, h, share, latest)
        if n_terms == 0:
            return REJECTED, share, roughness, nothing
        has_event = event <= latest
        if has_event or latest < 1.0:
            end = event if has_event else latest
            of_part = cut_piece(w, matrices, index, n_terms, h, end, has_event)
            return HAS_EVENT if has_event else ENDS, end, roughness, of_part
    of_damping = damping_in_piece(w, matrices, level, index)
    if w.spin[0].row >= 0 and w.motion.is_damped:  # its torque so far is that at the start
        advance_rotations(w, matrices, h, of_damping.impulse / h)
    if not end_piece(w, matrices, level, index, h):
        return REJECTED, 1.0, TOO_ROUGH, nothing
    if matrices.sizes[0].powered == 2.0 and index > math.floor(index):
        of_damping = with_missed(w, matrices, index, h, of_damping)
    return ENDS, 1.0, roughness, of_damping


@noinline_kernel
def _pass_event(structure: Structure, w: Workspace, theta: float, Omega: float, law: int, shortest: float) -> int:
    """Apply impacts at z and find the modes that the sites have afterwards; return a fault code.

    Flights shorter than `shortest` (s) count as sustained contact.
    """
    part = motion_at(w.motion, theta, Omega)
    collect_coefficients(structure, part)
    after = with_motion(w, part)
    if w.spin[0].row >= 0:
        couple_spin(part, w.spin[0], theta)
    if not apply_impacts(after, Omega, law, 1.0):
        return FAULT_SINGULAR
    fault: int = resolve_modes(after, 0.0, shortest)
    return fault


@kernel
def series_level(matrices: StepMatrices) -> int:
    """Return the first level whose pieces are short enough for their series (`piece_series`)."""
    level, reach = 0, matrices.sizes[0].reach
    while reach > SERIES_REACH:
        level += 1
        reach *= 0.5
    return level


@kernel
def _level_for(rest: float, clear: float, level: int, last: int, series: int) -> int:
    """Return the level, from `level` to `last`, of the next piece, where `rest` is the remaining share of the step.

    No piece is longer than necessary. A piece that has to be cut, at the end of the step or on an event, must be short
    enough for its series, which begins at the level `series`. An event is expected after the share `clear` at the
    earliest.
    """
    while level < last and 0.5 ** (level + 1) >= rest * (1.0 - TIME_TOLERANCE):
        level += 1
    while level < last and level < series and 0.5**level > min(rest, clear) + TIME_TOLERANCE:
        level += 1
    return level


@kernel
def level_for(level: int, roughness: float, n_levels: int) -> float:
    """Return which of `n_levels` levels probably has smooth pieces if a piece of `level` has this roughness."""
    level += 1
    while roughness > OF_TWICE_THE_LENGTH and level < n_levels - 1:
        roughness /= OF_TWICE_THE_LENGTH
        level += 1
    return float(level)


@kernel
def find_forces_at(w: Workspace, matrices: StepMatrices, z: Array, theta: float, Omega: float) -> tuple[bool, float]:
    """Find the contact forces at z; return whether they are valid, and the torque of damping on a free spin."""
    index = place_on_grid(matrices, Omega)
    if not complete_speeds(matrices, index):
        return False, 0.0
    torque = torque_of_damping(w, Omega, z)
    return find_contact_forces(w, matrices, z, index, theta, Omega, torque), torque


@kernel
def is_slow(w: Workspace, h: float) -> bool:
    """Return whether drive, drag and races change the speeds only slightly over a piece of length h (s).

    A race that is at rest and that nothing touches stays at rest.
    """
    spin, v = w.spin[0], stages_of(w.stages).z[w.n :]
    if spin.row >= 0 and not h * drive_slope(spin) <= FASTEST_DRIVE * spin.inertia:
        return False
    for site in w.sites:
        can_turn = site.race >= 0 and (is_constrained(site) or v[site.race] != 0.0)
        if can_turn and not h * drag_slope(site, 0.0) <= FASTEST_DRIVE * site.race_inertia:
            return False
    return True


@kernel
def spin_acceleration(w: Workspace, Omega: float, torque: float) -> float:
    """Return the acceleration (rad/s^2) of the spin: prescribed, or due to all torques (N m) but the unbalance's.

    `torque` is that of rotating damping, and the sites contain the contact forces. The matrices of a piece are those
    of the speed that the spin has in its middle. With the speed at its start, the shaft would lose
    (Omega(h) - Omega(0))/2 times the impulse of the damping more or less than the spin supplies.
    """
    spin = w.spin[0]
    if spin.row < 0:
        return w.motion.Omega_dot
    torque += drive_torque(spin, Omega) - spin.drag * Omega + torque_on_spin(w)
    for site in w.sites:
        if is_constrained(site):
            torque += site.f_t * site.journal_radius
    return torque / spin.inertia


@kernel
def angle_and_speed_after(w: Workspace, z: Array, theta: float, Omega: float, h: float) -> tuple[float, float]:
    """Return the angle (rad) and speed (rad/s) after a time h (s): prescribed, or from the state z at that time."""
    row = w.spin[0].row
    if row >= 0:
        return z[row], z[w.n + row]
    gain = w.motion.Omega_dot * h
    return theta + (Omega + 0.5 * gain) * h, Omega + gain
