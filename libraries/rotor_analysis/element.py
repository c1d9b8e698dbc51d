"""An element of a shaft: its material and its section, which may be conical."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le, Lt
from pydantic import StrictFloat

from amb_files.toml import table
from amb_files.validation_errors import Unit
from rotor_analysis.checks import Moderate

Theory = Literal["timoshenko", "rayleigh"]
Shear = Literal["cowper", "hutchinson"]

YoungsModulus = Annotated[StrictFloat, Gt(0.0), Moderate, Unit("Pa")]
Density = Annotated[StrictFloat, Ge(0.0), Le(1e20), Unit("kg/m3")]
PoissonsRatio = Annotated[StrictFloat, Gt(-1.0), Lt(0.5)]


@table
class Material:
    """An isotropic material."""

    youngs_modulus: YoungsModulus
    """E."""
    density: Density
    """rho."""
    poissons_ratio: PoissonsRatio
    """nu."""

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) (Pa)."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))


@dataclass(frozen=True)
class Element:
    """A shaft element with a ring section: length, outer and inner diameters (m) at its two ends, and a material.

    The diameters change linearly along a tapered element. `theory` is `timoshenko`, with the shear coefficient of
    Cowper or of Hutchinson, or `rayleigh`, without shear deformation.
    """

    length: float
    diameter: tuple[float, float]
    inner_diameter: tuple[float, float]
    material: Material
    theory: Theory = "timoshenko"
    shear: Shear = "cowper"

    @property
    def is_tapered(self) -> bool:
        return self.diameter[0] != self.diameter[1] or self.inner_diameter[0] != self.inner_diameter[1]

    def diameters_at(self, s: float) -> tuple[float, float]:
        """Return the outer and the inner diameter (m) at s, from 0 at the first end to 1 at the other."""
        return between(self.diameter, s), between(self.inner_diameter, s)

    def area_at(self, s: float) -> float:
        """Return the cross-section area A (m^2) at s."""
        outer, inner = self.diameters_at(s)
        return math.pi * (outer**2 - inner**2) / 4.0

    def second_moment_at(self, s: float) -> float:
        """Return the second moment of area I (m^4) at s."""
        outer, inner = self.diameters_at(s)
        return math.pi * (outer**4 - inner**4) / 64.0

    @property
    def area(self) -> float:
        """Cross-section area A (m^2) in the middle."""
        return self.area_at(0.5)

    @property
    def second_moment(self) -> float:
        """Second moment of area I (m^4) in the middle."""
        return self.second_moment_at(0.5)

    def part(self, begin: float, end: float) -> Element:
        """Return the element from s = `begin` to s = `end`."""
        (outer, inner), (outer_end, inner_end) = self.diameters_at(begin), self.diameters_at(end)
        length = (end - begin) * self.length
        return replace(self, length=length, diameter=(outer, outer_end), inner_diameter=(inner, inner_end))

    @property
    def mass(self) -> float:
        """Mass (kg); Simpson's rule is exact for the area of a cone."""
        mean = (self.area_at(0.0) + 4.0 * self.area + self.area_at(1.0)) / 6.0 if self.is_tapered else self.area
        return self.material.density * mean * self.length

    @property
    def shear_coefficient(self) -> float:
        """Shear coefficient kappa of a ring, with m = d_i/d in the middle of the element.

        Cowper 1966: 6 (1 + nu) (1 + m^2)^2 / ((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2).
        Hutchinson 2001: 6 (1 + nu)^2 (1 + m^2)^2 / ((7 + 12 nu + 4 nu^2) (1 + m^2)^2 + 4 (5 + 6 nu + 2 nu^2) m^2).
        """
        outer, inner = self.diameters_at(0.5)
        nu, m2 = self.material.poissons_ratio, (inner / outer) ** 2
        if self.shear == "hutchinson":
            solid, ring = 7.0 + 12.0 * nu + 4.0 * nu**2, 4.0 * (5.0 + 6.0 * nu + 2.0 * nu**2)
            return 6.0 * (1.0 + nu) ** 2 * (1.0 + m2) ** 2 / (solid * (1.0 + m2) ** 2 + ring * m2)
        return 6.0 * (1.0 + nu) * (1.0 + m2) ** 2 / ((7.0 + 6.0 * nu) * (1.0 + m2) ** 2 + (20.0 + 12.0 * nu) * m2)


def between(ends: tuple[float, float], s: float) -> float:
    """Return the linear interpolation between two `ends` at s; it is exact at both ends."""
    return ends[0] if ends[0] == ends[1] else (1.0 - s) * ends[0] + s * ends[1]
