"""Eddy currents in the solid iron of a thrust bearing: the flux follows the current with a lag of order one half.

Ampere's law along the iron's surface around the coil, where the tangential field is H, gives

    N i = 2 g_0 B/mu_0 + integral of H dl                                                     (1)

Below the surface the field diffuses into the iron as it would into a half-space, H'' = s sigma mu H. It therefore
decays as exp(-x sqrt(s sigma mu)), and the flux per width of the surface is mu H/sqrt(s sigma mu). A flux Phi along a
surface of width w requires the field H = sqrt(s sigma/mu) Phi/w, so

    N i = R(s) Phi,   R(s) = R_0 + c sqrt(s),   R_0 = 2 g_0/(mu_0 A)                          (2)
    c = sqrt(sigma/mu) integral of (Phi(l)/Phi)^2 dl/w(l)                                     (3)

The whole flux flows along the walls and the bottom of the coil's slot, and along the face of the disc opposite the
slot. Along the pole faces of core and disc, the flux decreases because it crosses the gap. The decrease is uniform over
the face if most of the magnetomotive force N i drops across the gap. Because of leakage, the iron carries lambda times
the flux between the poles. If w = 2 pi r, the poles are rings from r_1 to r_2 and from r_3 to r_4, and the slot has the
depth h, then

    2 pi c/(lambda sqrt(sigma/mu)) = h/r_2 + h/r_3 + 2 ln(r_3/r_2)                            (4)
        + 2 int_r1^r2 ((r^2 - r_1^2)/(r_2^2 - r_1^2))^2 dr/r + 2 int_r3^r4 ((r_4^2 - r^2)/(r_4^2 - r_3^2))^2 dr/r

The ratio of the flux to the flux without eddy currents is

    G(s) = 1/(1 + sqrt(s/omega_e)),   sqrt(omega_e) = R_0/c                                   (5)

The phase of G tends to -45 degrees, and its magnitude falls with the square root of the frequency. Because the bias is
constant, the contributions of current and displacement to the force both lag: F = G(s) (K_i i + K_s z).

The form (2) is that of L. Zhu, C. R. Knospe, E. H. Maslen, IEEE Trans. Magn. 41 (2005), of which only the abstract was
read; (3) and (4) are derived here. They neglect saturation, the static reluctance of the iron, and the case in which
the skin is as thick as the iron; the last two matter if the permeability is low. Rotation does not change an axially
symmetric field. G was compared with solutions of the diffusion equation for four bearings up to 1 kHz
(`tests/support/axial_diffusion.py`). It agrees within 13 % for mu_r from 500 to 2000, and within 30 % for mu_r = 200,
where it lags too much.
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
    """The solid iron of core and disc.

    conductivity
        Conductivity sigma (S/m).
    permeability
        Relative permeability mu_r, for small changes about the bias.
    slot_depth
        Depth h of the coil's slot (m).
    leakage
        Ratio lambda of the flux in the iron to the flux between the poles (1).
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
    """Return omega_e (rad/s) of (5), at which the reluctances of eddy currents and gap have the same magnitude."""
    (_, r_2), (r_3, _) = inner, outer = disc.poles
    path = iron.slot_depth * (1.0 / r_2 + 1.0 / r_3) + 2.0 * math.log(r_3 / r_2)
    path += 2.0 * (pole_face(inner, fed_from=r_2) + pole_face(outer, fed_from=r_3))
    c = iron.leakage * math.sqrt(iron.conductivity / (iron.permeability * mu_0)) * path / (2.0 * math.pi)
    return (2.0 * disc.gap / (mu_0 * disc.pole_area) / c) ** 2


def pole_face(ring: Ring, fed_from: float) -> float:
    """Return the integral over ln r of (Phi(r)/Phi)^2 in a pole face that exchanges its flux evenly with the gap.

    If the flux enters at the edge r_a, r_b is the other edge, and D = r_b^2 - r_a^2, then

        int ((r_b^2 - r^2)/D)^2 dr/r = (r_b^4 ln(r_b/r_a) - r_b^2 D + (r_b^4 - r_a^4)/4)/D^2

    if r_b > r_a; otherwise, the sign of the right-hand side is reversed.

    Parameters
    ----------
    ring
        Inner and outer radius (m).
    fed_from
        The radius, one of the two, at which the flux enters (m).
    """
    r_a = fed_from
    r_b = ring[0] if fed_from == ring[1] else ring[1]
    D = r_b**2 - r_a**2
    logarithm = r_b**4 * math.log(r_b / r_a) if r_b > 0.0 else 0.0
    return abs(logarithm - r_b**2 * D + (r_b**4 - r_a**4) / 4.0) / D**2


def half_order_lag(s: Complex, omega_e: float) -> Complex:
    """Return the dimensionless G of (5) at complex frequencies s (rad/s)."""
    return np.asarray(1.0 / (1.0 + np.sqrt(np.asarray(s, dtype=np.complex128) / omega_e)))
