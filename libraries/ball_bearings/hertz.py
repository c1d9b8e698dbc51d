"""Hertz contact of a ball and a groove: ellipse of contact, approach, pressure.

    Q = K delta^1.5                       approach delta of a ball and a race under the force Q
    p = 3 Q/(2 pi a b)                    largest pressure, in the middle of the ellipse of semi-axes a, b

The ratio kappa = a/b follows from the curvatures:

    F(rho) = [(kappa^2 + 1) E - 2 K]/[(kappa^2 - 1) E],      m = 1 - 1/kappa^2

Here K(m) and E(m) are the complete elliptic integrals, and F(rho) is the difference of curvatures. This relation is
exact, whereas fits in the literature (Brewe and Hamrock) have errors of a few per cent. Source: T. A. Harris, Rolling
Bearing Analysis.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.optimize import brentq
from scipy.special import ellipe, ellipk


@dataclass(frozen=True)
class Material:
    """Young's modulus (Pa) and Poisson's ratio."""

    modulus: float
    poisson: float

    @property
    def compliance(self) -> float:
        """(1 - nu^2)/E (1/Pa)."""
        return (1.0 - self.poisson * self.poisson) / self.modulus


STEEL = Material(207e9, 0.3)
SILICON_NITRIDE = Material(310e9, 0.27)


@dataclass(frozen=True)
class PointContact:
    """Point contact of two bodies: the quantities that do not depend on the force.

    stiffness
        Stiffness K in Q = K delta^1.5 (N/m^1.5).
    area
        Product a b of the semi-axes under a force of 1 N (m^2); the product under Q is larger by the factor Q^(2/3).
    """

    stiffness: float
    area: float

    def pressure(self, Q: float) -> float:
        """Return the largest pressure p (Pa) under a force Q (N)."""
        return 1.5 * Q ** (1.0 / 3.0) / (math.pi * self.area)

    def force_at(self, pressure: float) -> float:
        """Return the force Q (N) whose largest pressure is `pressure` (Pa)."""
        return (pressure * math.pi * self.area / 1.5) ** 3


def curvature_difference(kappa: float) -> float:
    """Return F(rho) for an ellipse whose semi-axes have the ratio kappa > 1."""
    m = 1.0 - 1.0 / (kappa * kappa)
    E = float(ellipe(m))
    return ((kappa * kappa + 1.0) * E - 2.0 * float(ellipk(m))) / ((kappa * kappa - 1.0) * E)


def groove_contact(
    ball_diameter: float, conformity: float, gamma: float, ball: Material, race: Material
) -> PointContact:
    """Return the contact between a ball and the groove of a race.

    The sum of curvatures is (4 - 1/f + 2 gamma/(1 - gamma))/D, and F(rho) = (1/f + 2 gamma/(1 - gamma))/(D sum).

    Parameters
    ----------
    ball_diameter
        Diameter D of the ball (m).
    conformity
        Ratio f of the groove's radius to D, above 0.5.
    gamma
        D cos(alpha)/d_m for the inner race, -D cos(alpha)/d_m for the outer race; d_m is the pitch diameter.
    ball, race
        Materials.
    """
    race_curvature = 2.0 * gamma / (1.0 - gamma)  # in the rolling direction, times D
    total = (4.0 - 1.0 / conformity + race_curvature) / ball_diameter
    difference = (1.0 / conformity + race_curvature) / (ball_diameter * total)
    kappa = float(brentq(lambda k: curvature_difference(k) - difference, 1.0001, 1e4, xtol=1e-12))
    m = 1.0 - 1.0 / (kappa * kappa)
    E, K = float(ellipe(m)), float(ellipk(m))
    long, short = (2.0 * kappa * kappa * E / math.pi) ** (1.0 / 3.0), (2.0 * E / (math.pi * kappa)) ** (1.0 / 3.0)
    approach = 2.0 * K / math.pi * (math.pi / (2.0 * kappa * kappa * E)) ** (1.0 / 3.0)
    scale = 1.5 * (ball.compliance + race.compliance) / total  # 1/N times m^3
    per_force = approach * scale ** (2.0 / 3.0) * total / 2.0  # delta over Q^(2/3)
    return PointContact(per_force**-1.5, long * short * scale ** (2.0 / 3.0))


def in_series(first: PointContact, second: PointContact) -> float:
    """Return K (N/m^1.5) of two contacts in series; their values of K^(-2/3) are added."""
    return float((first.stiffness ** (-2.0 / 3.0) + second.stiffness ** (-2.0 / 3.0)) ** -1.5)
