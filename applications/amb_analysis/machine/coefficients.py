"""Additional stiffness, damping and mass at a point of the rotor, over speed, such as cross-coupled stages.

    f = -(K(Omega) q + C(Omega) q' + M(Omega) q''),   q = (x, y) at the place                     (1)

A stage drives forward whirl with K = Q [[0, 1], [-1, 0]]: on a forward circle q = (cos, sin), f = Q (-sin, cos), which
points along the velocity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.parts import Bearing

WHIRL = np.array([[0.0, 1.0], [-1.0, 0.0]])  # a stiffness Q WHIRL with Q > 0 drives forward whirl

Triple = tuple[Array, Array, Array]  # K (N/m), C (N s/m), M (kg), shape (2, 2) each


@dataclass(frozen=True)
class SupportCoefficients:
    """Coefficients at a place of the rotor: its name, its node, and K, C and M of (1) over the spin speed (rad/s)."""

    name: str
    node: int
    at: Callable[[float], Triple]

    def added_to(self, model: Matrices, Omega: float) -> Matrices:
        """Return a model with these coefficients, whose node must have translations in it."""
        K, C, M = self.at(Omega)
        rows = np.ix_(model.translations[self.node], model.translations[self.node])
        stiff, damped, heavy = model.K.copy(), model.C.copy(), model.M.copy()
        stiff[rows] += K
        damped[rows] += C
        heavy[rows] += M
        return replace(model, K=stiff, C=damped, M=heavy)


def cross_coupling(name: str, node: int, Q: float) -> SupportCoefficients:
    """Return a cross-coupled stiffness Q (N/m) that drives forward whirl."""
    zero = np.zeros((2, 2))
    return SupportCoefficients(name, node, lambda Omega: (Q * WHIRL, zero, zero))


def without(seal: Bearing) -> SupportCoefficients:
    """Return coefficients that cancel a seal of the rotor."""

    def at(Omega: float) -> Triple:
        K, C, M = seal.at(Omega)
        return -K, -C, -M

    return SupportCoefficients(seal.name, seal.node, at)
