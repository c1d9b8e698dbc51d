"""Forces of the faces on the shaft, on its spin and on the retainers on which the faces land; heat of the faces.

In each part of a step, the force of the seat follows from the motion along the shaft. The torque of friction follows
from the state at the beginning of the part; it is limited so that the slip does not end within the part. The centre of
pressure and the friction across the shaft follow the lateral motion.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.jit import inlined_kernel, kernel, noinline_kernel
from fmi_export.model import Array
from rotor_contact.contact.faces import (
    LEAST_SLIP,
    Face,
    add_ring,
    eccentricity,
    faces_of,
    friction,
    penetration,
    pressure,
    scale_ring,
    stored_in_face,
)
from rotor_contact.contact.workspace import Workspace, energy_integrals, face_integrals, site_integrals, stages_of
from rotor_contact.forces.dynamics import spin_coupling
from rotor_contact.shaft.products import dot

LEAST_LEAN = 1e-6  # of the clearance; a smaller lean counts as none
RESOLUTION = 0.2  # of the fastest time constant of a pressed face; a substep is no longer
OF_CREEP = 0.5  # the same of the creep under friction, which only has to decay


class FaceMotion(NamedTuple):
    """Lean (rad) of the shaft at a face, and its rate (rad/s); velocity (m/s) and spin (rad/s) relative to the seat."""

    u_x: float
    u_y: float
    rate_x: float
    rate_y: float
    v_x: float
    v_y: float
    omega: float


class FaceForces(NamedTuple):
    """Forces (N) and moments (N m) of a seat on the shaft, and heat flows (W) due to friction and to the lean.

    They are means over a part of a step; the torque on the spin is `Face.torque`.
    """

    f_x: float
    f_y: float
    m_x: float
    m_y: float
    sliding: float
    rocking: float


@kernel
def is_pressing(face: Face) -> bool:
    """Return whether a seat pushes in the present part of a step."""
    return bool(face.force > 0.0 and face.share > 0.0)


@inlined_kernel
def is_any_pressing(w: Workspace) -> bool:
    """Return whether any seat pushes in the present part of a step."""
    return w.faces.shape[0] > 0 and _is_any_pressing(w)


@noinline_kernel
def _is_any_pressing(w: Workspace) -> bool:
    for face in faces_of(w.faces, w.Minv.shape[0]).records:
        if is_pressing(face):
            return True
    return False


@kernel
def torque_on_race(w: Workspace, k: int) -> float:
    """Return the torque (N m) that faces exert on the race at site k."""
    torque = 0.0
    if w.faces.shape[0] == 0:
        return torque
    for face in faces_of(w.faces, w.Minv.shape[0]).records:
        if face.site == k:
            torque -= face.torque
    return torque


@kernel
def torque_on_spin(w: Workspace) -> float:
    """Return the torque (N m) that faces exert on the rotor."""
    torque = 0.0
    if w.faces.shape[0] == 0:
        return torque
    for face in faces_of(w.faces, w.Minv.shape[0]).records:
        torque += face.torque
    return torque


@kernel
def forces_at(face: Face, at: FaceMotion) -> FaceForces:
    """Return the forces of a seat that pushes."""
    p_x, p_y, heat = pressure(face, at.u_x, at.u_y, at.rate_x, at.rate_y)
    e_x, e_y = eccentricity(face.force, p_x, p_y)
    f_x, f_y, _ = friction(face, face.force, e_x, e_y, at.v_x, at.v_y, at.omega)
    f_x, f_y = face.share * f_x, face.share * f_y
    pushed, arm = face.side * face.share, face.force * face.height
    return FaceForces(
        f_x,
        f_y,
        -pushed * (face.radius * p_x + arm * at.u_x),
        -pushed * (face.radius * p_y + arm * at.u_y),
        -(f_x * at.v_x + f_y * at.v_y + face.torque * at.omega),
        face.share * heat,
    )


@kernel
def face_motion(w: Workspace, k: int, z: Array, Omega: float) -> FaceMotion:
    """Return the motion of face k at z; `Omega` (rad/s) is the spin speed if it is prescribed."""
    n, m = w.n, w.Minv.shape[0]
    records, rows = faces_of(w.faces, m)
    face, v = records[k], z[n : 2 * n]
    u_x, u_y = lean_of(w, k, z[:n])
    rate_x, rate_y = lean_of(w, k, v)
    v_x, v_y, omega = dot(rows[8 * k], v[:m]), dot(rows[8 * k + 1], v[:m]), Omega
    if w.spin[0].row >= 0:
        omega = v[w.spin[0].row]
    housing = housing_below(w, face)
    if housing >= 0:
        v_x -= v[housing]
        v_y -= v[housing + 1]
    if face.site >= 0.0:
        race = w.sites[int(face.site)].race
        if race >= 0:
            omega -= v[race]
    return FaceMotion(u_x, u_y, rate_x, rate_y, v_x, v_y, omega)


@kernel
def housing_below(w: Workspace, face: Face) -> int:
    """Return the index of coordinate x of the housing that a face's friction can move, or -1 if there is none."""
    if face.site >= 0.0 and face.on_mount != 0.0:
        return int(w.sites[int(face.site)].housing)
    return -1


@kernel
def lean_of(w: Workspace, k: int, q: Array) -> tuple[float, float]:
    """Return the lean x', y' (rad) of the shaft at face k, or its rate (rad/s) if `q` contains velocities."""
    m = w.Minv.shape[0]
    rows = faces_of(w.faces, m).rows
    return dot(rows[8 * k + 2], q[:m]), dot(rows[8 * k + 3], q[:m])


@noinline_kernel
def set_leans(w: Workspace, z: Array, t: float) -> None:
    """Set the lean and rise of all faces to their values in the middle, t/2, of a part that starts from the state z."""
    n, records = w.n, faces_of(w.faces, w.Minv.shape[0]).records
    for k in range(records.shape[0]):
        u_x, u_y = lean_of(w, k, z[:n])
        rate_x, rate_y = lean_of(w, k, z[n : 2 * n])
        face = records[k]
        u_x, u_y = u_x + 0.5 * t * rate_x, u_y + 0.5 * t * rate_y
        set_lean(face, u_x, u_y)
        along = face.radius * ((u_x - face.seat_tilt_x) * rate_x + (u_y - face.seat_tilt_y) * rate_y)
        face.lean_rate = face.radius * along / face.lean if face.lean > 0.0 else 0.0


@kernel
def set_lean(face: Face, u_x: float, u_y: float) -> None:
    """Set the lean (m) and the rise (m) of a face from the lean (rad) of the shaft."""
    face.lean = face.radius * math.hypot(u_x - face.seat_tilt_x, u_y - face.seat_tilt_y)
    if face.lean < LEAST_LEAN * face.clearance:
        face.lean = 0.0
    face.rise = 0.5 * face.height * (u_x * u_x + u_y * u_y)


@noinline_kernel
def set_torques(w: Workspace, z: Array, Omega: float, t: float) -> None:
    """Set the torques of all pressed faces for a part of length t (s) that starts from the state z."""
    records, spin = faces_of(w.faces, w.Minv.shape[0]).records, w.spin[0]
    for k in range(records.shape[0]):
        face = records[k]
        face.torque = 0.0
        if not is_pressing(face):
            continue
        at = face_motion(w, k, z, Omega)
        u_x, u_y = at.u_x + 0.5 * t * at.rate_x, at.u_y + 0.5 * t * at.rate_y
        p_x, p_y, _ = pressure(face, u_x, u_y, at.rate_x, at.rate_y)
        e_x, e_y = eccentricity(face.force, p_x, p_y)
        torque = face.share * friction(face, face.force, e_x, e_y, at.v_x, at.v_y, at.omega)[2]
        mobility = spin.scale * spin.scale if spin.row >= 0 else 0.0
        if face.site >= 0.0:
            site = w.sites[int(face.site)]
            if site.race >= 0:
                mobility += 1.0 / site.race_inertia
        if mobility > 0.0:
            largest = abs(at.omega) / (mobility * t)
            torque = min(max(torque, -largest), largest)
        face.torque = torque
        face.angular_impulse += torque * t


@inlined_kernel
def apply_faces(w: Workspace, z: Array, Omega: float, a: Array) -> None:
    """Add the effect of pressed faces at z to the acceleration `a`, and store their heat flows."""
    if w.faces.shape[0] > 0:
        _apply(w, z, Omega, a)


@noinline_kernel
def _apply(w: Workspace, z: Array, Omega: float, a: Array) -> None:
    m, spin = w.Minv.shape[0], w.spin[0]
    records, rows = faces_of(w.faces, m)
    for k in range(records.shape[0]):
        face = records[k]
        face.sliding_power = face.rocking_power = 0.0
        if not is_pressing(face):
            continue
        f_x, f_y, m_x, m_y, sliding, rocking = forces_at(face, face_motion(w, k, z, Omega))
        face.sliding_power, face.rocking_power = sliding, rocking
        E = rows[8 * k + 4 : 8 * k + 8]
        g = 0.0
        if spin.row >= 0:
            p = spin_coupling(w.motion).p
            g -= face.torque
            for i in range(m):
                g += p[i] * (f_x * E[0, i] + f_y * E[1, i] + m_x * E[2, i] + m_y * E[3, i])
            g *= spin.scale
            s = spin_coupling(w.motion).s
            for i in range(m):
                a[i] += s[i] * g
            a[spin.row] -= g * spin.scale
        for i in range(m):
            a[i] += f_x * E[0, i] + f_y * E[1, i] + m_x * E[2, i] + m_y * E[3, i]
        if face.site >= 0.0:
            site, housing = w.sites[int(face.site)], housing_below(w, face)
            if housing >= 0:
                a[housing] -= site.mobility * f_x
                a[housing + 1] -= site.mobility * f_y
            if site.race >= 0:
                a[site.race] -= face.torque / site.race_inertia


@inlined_kernel
def write_face_rates(w: Workspace, Omega: float, dz: Array) -> None:
    """Add the heat and work of the faces to `dz`, the rates of all integrals."""
    if w.faces.shape[0] > 0:
        records, rates = faces_of(w.faces, w.Minv.shape[0]).records, energy_integrals(dz, w.n)
        for k in range(records.shape[0]):
            face, heat = records[k], records[k].sliding_power + records[k].rocking_power
            rates.friction_heat += face.sliding_power
            rates.impact_heat += face.rocking_power
            if w.spin[0].row < 0 and is_pressing(face):
                rates.work -= face.torque * Omega
            face_integrals(dz, w.n, w.sites.shape[0], k).heat = heat
            if face.site >= 0.0:
                site_integrals(dz, w.n, int(face.site)).heat += heat


@kernel
def add_heat(w: Workspace, k: int, z: Array, heat: float) -> None:
    """Add heat (J) of face k to its integral in z, and to that of the site on whose retainer it is."""
    face_integrals(z, w.n, w.sites.shape[0], k).heat += heat
    site = faces_of(w.faces, w.Minv.shape[0]).records[k].site
    if site >= 0.0:
        site_integrals(z, w.n, int(site)).heat += heat


@noinline_kernel
def collect_losses(w: Workspace) -> None:
    """Add the heat caused by compression along the shaft during a part of a step to the integrals in z."""
    z, records = stages_of(w.stages).z, faces_of(w.faces, w.Minv.shape[0]).records
    for k in range(records.shape[0]):
        energy_integrals(z, w.n).impact_heat += records[k].loss
        add_heat(w, k, z, records[k].loss)


@noinline_kernel
def face_limit(w: Workspace, Omega: float, longest: float) -> float:
    """Return a substep length (s), at most `longest`, that resolves all pressed faces at z."""
    limit, records, z = longest, faces_of(w.faces, w.Minv.shape[0]).records, stages_of(w.stages).z
    for k in range(records.shape[0]):
        face = records[k]
        if is_pressing(face):
            mobility = face.mobility
            if face.site >= 0.0:
                mobility += face.on_mount * w.sites[int(face.site)].mobility
            slip = max(abs(face_motion(w, k, z, Omega).omega) * face.radius, LEAST_SLIP)
            tilting = 0.5 * face.radius * face.radius * face.tilt_mobility
            fastest = math.sqrt(face.stiffness * tilting) + face.damping * tilting
            fastest += math.sqrt(
                0.5 * face.mu * face.stiffness * face.radius * math.sqrt(mobility * face.tilt_mobility)
            )
            creep = face.mu * face.force * mobility / slip
            limit = min(limit, min(RESOLUTION / fastest, OF_CREEP / max(creep, 1e-300)))
    return limit


@kernel
def stored_at_face(w: Workspace, k: int, q: Array, z: float) -> float:
    """Return the energy (J) that is stored in face k when the rotor is at z (m)."""
    face = faces_of(w.faces, w.Minv.shape[0]).records[k]
    if face.is_pressed == 0.0:
        return 0.0
    u_x, u_y = lean_of(w, k, q)
    set_lean(face, u_x, u_y)
    energy: float = stored_in_face(face, penetration(face, z), face.lean)
    return energy


@kernel
def write_face(
    w: Workspace, k: int, q: Array, v: Array, z: float, speed: float, heat: float, step_size: float, y: np.record
) -> None:
    """Write the outputs of face k for a rotor at z (m) with this axial speed (m/s); means are over `step_size` (s)."""
    face = faces_of(w.faces, w.Minv.shape[0]).records[k]
    u_x, u_y = lean_of(w, k, q)
    rate_x, rate_y = lean_of(w, k, v)
    set_lean(face, u_x, u_y)
    scale_ring(face, 0.0)
    add_ring(face, penetration(face, z), -face.side * speed, 1.0)
    p_x, p_y, _ = pressure(face, u_x, u_y, rate_x, rate_y)
    e_x, e_y = eccentricity(face.f_n, p_x, p_y) if face.is_pressed != 0.0 else (0.0, 0.0)
    y.gap = face.clearance + face.side * (z - face.rise)
    y.mode = face.is_pressed
    y.f_n = face.f_n
    y.f_n_peak = max(face.f_n_peak, face.f_n)
    y.f_n_mean = face.impulse / step_size if step_size > 0.0 else 0.0
    y.torque = face.angular_impulse / step_size if step_size > 0.0 else 0.0
    y.centre_x, y.centre_y = face.radius * e_x, face.radius * e_y
    y.heat = heat
