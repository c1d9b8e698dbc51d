"""The rotor as a rigid body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from array_types import Array
from rotor_analysis.assembly import assemble
from rotor_analysis.rotor import Rotor

HELD = 1e-9  # of the largest stiffness, below which a motion is not held


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


def floating_motions(rotor: Rotor, speeds: Array) -> int:
    """Return how many of the rotor's four rigid-body motions no bearing or seal resists with stiffness at any speed.

        rank of  sum_b R_b^T K_b R_b,   R_b = [1, (z_b - z_0)/L]

    Parameters
    ----------
    rotor
        The rotor, with its bearings and seals.
    speeds
        Spin speeds (rad/s) at which tables of coefficients are read, shape (n,), n > 0.
    """
    z = np.array(rotor.shaft.nodes)
    along = (z - z.mean()) / np.ptp(z)
    ranks = []
    for Omega in speeds:
        held = np.zeros((4, 4))
        for part in (*rotor.bearings, *rotor.seals):
            at_part = np.kron([1.0, along[part.node - 1]], np.eye(2))
            held += at_part.T @ part.at(float(Omega))[0] @ at_part
        ranks.append(int(np.linalg.matrix_rank(held, tol=HELD * np.abs(held).max())) if held.any() else 0)
    return 4 - max(ranks)
