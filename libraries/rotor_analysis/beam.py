"""One-plane matrices of a Timoshenko or Rayleigh beam element, which is uniform or conical (`tapered`).

In a single plane, an element of length L has the degrees of freedom (w_1, beta_1, w_2, beta_2). Here beta is the
rotation of the section, which is the slope dw/dz minus the shear angle. Both planes of an axisymmetric rotor then have
the same matrices, and r = x + i y obeys

    M r'' - i Omega G_1 r' + K r = f
"""

from __future__ import annotations

import numpy as np

from array_types import Array
from rotor_analysis import tapered
from rotor_analysis.element import Element


def shear_parameter(element: Element) -> float:
    """Return Phi = 12 E I / (kappa G A L^2), the ratio of shear to bending flexibility; 0 in Rayleigh's theory."""
    if element.theory == "rayleigh":
        return 0.0
    shear = element.shear_coefficient * element.material.shear_modulus * element.area
    return 12.0 * element.material.youngs_modulus * element.second_moment / (shear * element.length**2)


def stiffness(element: Element) -> Array:
    """Return the bending stiffness, with shear deformation in Timoshenko's theory.

    Parameters
    ----------
    element
        Length L, section and material.

    Returns
    -------
    array, shape (4, 4)
        Stiffness in N/m, N/rad, N m/rad.
    """
    L, phi = element.length, shear_parameter(element)
    if element.is_tapered:
        return tapered.stiffness(element, phi)
    a, b, c, d = 12.0, 6.0 * L, (4.0 + phi) * L**2, (2.0 - phi) * L**2
    shape = np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]])
    return element.material.youngs_modulus * element.second_moment / ((1.0 + phi) * L**3) * shape


def consistent_translational_mass(element: Element) -> Array:
    """Return the translational mass matrix based on the element's static deflection, shape (4, 4), in kg, kg m, kg m^2.

    The shape functions are Hermite cubics for Phi = 0 (Nelson and McVaugh 1976); with shear, they are those of Nelson
    1980.
    """
    L, phi = element.length, shear_parameter(element)
    if element.is_tapered:
        return tapered.translational_mass(element, phi)
    a, b = 156.0 + 294.0 * phi + 140.0 * phi**2, (22.0 + 38.5 * phi + 17.5 * phi**2) * L
    c, d = 54.0 + 126.0 * phi + 70.0 * phi**2, (13.0 + 31.5 * phi + 17.5 * phi**2) * L
    e, f = (4.0 + 7.0 * phi + 3.5 * phi**2) * L**2, (3.0 + 7.0 * phi + 3.5 * phi**2) * L**2
    shape = np.array([[a, b, c, -d], [b, e, d, -f], [c, d, a, -b], [-d, -f, -b, e]])
    return element.material.density * element.area * L / (420.0 * (1.0 + phi) ** 2) * shape


def consistent_rotary_inertia(element: Element) -> Array:
    """Return the rotary inertia matrix based on the same deflection, shape (4, 4); G_1 is twice this matrix."""
    L, phi = element.length, shear_parameter(element)
    if element.is_tapered:
        return tapered.rotary_inertia(element, phi)
    a, b = 36.0, (3.0 - 15.0 * phi) * L
    c, d = (4.0 + 5.0 * phi + 10.0 * phi**2) * L**2, (1.0 + 5.0 * phi - 5.0 * phi**2) * L**2
    shape = np.array([[a, b, -a, b], [b, c, -b, -d], [-a, -b, a, -b], [b, -d, -b, c]])
    return element.material.density * element.second_moment / (30.0 * L * (1.0 + phi) ** 2) * shape


def diagonal_mass(element: Element) -> tuple[Array, Array]:
    """Return the lumped mass and polar inertia (half of a uniform element at each node), without an m L^2 term.

    Returns
    -------
    mass, gyroscopic
        Shape (4, 4) each. For a uniform element, the mass is rho A L / 2 for translations and rho I L / 2 for
        rotations, and the polar inertia is rho I L for rotations.
    """
    if element.is_tapered:
        (mass_1, inertia_1), (mass_2, inertia_2) = tapered.lumped(element).tolist()
        ends = np.diag([mass_1, inertia_1, mass_2, inertia_2])
        return ends, np.diag([0.0, 2.0 * inertia_1, 0.0, 2.0 * inertia_2])
    translation = element.material.density * element.area * element.length / 2.0
    rotation = element.material.density * element.second_moment * element.length / 2.0
    mass = np.diag([translation, rotation, translation, rotation])
    gyroscopic = np.diag([0.0, 2.0 * rotation, 0.0, 2.0 * rotation])
    return mass, gyroscopic
