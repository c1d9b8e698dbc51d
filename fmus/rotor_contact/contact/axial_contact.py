"""Axial motion of a rotor against faces, in phases of linear motion; a phase ends when a face meets or leaves its seat.

In a phase, a pressed ring acts as a spring and a damper, linearised about the middle of the phase. The motion is then
(2) of `axial_motion`, with the springs and dampers of all pressed faces added. The rotor leaves a seat as soon as the
seat would have to pull it. The ring then relaxes, and its stored energy becomes heat.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel, noinline_kernel
from rotor_contact.contact.faces import (
    Face,
    FaceRecords,
    add_ring,
    half_of_contact,
    penetration,
    scale_ring,
    spring_force,
    stored_in_face,
)
from rotor_contact.forces.axial_motion import force_along, responses
from rotor_contact.shaft.lobatto import greatest_of_parabola

LONGEST_PHASE = 0.5  # rad of the rotor's vibration on a ring
FINEST = 0.125  # of the lean, by which the penetration may change in a phase while one side of the ring has lifted
MAX_PHASES = 10000  # of a part; in the last one no seat is met or left
N_HALVINGS = 60  # of a phase, to find an instant in it


class Phase(NamedTuple):
    """A phase: z (m) and velocity (m/s) at its beginning; acceleration a, w and c of equation (2)."""

    z: float
    speed: float
    a: float
    w: float
    c: float


class Moved(NamedTuple):
    """Distance travelled since the beginning of a phase (m), velocity (m/s), and integral of the distance (m s)."""

    way: float
    speed: float
    sum_of_way: float


@kernel
def _after(phase: Phase, t: float) -> Moved:
    """Return the motion after a time t (s) of a phase."""
    rate, S, C_2, C_3 = responses(phase.w, phase.c, t)
    speed, a = phase.speed, phase.a
    return Moved(speed * S + a * C_2, speed * rate + a * S, speed * C_2 + a * C_3)


@noinline_kernel
def move_onto_faces(
    mass: float,
    gravity: float,
    parameters: np.record,
    inputs: np.record,
    motion: np.record,
    faces: FaceRecords,
    t: float,
) -> float:
    """Move a rotor along its axis against faces for a time t (s); return the work (J) of all forces except the faces'.

    The record of each face receives its force, the impulse and the peak of this force, and the heat due to compression.
    """
    for face in faces:
        face.part_impulse = face.part_time = face.loss = 0.0
        scale_ring(face, 0.0)
    begin: float = motion.z
    gradient: float = inputs.gradient
    left, phases = t, 0
    while left > 0.0:
        phases += 1
        force = force_along(mass, gravity, parameters, inputs, motion.z)
        left -= _pass_phase(mass, force, gradient, motion, faces, left, phases < MAX_PHASES)
    for face in faces:
        face.impulse += face.part_impulse
        face.share = min(face.part_time / t, 1.0)
        if face.part_time > 0.0:
            face.force = face.part_impulse / face.part_time
            scale_ring(face, 1.0 / face.part_time)
        face.f_n = _force(face, motion.z, motion.speed) if face.is_pressed != 0.0 else 0.0
    way: float = motion.z - begin
    work: float = (force_along(mass, gravity, parameters, inputs, begin) + 0.5 * gradient * way) * way
    return work


@kernel
def _pass_phase(
    mass: float, force: float, gradient: float, motion: np.record, faces: FaceRecords, left: float, events: bool
) -> float:
    """Advance by a phase of at most `left` (s), which ends when a face meets or leaves its seat; return its length."""
    z: float = motion.z
    speed: float = motion.speed
    length = left
    is_free = True
    for face in faces:
        if face.is_pressed != 0.0:
            length, is_free = min(length, _longest(face, mass, z, speed)), False
    a, w, c = force / mass, gradient / mass, 0.0
    for face in faces:
        if face.is_pressed != 0.0:
            _linearise(face, z, speed, length)
            a += face.side * face.at_start / mass
            w -= face.slope / mass
            c += face.drag / mass
    phase = Phase(z, speed, a, w, c)
    if is_free:
        length = _turning(phase, length)
    elif _stays(faces, mass, phase):
        length = left
    changed = -1
    if events:
        for k in range(faces.shape[0]):
            if _changes(faces[k], phase, length):
                length = _instant(faces[k], phase, length)
                changed = k
    end = _after(phase, length)
    way = end.way
    lost = mass * (0.5 * (speed * speed - end.speed * end.speed) + (a + 0.5 * w * way) * way)
    for face in faces:
        if face.is_pressed != 0.0:
            _collect(face, phase, length, end)
            face.loss += max(lost, 0.0) * (face.drag / (mass * c) if c > 0.0 else 0.0) - face.side * face.rocking * way
    motion.z, motion.speed = z + way, end.speed
    if changed >= 0:
        face = faces[changed]
        stored = stored_in_face(face, penetration(face, motion.z), face.lean)
        face.loss += stored if face.is_pressed != 0.0 else -stored
        face.is_pressed = 1.0 - face.is_pressed
    return length


@kernel
def _longest(face: Face, mass: float, z: float, speed: float) -> float:
    """Return the length (s) of the longest phase in which the ring of a pressed face responds almost linearly."""
    longest = LONGEST_PHASE / math.sqrt(face.stiffness / mass)
    delta, rate = penetration(face, z), -face.side * speed
    if face.lean > 0.0 and rate != 0.0:
        way = FINEST * face.lean
        if rate < 0.0:
            way += max(delta - face.lean, 0.0)
        if rate < 0.0 or delta < face.lean:
            longest = min(longest, way / abs(rate))
    return longest


@kernel
def _linearise(face: Face, z: float, speed: float, length: float) -> None:
    """Linearise the spring and damper of a pressed face about the middle of its path in a phase; `length` is in s."""
    delta: float = penetration(face, z)
    stiffness: float = face.stiffness
    damping: float = face.damping
    middle = delta - face.side * speed * 0.5 * length if face.lean > 0.0 else max(delta, 0.0)
    half = half_of_contact(middle, face.lean)
    slope, rocking = stiffness * half / math.pi, damping / math.pi * math.sin(half) * face.lean_rate
    face.slope, face.drag, face.rocking = slope, damping * half / math.pi, rocking
    face.at_start = spring_force(face, middle, half) + slope * (delta - middle) + rocking


@kernel
def _force(face: Face, z: float, speed: float) -> float:
    """Return the force (N) of a seat on a ring that touches it; a negative value means that the seat would pull."""
    delta = penetration(face, z)
    half = half_of_contact(delta, face.lean)
    rate = math.sin(half) * face.lean_rate - half * face.side * speed
    force: float = spring_force(face, delta, half) + face.damping / math.pi * rate
    return force


@kernel
def _turning(phase: Phase, longest: float) -> float:
    """Return the time (s) until free motion reverses, or `longest` if it does not reverse earlier."""
    if phase.speed * _after(phase, longest).speed >= 0.0:
        return longest
    low, high = 0.0, longest
    for _ in range(N_HALVINGS):
        middle = 0.5 * (low + high)
        if phase.speed * _after(phase, middle).speed > 0.0:
            low = middle
        else:
            high = middle
    return high


@kernel
def _stays(faces: FaceRecords, mass: float, phase: Phase) -> bool:
    """Return whether a single face is pressed and vibrates too little to leave its seat or to lift on one side."""
    pressed = -1
    for k in range(faces.shape[0]):
        if faces[k].is_pressed != 0.0:
            if pressed >= 0:
                return False
            pressed = k
    w, speed = phase.w, phase.speed
    if pressed < 0 or w >= 0.0:
        return False
    face = faces[pressed]
    way = -phase.a / w  # to the position of rest
    amplitude = math.sqrt(way * way + speed * speed / -w)
    rest = penetration(face, phase.z + way)
    lowest = rest * face.stiffness - (face.stiffness + face.damping * math.sqrt(-w)) * amplitude
    return bool(rest - amplitude >= face.lean and lowest > 0.0 and face.slope == face.stiffness)


@kernel
def _push(face: Face, way: float, speed: float) -> float:
    """Return the linearised force (N) of the seat on a pressed face, at a distance (m) from the start of a phase."""
    force: float = face.at_start - face.side * (face.slope * way + face.drag * speed)
    return force


@kernel
def _changes(face: Face, phase: Phase, t: float) -> bool:
    """Return whether the face has met or left its seat at the time t (s) of a phase."""
    if face.enabled == 0.0:
        return False
    at = _after(phase, t)
    if face.is_pressed != 0.0:
        return _push(face, at.way, at.speed) < 0.0
    delta = penetration(face, phase.z + at.way)
    return bool(delta > -face.lean and _force(face, phase.z + at.way, at.speed) > 0.0)


@kernel
def _instant(face: Face, phase: Phase, length: float) -> float:
    """Return the time (s) in a phase at which the face meets or leaves its seat."""
    low, high = 0.0, length
    for _ in range(N_HALVINGS):
        middle = 0.5 * (low + high)
        if _changes(face, phase, middle):
            high = middle
        else:
            low = middle
    return high


@kernel
def _collect(face: Face, phase: Phase, length: float, end: Moved) -> None:
    """Collect the time, impulse, moment of the ring (by Simpson's rule) and largest force of a pressed face."""
    half = _after(phase, 0.5 * length)
    delta, sixth = penetration(face, phase.z), length / 6.0
    face.part_time += length
    add_ring(face, delta, -face.side * phase.speed, sixth)
    add_ring(face, delta - face.side * half.way, -face.side * half.speed, 4.0 * sixth)
    add_ring(face, delta - face.side * end.way, -face.side * end.speed, sixth)
    face.part_impulse += face.at_start * length - face.side * (face.slope * end.sum_of_way + face.drag * end.way)
    begin, middle = _push(face, 0.0, phase.speed), _push(face, half.way, half.speed)
    face.f_n_peak = max(face.f_n_peak, greatest_of_parabola(begin, middle, _push(face, end.way, end.speed)))
