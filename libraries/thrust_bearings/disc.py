"""A thrust disc between two magnets with coil bias: force and its slopes, load capacity, tilting stiffness.

             I_0 - i                       I_0 + i
       | core |<- g_0 + z ->| disc |<- g_0 - z ->| core |
                                |---> z, F

Each magnet consists of two ring-shaped poles of area A about the shaft, with a coil of N turns between them. The flux
of a magnet crosses the gap twice. If the iron is ideal,

    B_+- = min(mu_0 N (I_0 +- i)/(2 (g_0 -+ z)), B_sat)                          (1)
    F = A/mu_0 (B_+^2 - B_-^2)                                                   (2)
      = mu_0 N^2 A/4 [(I_0 + i)^2/(g_0 - z)^2 - (I_0 - i)^2/(g_0 + z)^2]         below saturation
    K_i = mu_0 N^2 A I_0/g_0^2,   K_s = K_i I_0/g_0 (1 + (i/I_0)^2)              (3)

F > 0 pulls towards positive z, and i > 0 strengthens the magnet on that side. In the linear law F = K_i i + K_s z both
constants are positive, so K_s z pulls the disc further away from the centre. At z = 0, K_i does not depend on the
current i, but K_s increases with a static load.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.constants import mu_0
from scipy.optimize import brentq

from amb_files.checks import require, require_positive
from array_types import Array

Ring = tuple[float, float]  # inner and outer radius (m)


class OperatingPoint(NamedTuple):
    """Operating point of a bearing under a static force: control current (A), K_i (N/A) and K_s (N/m)."""

    current: float
    k_i: float
    k_s: float


@dataclass(frozen=True)
class ThrustDisc:
    """A two-sided axial magnetic bearing.

    inner_radius, outer_radius
        Radius r_i of the inner pole's inner edge, and radius r_o of the outer pole's outer edge (m).
    pole_area
        Area A of each pole (m^2); a magnet has two.
    gap
        Air gap g_0 on each side of the centred disc (m).
    turns
        Number N of turns of each magnet.
    bias_current, current_limit
        Bias current I_0, and largest current of a coil (A).
    saturation
        Flux density B_sat at which the iron saturates (T).

    Raises
    ------
    ValueError
        If a number is out of range, if the poles do not fit between the radii, or if the bias saturates the iron.
    """

    inner_radius: float
    outer_radius: float
    pole_area: float
    gap: float
    turns: float
    bias_current: float
    current_limit: float
    saturation: float

    def __post_init__(self) -> None:
        r_i, r_o = self.inner_radius, self.outer_radius
        _check_radii(r_i, r_o)
        largest = 0.5 * math.pi * (r_o**2 - r_i**2)
        allowed = f"> 0 m2 and < {largest:.4g} m2, half the area between the radii"
        require(0.0 < self.pole_area < largest, "pole_area", f"{self.pole_area:g} m2", allowed)
        require_positive(self, gap="m", turns="", bias_current="A", saturation="T")
        limit = self.current_limit
        allowed = f"> bias_current = {self.bias_current:g} A"
        require(self.bias_current < limit < math.inf, "current_limit", f"{limit:g} A", allowed)
        density = mu_0 * self.turns * self.bias_current / (2.0 * self.gap)
        allowed = f"smaller: it causes {density:.3g} T in the gap, and the iron saturates at {self.saturation:g} T"
        require(density < self.saturation, "bias_current", f"{self.bias_current:g} A", allowed)

    @property
    def poles(self) -> tuple[Ring, Ring]:
        """Inner and outer pole as rings of equal area."""
        area_over_pi = self.pole_area / math.pi
        r_i, r_o = self.inner_radius, self.outer_radius
        return (r_i, math.sqrt(r_i**2 + area_over_pi)), (math.sqrt(r_o**2 - area_over_pi), r_o)

    @property
    def largest_control_current(self) -> float:
        """Largest control current (A), at which one coil reaches its limit or the other coil carries no current."""
        return min(self.bias_current, self.current_limit - self.bias_current)

    def flux_densities(self, z: Array | float, i: Array | float) -> tuple[Array, Array]:
        """Return B_+ and B_- (T) of (1) for displacements (m) and control currents (A).

        Raises
        ------
        ValueError
            If a displacement reaches the gap, or a current exceeds `largest_control_current`.
        """
        z, i = np.asarray(z, dtype=np.float64), np.asarray(i, dtype=np.float64)
        limit = self.largest_control_current
        largest_z, largest_i = (float(values.flat[np.abs(values).argmax()]) for values in (z, i))
        require(abs(largest_z) < self.gap, "z", f"{largest_z:g} m", f"< {self.gap:g} m in magnitude")
        require(abs(largest_i) <= limit * (1.0 + 1e-12), "i", f"{largest_i:g} A", f"<= {limit:g} A in magnitude")
        factor = 0.5 * mu_0 * self.turns
        upper = factor * (self.bias_current + i) / (self.gap - z)
        lower = factor * (self.bias_current - i) / (self.gap + z)
        return np.minimum(upper, self.saturation), np.minimum(lower, self.saturation)

    def force(self, z: Array | float, i: Array | float) -> Array:
        """Return the force F (N) of (2); arguments and errors are those of `flux_densities`."""
        upper, lower = self.flux_densities(z, i)
        return np.asarray(self.pole_area / mu_0 * (upper**2 - lower**2))

    def operating_point(self, load: float = 0.0) -> OperatingPoint:
        """Return the control current and the slopes of the force at the centre, under a static force (N).

        The slopes follow from (3); a saturated magnet, whose flux density is constant, does not contribute to them.

        Raises
        ------
        ValueError
            If the force exceeds the capacity.
        """
        _check_load(load, self.capacity)
        limit = self.largest_control_current
        i = float(brentq(lambda i: float(self.force(0.0, i)) - load, -limit, limit, xtol=1e-13)) if load else 0.0
        upper, lower = (float(B) for B in self.flux_densities(0.0, i))
        unsaturated = [B for B in (upper, lower) if self.saturation > B]
        per_current = mu_0 * self.turns / (2.0 * self.gap)
        k_i = 2.0 * self.pole_area / mu_0 * per_current * sum(unsaturated)
        return OperatingPoint(i, k_i, 2.0 * self.pole_area / (mu_0 * self.gap) * sum(B * B for B in unsaturated))

    @property
    def capacity(self) -> float:
        """Largest static force (N) on the centred disc within the limits of currents and flux density."""
        return float(self.force(0.0, self.largest_control_current))

    @property
    def rings(self) -> tuple[Ring, ...]:
        """The areas that carry the force."""
        return self.poles


@dataclass(frozen=True)
class CatalogueBearing:
    """A two-sided axial magnetic bearing described by the constants of its data sheet, below saturation.

    inner_radius, outer_radius
        Radii r_i and r_o of the ring on which the bearing pulls (m).
    k_i, k_s
        Constants K_i (N/A) and K_s (N/m) without a static force.
    capacity
        Largest static force (N), which requires a control current equal to the bias current. As in a bearing with coil
        bias, a static force F multiplies K_s by 1 + (F/capacity)^2.
    """

    inner_radius: float
    outer_radius: float
    k_i: float
    k_s: float
    capacity: float

    def __post_init__(self) -> None:
        _check_radii(self.inner_radius, self.outer_radius)
        require_positive(self, k_i="N/A", k_s="N/m", capacity="N")

    def operating_point(self, load: float = 0.0) -> OperatingPoint:
        """Return the control current and the slopes of the force at the centre, under a static force (N).

        Raises
        ------
        ValueError
            If the force exceeds the capacity.
        """
        _check_load(load, self.capacity)
        return OperatingPoint(load / self.k_i, self.k_i, self.k_s * (1.0 + (load / self.capacity) ** 2))

    @property
    def rings(self) -> tuple[Ring, ...]:
        """The areas that carry the force."""
        return ((self.inner_radius, self.outer_radius),)


def _check_radii(r_i: float, r_o: float) -> None:
    require(r_i >= 0.0, "inner_radius", f"{r_i:g} m", ">= 0 m")
    require(r_i < r_o < math.inf, "outer_radius", f"{r_o:g} m", f"> inner_radius = {r_i:g} m")


def _check_load(load: float, capacity: float) -> None:
    require(abs(load) <= capacity, "static force", f"{load:g} N", f"<= {capacity:.4g} N in magnitude")


def moment_stiffness(k_s: float, rings: Sequence[Ring]) -> float:
    """Return the moment per tilt angle (N m/rad) of a disc about its diameter; rings of the disc carry K_s (N/m).

    A tilt by theta displaces each point of the disc by r cos(phi) theta, and each area pulls the disc further away:

        M = integral of kappa r^2 cos^2(phi) dA theta = K_s sum A_k (r_o^2 + r_i^2)_k/(4 sum A_k) theta         (4)

    The moment has the sign of K_s; a positive moment tilts the disc further. The iron of each core is assumed to be an
    equipotential.

    Parameters
    ----------
    k_s
        Axial negative stiffness K_s (N/m).
    rings
        Inner and outer radius of each area that carries K_s (m).
    """
    squares = np.array(rings) ** 2
    areas = squares[:, 1] - squares[:, 0]
    return float(k_s * np.sum(areas * squares.sum(axis=1)) / (4.0 * np.sum(areas)))
