"""The rotor as a rigid body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rotor_analysis.assembly import assemble
from rotor_analysis.rotor import Rotor


@dataclass(frozen=True)
class RigidBody:
    """Mass (kg), centre of mass z (m), polar inertia, and diametral inertia about the centre of mass (kg m^2)."""

    mass: float
    centre: float
    polar_inertia: float
    diametral_inertia: float


def rigid_body(rotor: Rotor) -> RigidBody:
    """Return mass, centre of mass and inertias, from the kinetic energy of rigid motion in the consistent model."""
    model = assemble(rotor, "consistent")
    M, G = model.M[::2, ::2], model.G[::2, 1::2]
    along, turning = np.zeros((2, len(M)))
    along[::2] = 1.0
    turning[::2], turning[1::2] = rotor.shaft.nodes, 1.0
    mass = float(along @ M @ along)
    centre = float(along @ M @ turning) / mass
    return RigidBody(mass, centre, float(turning @ G @ turning), float(turning @ M @ turning) - mass * centre**2)
