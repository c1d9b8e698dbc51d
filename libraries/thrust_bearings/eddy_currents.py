"""Eddy currents in the solid iron of a thrust bearing: flux lags the current by half an order.

Ampere's law along the iron's surface about the coil, with the tangential field H there:

    N i = 2 g_0 B/mu_0 + integral of H dl                                                     (1)

Below the surface the field diffuses into the iron, H'' = s sigma mu H, as it would into a half-space: it decays by
exp(-x sqrt(s sigma mu)), and the flux per width of the surface is mu H/sqrt(s sigma mu). A flux Phi that flows along a
surface of width w therefore needs the field H = sqrt(s sigma/mu) Phi/w, and

    N i = R(s) Phi,   R(s) = R_0 + c sqrt(s),   R_0 = 2 g_0/(mu_0 A)                          (2)
    c = sqrt(sigma/mu) integral of (Phi(l)/Phi)^2 dl/w(l)                                     (3)

The whole flux passes the walls of the coil's slot, its bottom and the disc's face opposite it. Along the pole faces, of
core and disc alike, it decreases as it crosses the gap, evenly over the face if most of N i is spent in the gap.
Including leakage, the iron carries lambda times the flux between the poles. With w = 2 pi r, the rings r_1 to r_2 and
r_3 to r_4 of the poles, and the slot's depth h:

    2 pi c/(lambda sqrt(sigma/mu)) = h/r_2 + h/r_3 + 2 ln(r_3/r_2)                            (4)
        + 2 int_r1^r2 ((r^2 - r_1^2)/(r_2^2 - r_1^2))^2 dr/r + 2 int_r3^r4 ((r_4^2 - r^2)/(r_4^2 - r_3^2))^2 dr/r

The flux relative to that without eddy currents is

    G(s) = 1/(1 + sqrt(s/omega_e)),   sqrt(omega_e) = R_0/c                                   (5)

Its phase tends to -45 degrees, and its magnitude falls with the root of the frequency. The bias is constant, so that
both the current's and the displacement's share of the force lag: F = G(s) (K_i i + K_s z).

The form (2) is that of L. Zhu, C. R. Knospe, E. H. Maslen, IEEE Trans. Magn. 41 (2005), of which only the abstract was
read; (3) and (4) are derived here. They neglect the iron's static reluctance and a skin as thick as the iron, which
matter at a low permeability, and saturation. Rotation does not change an axially symmetric field. Compared with
solutions of the diffusion equation for four bearings, G is within 13 % up to 1 kHz with mu_r of 500 to 2000, and within
30 % with 200, where it lags too much (`tests/support/axial_diffusion.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.constants import mu_0

from amb_files.checks import require, require_positive
from array_types import Complex
from thrust_bearings.disc import Ring, ThrustDisc

LEAKAGE = 1.3  # solutions of the field have 1.26 to 1.5 with gaps of 0.4 to 0.8 mm


@dataclass(frozen=True)
class SolidIron:
    """Solid iron of core and disc.

    conductivity
        sigma (S/m).
    permeability
        Relative permeability mu_r, for small changes about the bias.
    slot_depth
        Depth h of the coil's slot (m).
    leakage
        Flux lambda in the iron over that between the poles (1).
    """

    conductivity: float
    permeability: float
    slot_depth: float
    leakage: float = LEAKAGE

    def __post_init__(self) -> None:
        require_positive(self, conductivity="S/m", slot_depth="m")
        require(1.0 < self.permeability < math.inf, "permeability", f"{self.permeability:g}", "> 1")
        require(1.0 <= self.leakage <= 3.0, "leakage", f"{self.leakage:g}", ">= 1 and <= 3")


def corner_frequency(disc: ThrustDisc, iron: SolidIron) -> float:
    """Return omega_e (rad/s) of (5), at which the reluctance of the eddy currents has the magnitude of the gap's."""
    (_, r_2), (r_3, _) = inner, outer = disc.poles
    path = iron.slot_depth * (1.0 / r_2 + 1.0 / r_3) + 2.0 * math.log(r_3 / r_2)
    path += 2.0 * (pole_face(inner, fed_from=r_2) + pole_face(outer, fed_from=r_3))
    c = iron.leakage * math.sqrt(iron.conductivity / (iron.permeability * mu_0)) * path / (2.0 * math.pi)
    return (2.0 * disc.gap / (mu_0 * disc.pole_area) / c) ** 2


def pole_face(ring: Ring, fed_from: float) -> float:
    """Return the integral of the squared share of the flux over ln r, along a pole face that feeds the gap evenly.

    With the edge r_a at which the flux enters, the other edge r_b, and D = r_b^2 - r_a^2:

        int ((r_b^2 - r^2)/D)^2 dr/r = (r_b^4 ln(r_b/r_a) - r_b^2 D + (r_b^4 - r_a^4)/4)/D^2

    for r_b > r_a, and its negative otherwise.

    Parameters
    ----------
    ring
        Inner and outer radius (m).
    fed_from
        The one of these radii at which the flux enters (m).
    """
    r_a = fed_from
    r_b = ring[0] if fed_from == ring[1] else ring[1]
    D = r_b**2 - r_a**2
    logarithm = r_b**4 * math.log(r_b / r_a) if r_b > 0.0 else 0.0
    return abs(logarithm - r_b**2 * D + (r_b**4 - r_a**4) / 4.0) / D**2


def half_order_lag(s: Complex, omega_e: float) -> Complex:
    """Return G (1) of (5) at complex frequencies s (rad/s)."""
    return np.asarray(1.0 / (1.0 + np.sqrt(np.asarray(s, dtype=np.complex128) / omega_e)))
