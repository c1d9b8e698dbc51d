"""The rotor as a rigid body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from array_types import Array
from rotor_analysis.assembly import assemble
from rotor_analysis.rotor import Rotor

NO_STIFFNESS = 1e-9  # of the largest stiffness; a motion with less is not resisted


@dataclass(frozen=True)
class RigidBody:
    """Mass (kg), centre of mass z (m), polar inertia, and diametral inertia about the centre of mass (kg m^2)."""

    mass: float
    centre: float
    polar_inertia: float
    diametral_inertia: float


def rigid_body(rotor: Rotor) -> RigidBody:
    """Return the mass, centre of mass and inertias, from the kinetic energy of rigid motion in the consistent model."""
    model = assemble(rotor, "consistent")
    M, G = model.M[::2, ::2], model.G[::2, 1::2]
    translation, tilt = np.zeros((2, len(M)))
    translation[::2] = 1.0
    tilt[::2], tilt[1::2] = rotor.shaft.nodes, 1.0
    mass = float(translation @ M @ translation)
    centre = float(translation @ M @ tilt) / mass
    return RigidBody(mass, centre, float(tilt @ G @ tilt), float(tilt @ M @ tilt) - mass * centre**2)


def floating_motions(rotor: Rotor, speeds: Array) -> int:
    """Return how many of the rotor's four rigid-body motions are not resisted by bearings or seals at any speed.

        4 - max rank of  sum_b R_b^T K_b R_b + T^T K_t,b T,   R_b = [1, (z_b - z_0)/L],   T = [0, 1/L]

    Parameters
    ----------
    rotor
        The rotor, with its bearings and seals.
    speeds
        Spin speeds (rad/s) at which tables of coefficients are read, shape (n,), n > 0.
    """
    z = np.array(rotor.shaft.nodes)
    relative_z = (z - z.mean()) / np.ptp(z)
    ranks = []
    for Omega in speeds:
        stiffness = np.zeros((4, 4))
        for part in (*rotor.bearings, *rotor.seals):
            at_part = np.kron([1.0, relative_z[part.node - 1]], np.eye(2))
            stiffness += at_part.T @ part.at(float(Omega))[0] @ at_part
            if part.tilting is not None:
                stiffness[2:, 2:] += part.tilting.at(float(Omega))[0] / np.ptp(z) ** 2
        ranks.append(
            int(np.linalg.matrix_rank(stiffness, tol=NO_STIFFNESS * np.abs(stiffness).max())) if stiffness.any() else 0
        )
    return 4 - max(ranks)
