"""Growth, due to friction, of the whirl of a rotor that rests on a face and has no other support.

If the whole ring of a face touches and spins fast against its seat, its forces are linear in the tilt u of the shaft at
the face and in the velocity v of the face. Both are written as complex numbers x + i y. Let k_t = k R^2/2 and d_t = d
R^2/2. Let n be 1 if the seat pushes the rotor towards larger z, and -1 otherwise. At the slip speed omega of the ring,

    moment  -k_t u - d_t u' - n N h u,    force  -i n mu sgn(omega) (k_t u + d_t u')/R - mu N v/(2 |omega| R)     (1)

act on the shaft (`rotor_contact.contact.faces`). The slip drives the whirl. If the face turns a race, and friction
exceeds the drag M of the balls in this race, the slip ends after

    t = J_r |omega|/(mu N R - M)                                                                                  (2)

The growth is the largest real part of the poles. Nothing but friction holds the rotor sideways, so a cross coupling
lets it drift off without friction, too. With a state matrix A + mu F, a pole and its eigenvectors x and y satisfy

    lambda = y* A x/(y* x) + mu y* F x/(y* x)                                                                     (3)

Friction drives a motion if the second term is more than half of its growth. Only such motions count as whirl.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig

from amb_analysis.linear.linear_source import LinearSource
from amb_cosim.results.component_names import PLANT
from array_types import Array, Complex
from fmi_export.parts import part
from rotor_contact.contact.faces import damping_of
from rotor_contact.shaft.structure import FACE_PLACE, ROWS_OF_FACE, rows_of_faces, structure_of

ENOUGH = math.log(20.0)  # of growth times its duration: a whirl of 5 % of the clearance then fills it
MOST, STEPS = 1.0, 200  # largest friction coefficient considered, and coefficients tried up to it
SHARE = 0.5  # of the growth of a motion, above which friction drives it
ROUNDING = 1e-6  # of the fastest pole, below which a real part is that of a motion that neither grows nor decays


@dataclass(frozen=True)
class FaceWhirl:
    """Whirl of a rotor on a face: growth (1/s), and time (s) until the race turns with the rotor (may be infinite)."""

    growth: float
    follows_after: float

    @property
    def is_driven(self) -> bool:
        """Whether the whirl grows twentyfold before the race turns with the rotor."""
        return self.growth > 0.0 and self.growth * self.follows_after >= ENOUGH


@dataclass(frozen=True)
class StandingRotor:
    """A rotor with unpowered bearings that rests on a face at a spin speed.

    A
        State matrix of the rotor without contact, for (q, v) along x and y, shape (2 m, 2 m) for m coordinates q.
    mass
        Mass of the rotor (kg).
    rows
        Rows that give x, y and the slopes x', y' of the shaft at the face from q, then rows of accelerations due to
        unit forces and moments, shape (8, m).
    side
        The sign n in (1).
    height
        Height of the face above the centre of mass (m).
    stiffness
        Stiffness k of the face (N/m).
    restitution
        Coefficient of restitution.
    radius
        Radius R of the ring (m).
    slip
        Slip speed omega (rad/s).
    load
        Normal force N (N).
    race_inertia
        Moment of inertia J_r of the race (kg m^2); 0 for a seat that does not turn.
    race_drag
        Drag M of the balls (N m).
    """

    A: Array
    mass: float
    rows: Array
    side: float
    height: float
    stiffness: float
    restitution: float
    radius: float
    slip: float
    load: float
    race_inertia: float
    race_drag: float

    def whirl(self, mu: float, stiffer: float = 1.0) -> FaceWhirl:
        """Return the whirl at a friction coefficient, with `stiffer` times the stiffness of the face."""
        return FaceWhirl(self._growth(mu, stiffer), self._follows_after(mu))

    @property
    def drift(self) -> float:
        """Growth (1/s) of the fastest motion that grows without friction, or 0 if none does."""
        growing = _growing(_poles(self._on_face(0.0, 1.0)))
        return float(growing.real.max(initial=0.0))

    @property
    def topples(self) -> bool:
        """Whether the face is too soft or too small to hold the rotor upright if it does not spin."""
        return 0.5 * self.stiffness * self.radius**2 + self.side * self.load * self.height < 0.0

    def least_driving(self, stiffer: float = 1.0) -> float:
        """Return the smallest friction coefficient that drives the whirl, or `MOST` if none up to `MOST` drives it."""
        tried = np.linspace(0.0, MOST, STEPS + 1)[1:]
        driven = next((k for k, mu in enumerate(tried) if self.whirl(float(mu), stiffer).is_driven), None)
        if driven is None:
            return MOST
        high, low = float(tried[driven]), float(tried[driven] - MOST / STEPS)
        for _ in range(20):
            middle = 0.5 * (low + high)
            low, high = (low, middle) if self.whirl(middle, stiffer).is_driven else (middle, high)
        return high

    def _growth(self, mu: float, stiffer: float) -> float:
        A = self._on_face(mu, stiffer)
        if not _growing(_poles(A)).size:
            return 0.0
        friction = A - self._on_face(0.0, stiffer)
        poles, left, right = eig(A, left=True)
        growths = [
            float(poles[j].real)
            for j in np.flatnonzero(np.isin(poles, _growing(poles)))
            if (left[:, j].conj() @ friction @ right[:, j] / np.vdot(left[:, j], right[:, j])).real
            > SHARE * poles[j].real
        ]
        return max(growths, default=0.0)

    def _on_face(self, mu: float, stiffer: float) -> Array:
        """Return the state matrix of the rotor on the face."""
        n, k, R = self.rows.shape[1], stiffer * self.stiffness, self.radius
        d = damping_of(self.restitution, k, self.mass)
        place, lean, by_force, by_moment = (self.rows[i : i + 2] for i in (0, 2, 4, 6))
        k_t, d_t, turned = 0.5 * k * R * R, 0.5 * d * R * R, np.array([[0.0, -1.0], [1.0, 0.0]])  # i of complex numbers
        across = self.side * mu * math.copysign(1.0, self.slip) / R * by_force.T @ turned
        A = self.A.copy()
        of_lean = by_moment.T * (-k_t - self.side * self.load * self.height) - k_t * across
        A[n:, :n] += of_lean @ lean
        A[n:, n:] += (-d_t * by_moment.T - d_t * across) @ lean
        A[n:, n:] -= mu * self.load / (2.0 * abs(self.slip) * R) * by_force.T @ place
        return A

    def _follows_after(self, mu: float) -> float:
        torque = mu * self.load * self.radius - self.race_drag
        if not self.race_inertia or torque <= 0.0:
            return math.inf
        return self.race_inertia * abs(self.slip) / torque


def _poles(A: Array) -> Complex:
    return np.asarray(np.linalg.eigvals(A), dtype=complex)


def _growing(poles: Complex) -> Complex:
    """Return the poles of motions that grow."""
    return poles[poles.real > ROUNDING * float(np.abs(poles).max())]


def standing_rotor(source: LinearSource, face: int, Omega: float, load: float) -> StandingRotor:
    """Return a rotor that rests with a load (N) on the face of index `face`, at a spin speed (rad/s).

    The seat of the face is assumed to be at rest, and the mounts are assumed to be rigid. The speed must not be 0.
    """
    at_speed = source.at(Omega)
    (plant,), p, layout = at_speed.parts([PLANT]), source.parameters(PLANT), source.layout(PLANT)
    structure, of_face = structure_of(source.constants(PLANT)), layout["faces"][face]
    n, name = len(structure.K), of_face["name"]
    rows = rows_of_faces(structure).values[ROWS_OF_FACE * face :][:ROWS_OF_FACE]
    site = of_face.get("retainer") or ""
    place = part(structure.faces, 0, FACE_PLACE, structure.n_faces)[face]
    return StandingRotor(
        np.asarray(plant.law.A)[: 2 * n, : 2 * n],
        structure.mass,
        np.asarray(rows),
        float(place.side),
        float(place.height),
        p[f"{name}.stiffness"],
        p[f"{name}.restitution"],
        p[f"{name}.radius"],
        Omega,
        load,
        p.get(f"{site}.race_inertia", 0.0),
        p.get(f"{site}.race_drag", 0.0),
    )
