"""A communication step of a rotor that touches, or might touch, a face that limits its axial motion.

The axial position z is advanced first (`axial_contact`). The forces of the seats follow from z. All other motion is
then advanced under these forces: in pieces, or in substeps if the forces are not smooth. Both motions proceed in parts
that are short compared with the period of vibration on the stiffest ring, so that z and the lean of the shaft remain
consistent.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel
from rotor_contact.contact.axial_contact import move_onto_faces
from rotor_contact.contact.bodies import couple_spin
from rotor_contact.contact.compliant import is_any_compliant
from rotor_contact.contact.face_forces import collect_losses, lean_of, set_lean, set_leans, set_torques
from rotor_contact.contact.faces import Face, faces_of, penetration
from rotor_contact.contact.workspace import Workspace, energy_integrals, stages_of
from rotor_contact.forces.axial_motion import force_along, moved_along
from rotor_contact.layout import State
from rotor_contact.matrices.matrix_schedule import complete_speeds
from rotor_contact.matrices.speed_grid import place_on_grid
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.matrix_step import (
    ENDS,
    LONGER_BELOW,
    OF_TWICE_THE_LENGTH,
    REJECTED,
    angle_and_speed_after,
    choose_matrices,
    find_forces_at,
    integrate,
    is_slow,
    spin_acceleration,
    try_piece,
)
from rotor_contact.pieces.piece_energy import add_energies
from rotor_contact.shaft.structure import Structure
from rotor_contact.variables.enumerations import EVENTS, PIECES
from rotor_contact.variables.signals import Inputs, Parameters

PART, PART_AT_REST = 0.1, 0.2  # rad of the vibration on a ring that a part lasts
OF_REST = 0.1  # of the penetration at rest, by which a ring at rest may vibrate
MAX_LEVEL = 10  # of parts of half the length


@noinline_kernel
def is_near_faces(structure: Structure, p: Parameters, u: Inputs, w: Workspace, x: State, step_size: float) -> bool:
    """Return whether the rotor touches a face, or might touch one within a step."""
    records, z, n = faces_of(w.faces, w.Minv.shape[0]).records, stages_of(w.stages).z, w.n
    load, axial, mass = u.thrust[0], x.axial[0], structure.mass
    force = force_along(mass, p.scalars[0].gravity, p.thrust[0], load, axial.z)
    after, speed = moved_along(axial.z, axial.speed, force / mass, load.gradient / mass, step_size)
    way = max(abs(after - axial.z), max(abs(speed), abs(axial.speed)) * step_size)
    for k in range(records.shape[0]):
        face = records[k]
        if face.enabled == 0.0:
            continue
        u_x, u_y = lean_of(w, k, z[:n])
        rate_x, rate_y = lean_of(w, k, z[n : 2 * n])
        set_lean(face, u_x, u_y)
        reach = face.lean + face.radius * step_size * math.hypot(rate_x, rate_y)
        if face.is_pressed != 0.0 or penetration(face, axial.z) + way > -reach:
            return True
    return False


@kernel
def _is_at_rest(face: Face, mass: float, force: float, axial: np.record) -> bool:
    """Return whether a rotor under a force (N) rests, almost without vibration, on a ring that touches all around."""
    depth, rest = penetration(face, axial.z), -face.side * force / face.stiffness
    amplitude = math.hypot(depth - rest, axial.speed * math.sqrt(mass / face.stiffness))
    return bool(rest - amplitude >= face.lean and amplitude <= OF_REST * rest)


@noinline_kernel
def advance_on_faces(
    structure: Structure, p: Parameters, u: Inputs, w: Workspace, x: State, matrices: StepMatrices, step_size: float
) -> int:
    """Advance z over a step of `step_size` (s) in parts, each beginning with the axial motion; return a fault code.

    A part is advanced in pieces by the matrices if possible, and is otherwise integrated in substeps.
    """
    records, z, head = faces_of(w.faces, w.Minv.shape[0]).records, stages_of(w.stages).z, x.head[0]
    settings, mass = p.scalars[0], structure.mass
    set_leans(w, z, 0.0)
    force = force_along(mass, settings.gravity, p.thrust[0], u.thrust[0], x.axial[0].z)
    stiffest, rests = 0.0, False
    for face in records:
        stiffest = max(stiffest, face.stiffness * face.enabled)
        rests = rests or (face.is_pressed != 0.0 and _is_at_rest(face, mass, force, x.axial[0]))
    longest = PART_AT_REST if rests else PART
    level, angle = 0, step_size * math.sqrt(stiffest / mass)
    while angle > longest and level < MAX_LEVEL:
        level, angle = level + 1, 0.5 * angle
    parts = int(2.0**level)
    t = step_size / parts
    theta, Omega = w.motion.theta, w.motion.Omega
    can_use = settings.solver.exact_motion != 0.0 and choose_matrices(structure, w, matrices, x, settings, step_size)
    exact = True
    for _ in range(parts):
        set_leans(w, z, t)
        work = move_onto_faces(mass, settings.gravity, p.thrust[0], u.thrust[0], x.axial[0], records, t)
        energy_integrals(z, w.n).work += work
        set_torques(w, z, Omega, t)
        done = 0.0
        if can_use:
            done, theta, Omega = _pass_pieces(w, matrices, level, step_size, theta, Omega, head)
        if done < 1.0:
            if w.spin[0].row >= 0:
                couple_spin(w.motion, w.spin[0], theta)
            fault, theta, Omega = integrate(structure, w, settings, theta, Omega, (1.0 - done) * t, head)
            if fault != 0:
                return fault
            exact = False
        collect_losses(w)
    if can_use:
        head.method = PIECES if exact else EVENTS
    return 0


@noinline_kernel
def _pass_pieces(
    w: Workspace,
    matrices: StepMatrices,
    part_level: int,
    step_size: float,
    theta: float,
    Omega: float,
    memory: np.record,
) -> tuple[float, float, float]:
    """Advance z over a part of a step by event-free pieces of level `part_level` or of the next level, half as long.

    Returns the completed share of the part, and the angle and the speed of the rotor at the end of this share.
    """
    done, level = 0.0, max(part_level, min(int(memory.level), part_level + 1))
    while done < 1.0:
        h = 0.5**level * step_size
        outcome, roughness = _pass_piece(w, matrices, level, h, theta, Omega)
        if outcome == ENDS:
            theta, Omega = angle_and_speed_after(w, stages_of(w.stages).z, theta, Omega, h)
            done += 0.5 ** (level - part_level)
            if roughness * OF_TWICE_THE_LENGTH <= LONGER_BELOW:
                memory.level = max(level - 1.0, 0.0)
        elif roughness > 1.0 and level == part_level:
            level += 1
            memory.level = level
        else:
            break
    return done, theta, Omega


@noinline_kernel
def _pass_piece(
    w: Workspace, matrices: StepMatrices, level: int, h: float, theta: float, Omega: float
) -> tuple[int, float]:
    """Advance z over a piece of length h (s) if it has no events; return how it ended, and its roughness."""
    sizes, stages = matrices.sizes[0], stages_of(w.stages)
    if level >= sizes.n_levels or is_any_compliant(w.sites) or not is_slow(w, h):
        return REJECTED, 0.0
    are_valid, torque = find_forces_at(w, matrices, stages.z, theta, Omega)
    index = place_on_grid(matrices, Omega + 0.5 * h * spin_acceleration(w, Omega, torque))
    if not (are_valid and complete_speeds(matrices, index)):
        return REJECTED, 0.0
    never = int(sizes.n_levels)  # a piece is not cut
    outcome, share, roughness, of_damping = try_piece(w, matrices, level, index, h, 1.0, theta, Omega, torque, never)
    if outcome == REJECTED:
        return REJECTED, roughness if share == 1.0 else 0.0
    after_theta, after_Omega = angle_and_speed_after(w, stages.z_new, theta, Omega, h)
    are_valid, _ = find_forces_at(w, matrices, stages.z_new, after_theta, after_Omega)
    if not are_valid:
        return REJECTED, 0.0
    add_energies(w, matrices, h, of_damping, math.nan)
    copy(stages.z_new, stages.z)
    return ENDS, roughness
