"""A communication step of a rotor that touches faces along its shaft, or may touch one.

z moves first (`axial_contact`), then all else by substeps, under the force of the seats that z gives. Both happen in
parts that are short against the vibration on the stiffest ring, so that z and the lean of the shaft know each other.
"""

from __future__ import annotations

import math

from fmi_export.jit import noinline_kernel
from rotor_contact.contact.axial_contact import move_onto_faces
from rotor_contact.contact.bodies import couple_spin
from rotor_contact.contact.face_forces import collect_losses, lean_of, set_lean, set_leans, set_torques
from rotor_contact.contact.faces import faces_of, penetration
from rotor_contact.contact.workspace import Workspace, energy_integrals, stages_of, with_motion
from rotor_contact.forces.axial_motion import force_along, moved_along
from rotor_contact.forces.dynamics import collect_coefficients, motion_at
from rotor_contact.layout import State
from rotor_contact.matrix_step import angle_and_speed_after
from rotor_contact.shaft.structure import Structure
from rotor_contact.substeps.substeps import advance
from rotor_contact.variables.signals import Inputs, Parameters

PART = 0.1  # rad of the vibration on a ring that a part lasts
MAX_PARTS = 1000


@noinline_kernel
def is_near_faces(
    structure: Structure, parameters: Parameters, inputs: Inputs, w: Workspace, x: State, step_size: float
) -> bool:
    """Return whether the rotor touches a face, or might within a step."""
    records, z, n = faces_of(w.faces, w.Minv.shape[0]).records, stages_of(w.stages).z, w.n
    p, u, axial = parameters.thrust[0], inputs.thrust[0], x.axial[0]
    force = force_along(structure.mass, parameters.scalars[0].gravity, p, u, axial.z)
    mass = structure.mass
    after, speed = moved_along(axial.z, axial.speed, force / mass, u.gradient / mass, step_size)
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


@noinline_kernel
def advance_on_faces(
    structure: Structure,
    parameters: Parameters,
    inputs: Inputs,
    w: Workspace,
    x: State,
    law: int,
    step_size: float,
) -> int:
    """Advance z over a step of `step_size` (s) in parts, the motion along the shaft first; return a fault code."""
    records, z, head, solver = (
        faces_of(w.faces, w.Minv.shape[0]).records,
        stages_of(w.stages).z,
        x.head[0],
        parameters.scalars[0].solver,
    )
    stiffest = 0.0
    for face in records:
        stiffest = max(stiffest, face.stiffness * face.enabled)
    parts = min(max(math.ceil(step_size * math.sqrt(stiffest / structure.mass) / PART), 1), MAX_PARTS)
    t = step_size / parts
    theta, Omega, gravity = w.motion.theta, w.motion.Omega, parameters.scalars[0].gravity
    for _ in range(parts):
        motion = motion_at(w.motion, theta, Omega)
        collect_coefficients(structure, motion)
        during = with_motion(w, motion)
        if w.spin[0].row >= 0:
            couple_spin(motion, w.spin[0], theta)
        set_leans(during, z, t)
        work = move_onto_faces(structure.mass, gravity, parameters.thrust[0], inputs.thrust[0], x.axial[0], records, t)
        energy_integrals(z, w.n).work += work
        set_torques(during, z, Omega, t)
        fault = advance(during, solver, law, t, head)
        if fault != 0:
            return fault
        collect_losses(during)
        theta, Omega = angle_and_speed_after(w, z, theta, Omega, t)
    return 0
