"""One-plane matrices of a beam element, Timoshenko or Rayleigh.

Degrees of freedom of an element of length L: (w_1, w_1', w_2, w_2') in one plane, with the slope w' = dw/dz as
rotation. With slopes, both planes of an axisymmetric rotor have the same matrices, and r = x + i y obeys

    M r'' - i Omega G_1 r' + K r = f
"""

from __future__ import annotations

import numpy as np

from fmi_export.model import Array
from rotor_contact.rotor import Element


def stiffness(element: Element) -> Array:
    """Bending stiffness, with shear deformation in Timoshenko's theory.

    Phi = 12 E I / (kappa G A L^2), and Phi = 0 in Rayleigh's.

    Parameters
    ----------
    element
        Length L, section and material.

    Returns
    -------
    array, shape (4, 4)
        Stiffness in N/m, N/rad, N m/rad.
    """
    length = element.length
    bending = element.youngs_modulus * element.second_moment
    phi = 0.0
    if element.theory == "timoshenko":
        phi = 12.0 * bending / (element.shear_coefficient * element.shear_modulus * element.area * length**2)
    a, b, c, d = 12.0, 6.0 * length, (4.0 + phi) * length**2, (2.0 - phi) * length**2
    shape = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]])
    return bending / ((1.0 + phi) * length**3) * shape


def consistent_translational_mass(element: Element) -> Array:
    """Translational mass from cubic Hermite functions (Nelson and McVaugh 1976), shape (4, 4), kg and kg m."""
    n = element.length
    shape = np.array(
        [
            [156.0, 22 * n, 54.0, -13 * n],
            [22 * n, 4 * n**2, 13 * n, -3 * n**2],
            [54.0, 13 * n, 156.0, -22 * n],
            [-13 * n, -3 * n**2, -22 * n, 4 * n**2],
        ]
    )
    return element.density * element.area * n / 420.0 * shape


def consistent_rotary_inertia(element: Element) -> Array:
    """Rotary inertia from cubic Hermite functions (Nelson and McVaugh 1976), shape (4, 4); G_1 is twice this."""
    n = element.length
    shape = np.array(
        [
            [36.0, 3 * n, -36.0, 3 * n],
            [3 * n, 4 * n**2, -3 * n, -(n**2)],
            [-36.0, -3 * n, 36.0, -3 * n],
            [3 * n, -(n**2), -3 * n, 4 * n**2],
        ]
    )
    return element.density * element.second_moment / (30.0 * n) * shape


def diagonal_mass(element: Element) -> tuple[Array, Array]:
    """Mass and polar inertia shared equally by the two nodes, without an m L^2 term.

    Returns
    -------
    mass, gyroscopic
        Shape (4, 4) each: rho A L / 2 on translations and rho I L / 2 on rotations; polar inertia rho I L on rotations.
    """
    translation = element.density * element.area * element.length / 2.0
    rotation = element.density * element.second_moment * element.length / 2.0
    mass = np.diag([translation, rotation, translation, rotation])
    gyroscopic = np.diag([0.0, 2.0 * rotation, 0.0, 2.0 * rotation])
    return mass, gyroscopic
