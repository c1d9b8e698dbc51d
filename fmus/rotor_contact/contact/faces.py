"""A face that limits the rotor's axial motion: a thin elastic ring with friction against its seat.

            ^ z        ring of radius R, stiffness k and damping d per area of the whole ring, seat below it
            |          delta    penetration, the mean of the ring
       _____|_____     u        lean of the shaft there, dx/dz + i dy/dz; u_s is the lean of the seat's axis
      |_____|_____|    n        1 if the seat pushes the rotor to larger z, else -1
     ///////////////   N        force of the seat, a mean over a part of the step; it acts at the centre of pressure c

With a = R |u - u_s|, the part of the ring that touches lies within the angle p of the deepest point, where cos p =
-delta/a. If delta > a, the whole ring touches. The time derivative of n R (u - u_s) has the components a'_1 along the
lean and a'_2 across it. With these components, the springs and dampers of the ring give

    N     = k/pi (delta p + a sin p) + d/pi (delta' p + a'_1 sin p)                                        (1)
    N c/R = k/pi (delta sin p + a (p/2 + sin(2 p)/4)) + d/pi (delta' sin p + a'_1 (p/2 + sin(2 p)/4))
            along n (u - u_s), and d/pi a'_2 (p/2 - sin(2 p)/4) across it

The seat exerts two moments on the shaft's lean. The moment -n N c tends to align the shaft with the seat. The moment -n
N h u arises because the seat pushes at a height h above the centre of mass. If the face has the velocity v and the spin
omega relative to its seat, the friction of a ring under uniform pressure is, with rho = |v|/(|omega| R) and m = 4
rho/(1 + rho)^2,

    f = -mu N F v/|v|,    T = -mu N R (D - rho F) sgn(omega),    F = dD/drho,    D = 2 (1 + rho) E(m)/pi   (2)

However, the share |c|/R of the friction acts at the point of the rim nearest to c, against the slip of that point. This
share drives whirl. At slip velocities below `LEAST_SLIP`, the surfaces creep.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rotor_contact.contact.site_totals import places_of
from rotor_contact.shaft.products import dot
from rotor_contact.shaft.structure import FACE_PLACE, N_FACE_PLACE, REAL, ROWS_OF_FACE, Structure
from rotor_contact.variables.signals import FACE_PARAMETERS

LEAST_SLIP = 1e-3  # m/s

COLLECTED = (  # fields of `FACE` that are zero when a step begins
    ("share", np.float64),  # of a part in which the seat pushes
    ("force", np.float64),  # N (N), a mean of that time
    ("torque", np.float64),  # T (N m) on the rotor, a mean over the part
    ("f_n", np.float64),  # N (N) at the end of the part
    ("f_n_peak", np.float64),  # largest in the step (N)
    ("impulse", np.float64),  # of N (N s), in the step
    ("angular_impulse", np.float64),  # of T (N m s)
    ("loss", np.float64),  # heat of compression along the shaft (J), in a part
    ("sliding_power", np.float64),  # heat flow (W) of friction and
    ("rocking_power", np.float64),  # of compression by lean
)
RING = (  # coefficients of the moment (1) of a ring
    ("depth_moment", np.float64),  # delta sin p (m)
    ("closing_moment", np.float64),  # delta' sin p (m/s)
    ("share_along", np.float64),  # p/2 + sin(2 p)/4, and
    ("share_across", np.float64),  # p/2 - sin(2 p)/4 (rad)
)
# A face during a step: its parameters, in the order of the interface, its place, and what changes.
FACE = record(
    *((name, np.float64) for name in FACE_PARAMETERS.names or ()),
    ("side", np.float64),
    ("height", np.float64),
    ("site", np.float64),  # see `FACE_PLACE`
    ("damping", np.float64),  # N s/m
    ("mobility", np.float64),  # acceleration of the face by a unit force (1/kg), and
    ("tilt_mobility", np.float64),  # of its slope by a unit moment (1/(kg m^2))
    ("is_pressed", np.float64),  # 1 while the seat pushes
    ("lean", np.float64),  # R |u - u_s| (m) in the middle of a part, and
    ("lean_rate", np.float64),  # its rate (m/s)
    ("rise", np.float64),  # h |u|^2/2 (m), by which its lean moves the face
    ("at_start", np.float64),  # force (N) of the spring at the start of a phase, its slope (N/m) and damping (N s/m)
    ("slope", np.float64),
    ("drag", np.float64),
    ("rocking", np.float64),  # and the force (N) of its lean's rate
    *COLLECTED,
    *RING,  # means of the time of a part in which the seat pushes
    ("part_impulse", np.float64),  # integrals over a part while the seat pushes: of N (N s), and
    ("part_time", np.float64),  # of time (s)
    ("slopes", np.float64, 24),  # of forces x, y (N) and moments x, y (N m), each by x and y of lean, its rate and slip
)
FACE_COLLECTED_FROM, FACE_COLLECTED_TO = places_of(COLLECTED, FACE)
FACE_STATE = record(("is_pressed", np.float64), ("heat", np.float64))  # 1 or 0; J, so far
FACE_INTEGRALS = record(("heat", np.float64))  # J, over a step, of friction and of compression by lean
N_FACE, N_FACE_STATE, N_FACE_INTEGRALS = size_of(FACE), size_of(FACE_STATE), size_of(FACE_INTEGRALS)

FaceRecords = np.ndarray[tuple[int], np.dtype[np.record]]
Face = np.record


class Faces(NamedTuple):
    """The faces on a shaft with n degrees of freedom: their records, and their rows (see `Structure`)."""

    records: FaceRecords
    rows: Array


@views
def faces_size(n_faces: int, n: int) -> int:
    """Return how many float64 values the faces on a shaft with n degrees of freedom occupy; the number is even."""
    size = n_faces * (N_FACE + ROWS_OF_FACE * n)
    return size + size % 2


@views
def faces_of(faces: Array, n: int) -> Faces:
    """Return views into an array of `faces_size` values."""
    n_faces = faces.shape[0] // (N_FACE + ROWS_OF_FACE * n)
    return Faces(part(faces, 0, FACE, n_faces), part(faces, n_faces * N_FACE, REAL, (ROWS_OF_FACE * n_faces, n)))


@noinline_kernel
def place_faces(structure: Structure, parameters: Array, faces: Array) -> None:
    """Fill the records and rows of all faces; `parameters` is an array of numbers with one row per face."""
    n, n_faces = structure.K.shape[0], structure.n_faces
    places = part(structure.faces, 0, FACE_PLACE, n_faces)
    numbers, (records, rows) = part(faces, 0, REAL, (n_faces, N_FACE)), faces_of(faces, n)
    copy(structure.faces[n_faces * N_FACE_PLACE :], faces[n_faces * N_FACE :])
    for k in range(n_faces):
        numbers[k, :] = 0.0
        copy(parameters[k], numbers[k])
        face = records[k]
        face.side, face.height, face.site = places[k].side, places[k].height, places[k].site
        face.damping = damping_of(face.restitution, face.stiffness, structure.mass)
        face.mobility = dot(rows[8 * k], rows[8 * k + 4])
        face.tilt_mobility = dot(rows[8 * k + 2], rows[8 * k + 6])


@kernel
def damping_of(restitution: float, stiffness: float, mass: float) -> float:
    """Return the damping (N s/m) with which a mass (kg) on a spring (N/m) rebounds with this restitution.

    The mass leaves the spring when the force would begin to pull. With the damping ratio zeta = cos(a), -ln(e)/2 = a
    cot(a); beyond critical damping the functions are hyperbolic.
    """
    wanted, low, high = -0.5 * math.log(restitution), 0.0, 1.0
    while _loss(high) < wanted:
        high *= 2.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if _loss(middle) < wanted:
            low = middle
        else:
            high = middle
    damping: float = 2.0 * high * math.sqrt(stiffness * mass)
    return damping


@kernel
def _loss(zeta: float) -> float:
    """Return -ln(e)/2 of a rebound with the damping ratio zeta."""
    if zeta < 1.0 - 1e-9:
        angle = math.acos(zeta)
        return zeta * angle / math.sin(angle)
    if zeta < 1.0 + 1e-9:
        return 1.0
    root = math.sqrt(zeta * zeta - 1.0)
    return zeta * math.log(zeta + root) / root


@kernel
def penetration(face: Face, z: float) -> float:
    """Return the penetration delta (m) for a rotor at z (m) with the present rise."""
    depth: float = -face.side * (z - face.rise) - face.clearance
    return depth


@kernel
def half_of_contact(delta: float, lean: float) -> float:
    """Return half the angle (rad) over which the ring touches, at a penetration (m) and a lean (m)."""
    if delta >= lean:
        return math.pi
    if delta <= -lean:
        return 0.0
    return math.acos(-delta / lean)


@kernel
def spring_force(face: Face, delta: float, half: float) -> float:
    """Return the contribution (N) of the ring's springs to the force (1)."""
    force: float = face.stiffness / math.pi * (delta * half + face.lean * math.sin(half))
    return force


@kernel
def stored_in_face(face: Face, delta: float, lean: float) -> float:
    """Return the energy (J) of the ring's spring: k/(4 pi) times the integral of the squared penetration."""
    half = half_of_contact(delta, lean)
    square = delta * delta * half + 2.0 * delta * lean * math.sin(half)
    square += lean * lean * (0.5 * half + 0.25 * math.sin(2.0 * half))
    energy: float = 0.5 * face.stiffness / math.pi * square
    return energy


@kernel
def add_ring(face: Face, delta: float, closing: float, weight: float) -> None:
    """Add to the coefficients `RING` their values at a penetration (m) and its rate (m/s), times a weight."""
    half = half_of_contact(delta, face.lean)
    sine, of_sum, of_difference = math.sin(half), 0.5 * half, 0.25 * math.sin(2.0 * half)
    face.depth_moment += weight * delta * sine
    face.closing_moment += weight * closing * sine
    face.share_along += weight * (of_sum + of_difference)
    face.share_across += weight * (of_sum - of_difference)


@kernel
def scale_ring(face: Face, factor: float) -> None:
    """Multiply the coefficients `RING` by a factor."""
    face.depth_moment *= factor
    face.closing_moment *= factor
    face.share_along *= factor
    face.share_across *= factor


@kernel
def pressure(face: Face, u_x: float, u_y: float, rate_x: float, rate_y: float) -> tuple[float, float, float]:
    """Return N c/R (N) in x and y for a lean u (rad) and its rate (rad/s), and the heat flow (W) of the dampers.

    The coefficients `RING` are means over the time during which the seat pushes in a part of a step. A change of the
    lean within the part leaves them as they are: at the edge of the contact the ring's penetration is 0, so that a
    change of p has no effect of first order on the force of the springs. The heat flow includes only the share due to
    the lean.
    """
    R, k, d = face.side * face.radius, face.stiffness / math.pi, face.damping / math.pi
    a_x, a_y, b_x, b_y = R * (u_x - face.seat_tilt_x), R * (u_y - face.seat_tilt_y), R * rate_x, R * rate_y
    a = math.hypot(a_x, a_y)
    n_x, n_y = (a_x / a, a_y / a) if a > 0.0 else (1.0, 0.0)
    along, across = n_x * b_x + n_y * b_y, n_x * b_y - n_y * b_x
    viscous = d * (face.closing_moment + along * face.share_along)
    sideways = d * across * face.share_across
    total = k * (face.depth_moment + a * face.share_along) + viscous
    return (
        n_x * total - n_y * sideways,
        n_y * total + n_x * sideways,
        viscous * along + sideways * across,
    )


@kernel
def eccentricity(force: float, p_x: float, p_y: float) -> tuple[float, float]:
    """Return c/R (1) from N and N c/R (N), limited to points within the ring."""
    largest = max(force, math.hypot(p_x, p_y))
    return (p_x / largest, p_y / largest) if largest > 0.0 else (0.0, 0.0)


@kernel
def friction_of_ring(rho: float) -> tuple[float, float]:
    """Return F and D - rho F of (2), that is, force/(mu N) and torque/(mu N R); for 1/rho the two are exchanged."""
    if rho > 1.0:
        torque, force = _friction_below_one(1.0 / rho)
        return force, torque
    return _friction_below_one(rho)


@kernel
def _friction_below_one(rho: float) -> tuple[float, float]:
    """Return `friction_of_ring` for rho up to 1."""
    if rho < 0.1:
        x = rho * rho
        force = rho * (0.5 + x * (0.0625 + x * (0.0234375 + x * 0.01220703125)))
        return force, 1.0 - x * (0.25 + x * (0.046875 + x * (0.01953125 + x * 0.01068115234375)))
    a, b, total, power = 1.0, (1.0 - rho) / (1.0 + rho), 0.0, 0.5
    if b < 1e-12:
        return 2.0 / math.pi, 2.0 / math.pi
    c = math.sqrt(1.0 - b * b)
    for _ in range(8):
        total += power * c * c
        a, b, c, power = 0.5 * (a + b), math.sqrt(a * b), 0.5 * (a - b), 2.0 * power
    first = 0.5 * math.pi / a  # complete elliptic integrals by the arithmetic-geometric mean
    second = first * (1.0 - total)
    D = 2.0 * (1.0 + rho) * second / math.pi
    force = 0.5 * (D + (rho - 1.0) * 2.0 * first / math.pi) / rho
    return force, D - rho * force


@kernel
def friction(
    face: Face, force: float, e_x: float, e_y: float, v_x: float, v_y: float, omega: float
) -> tuple[float, float, float]:
    """Return f_x, f_y (N) and T (N m) on the rotor: from (2), and from the share that acts at the rim.

    `e_x` and `e_y` are the components of c/R; the velocity (m/s) and the spin (rad/s) are relative to the seat.
    """
    R, share, speed = face.radius, math.hypot(e_x, e_y), math.hypot(v_x, v_y)
    around = omega * R
    slip = speed + abs(around)
    limit = face.mu * force
    if limit == 0.0 or slip == 0.0:
        return 0.0, 0.0, 0.0
    of_force, of_torque = friction_of_ring(speed / abs(around)) if around != 0.0 else (1.0, 0.0)
    against = -(1.0 - share) * limit * slip / math.sqrt(slip * slip + LEAST_SLIP * LEAST_SLIP)
    along = against * of_force / max(speed, 1e-300)
    f_x, f_y = along * v_x, along * v_y
    torque = against * of_torque * R * math.copysign(1.0, omega)
    if share > 0.0:
        n_x, n_y = e_x / share, e_y / share
        s_x, s_y = v_x - around * n_y, v_y + around * n_x
        of_rim = -share * limit / math.sqrt(s_x * s_x + s_y * s_y + LEAST_SLIP * LEAST_SLIP)
        f_x += of_rim * s_x
        f_y += of_rim * s_y
        torque += of_rim * R * (n_x * s_y - n_y * s_x)
    return f_x, f_y, torque
