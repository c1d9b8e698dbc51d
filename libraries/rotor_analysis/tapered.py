"""One-plane matrices of a conical beam element, by numerical integration along the element.

The displacement w = sum N_i q_i and the rotation beta = sum B_i q_i of the section are linear in q = (w_1, beta_1, w_2,
beta_2). Both follow from the static deflection of a uniform element whose section is that in the middle of the conical
element. In the integrals, the section A(s), I(s) changes along the element (Genta and Gugliotta, A conical element for
finite element rotor dynamics, 1988). Five Gauss points are exact, because the integrands are polynomials of degree 8 at
most.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from array_types import Array
from rotor_analysis.element import Element

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)
STATIONS = 0.5 * (1.0 + _POINTS)  # from 0 to 1
WEIGHTS = 0.5 * _WEIGHTS


def stiffness(element: Element, phi: float) -> Array:
    """Return the stiffness matrix, shape (4, 4): the integral of E I B' B'^T + kappa G A gamma gamma^T over z.

    gamma = w' - beta is the shear angle.
    """
    length, E = element.length, element.material.youngs_modulus
    bending = _integral(element, lambda s: E * element.second_moment_at(s) * _outer(_curvature(s, length, phi)))
    if phi == 0.0:
        return bending
    shear = element.shear_coefficient * element.material.shear_modulus
    angle = phi / (1.0 + phi) * np.array([-1.0 / length, -0.5, 1.0 / length, -0.5])
    return bending + _integral(element, lambda s: shear * element.area_at(s) * _outer(angle))


def translational_mass(element: Element, phi: float) -> Array:
    """Return the mass matrix for translation, the integral of rho A N N^T over z, shape (4, 4)."""
    density = element.material.density
    return _integral(element, lambda s: density * element.area_at(s) * _outer(_deflection(s, element.length, phi)))


def rotary_inertia(element: Element, phi: float) -> Array:
    """Return the mass matrix for rotation, the integral of rho I B B^T over z, shape (4, 4)."""
    density = element.material.density
    return _integral(
        element, lambda s: density * element.second_moment_at(s) * _outer(_rotation(s, element.length, phi))
    )


def lumped(element: Element) -> Array:
    """Return the mass (kg) of each end and its diametral inertia without an m L^2 term (kg m^2), shape (2, 2).

    rho A and rho I are distributed to the ends by the lever rule, which preserves the centre of mass.
    """
    density = element.material.density
    return _integral(
        element,
        lambda s: density * np.outer([1.0 - s, s], [element.area_at(s), element.second_moment_at(s)]),
    )


def _integral(element: Element, integrand: Callable[[float], Array]) -> Array:
    return np.asarray(element.length * sum(w * integrand(s) for s, w in zip(STATIONS, WEIGHTS, strict=True)))


def _outer(shape: Array) -> Array:
    return np.outer(shape, shape)


def _deflection(s: float, length: float, phi: float) -> Array:
    """N_1 .. N_4."""
    return np.array(
        [
            1.0 - 3.0 * s**2 + 2.0 * s**3 + phi * (1.0 - s),
            length * (s - 2.0 * s**2 + s**3 + 0.5 * phi * (s - s**2)),
            3.0 * s**2 - 2.0 * s**3 + phi * s,
            length * (s**3 - s**2 - 0.5 * phi * (s - s**2)),
        ]
    ) / (1.0 + phi)


def _rotation(s: float, length: float, phi: float) -> Array:
    """B_1 .. B_4."""
    tilt = 6.0 * (s**2 - s) / length
    return np.array(
        [tilt, 1.0 - 4.0 * s + 3.0 * s**2 + phi * (1.0 - s), -tilt, 3.0 * s**2 - 2.0 * s + phi * s]
    ) / (1.0 + phi)  # fmt: skip


def _curvature(s: float, length: float, phi: float) -> Array:
    """B_1' .. B_4'."""
    tilt = 6.0 * (2.0 * s - 1.0) / length
    return np.array([tilt, 6.0 * s - 4.0 - phi, -tilt, 6.0 * s - 2.0 + phi]) / (length * (1.0 + phi))
