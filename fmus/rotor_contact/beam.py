"""One-plane matrices of a Timoshenko beam element.

Degrees of freedom of an element of length L: (w_1, w_1', w_2, w_2') in one plane, with the slope w' = dw/dz as
rotation. With slopes, both planes of an axisymmetric rotor have the same matrices, and r = x + i y obeys

    M r'' - i Omega G_1 r' + K r = f
"""

from __future__ import annotations

import numpy as np

from fmi_export.model import Array
from rotor_contact.rotor import Shaft


def stiffness(shaft: Shaft, length: float) -> Array:
    """Bending stiffness with shear deformation.

    Phi = 12 E I / (kappa G A L^2) with Cowper's kappa = 6 (1 + nu) / (7 + 6 nu) for a solid circle.

    Parameters
    ----------
    shaft
        Section and material.
    length
        Element length L (m).

    Returns
    -------
    array, shape (4, 4)
        Stiffness in N/m, N/rad, N m/rad.
    """
    nu = shaft.poissons_ratio
    kappa = 6.0 * (1.0 + nu) / (7.0 + 6.0 * nu)
    bending = shaft.youngs_modulus * shaft.second_moment
    phi = 12.0 * bending / (kappa * shaft.shear_modulus * shaft.area * length**2)
    a, b, c, d = 12.0, 6.0 * length, (4.0 + phi) * length**2, (2.0 - phi) * length**2
    shape = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]])
    return bending / ((1.0 + phi) * length**3) * shape


def consistent_translational_mass(shaft: Shaft, length: float) -> Array:
    """Translational mass from cubic Hermite functions (Nelson and McVaugh 1976), shape (4, 4), kg and kg m."""
    n = length
    shape = np.array(
        [
            [156.0, 22 * n, 54.0, -13 * n],
            [22 * n, 4 * n**2, 13 * n, -3 * n**2],
            [54.0, 13 * n, 156.0, -22 * n],
            [-13 * n, -3 * n**2, -22 * n, 4 * n**2],
        ]
    )
    return shaft.density * shaft.area * length / 420.0 * shape


def consistent_rotary_inertia(shaft: Shaft, length: float) -> Array:
    """Rotary inertia from cubic Hermite functions (Nelson and McVaugh 1976), shape (4, 4); G_1 is twice this."""
    n = length
    shape = np.array(
        [
            [36.0, 3 * n, -36.0, 3 * n],
            [3 * n, 4 * n**2, -3 * n, -(n**2)],
            [-36.0, -3 * n, 36.0, -3 * n],
            [3 * n, -(n**2), -3 * n, 4 * n**2],
        ]
    )
    return shaft.density * shaft.second_moment / (30.0 * length) * shape


def diagonal_mass(shaft: Shaft, length: float) -> tuple[Array, Array]:
    """Mass and polar inertia shared equally by the two nodes, without an m L^2 term.

    Returns
    -------
    mass, gyroscopic
        Shape (4, 4) each: rho A L / 2 on translations and rho I L / 2 on rotations; polar inertia rho I L on rotations.
    """
    translation = shaft.density * shaft.area * length / 2.0
    rotation = shaft.density * shaft.second_moment * length / 2.0
    mass = np.diag([translation, rotation, translation, rotation])
    gyroscopic = np.diag([0.0, 2.0 * rotation, 0.0, 2.0 * rotation])
    return mass, gyroscopic
