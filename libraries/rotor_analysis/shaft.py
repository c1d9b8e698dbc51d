"""The shaft of a rotor: nodes along z and the elements between them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Literal

from annotated_types import Gt, Lt
from pydantic import BeforeValidator, StrictFloat

from amb_files.toml import table
from amb_files.validation_errors import Unit
from rotor_analysis.checks import Length, Size, require

Theory = Literal["timoshenko", "rayleigh"]

SAME_PLACE = 1e-9  # m; a position this close to a node is that node's


def _as_tuple(value: object) -> object:
    """One number for all elements."""
    return value if isinstance(value, list | tuple) else (value,)


Diameters = Annotated[tuple[Length, ...], BeforeValidator(_as_tuple)]
InnerDiameters = Annotated[tuple[Size, ...], BeforeValidator(_as_tuple)]


@dataclass(frozen=True)
class Element:
    """A shaft element with constant ring section: length, diameters (m), E (Pa), density (kg/m^3), Poisson's ratio."""

    length: float
    diameter: float
    inner_diameter: float
    youngs_modulus: float
    density: float
    poissons_ratio: float
    theory: Theory = "timoshenko"

    @property
    def area(self) -> float:
        """Cross-section area A (m^2)."""
        return math.pi * (self.diameter**2 - self.inner_diameter**2) / 4.0

    @property
    def second_moment(self) -> float:
        """Second moment of area I (m^4)."""
        return math.pi * (self.diameter**4 - self.inner_diameter**4) / 64.0

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) (Pa)."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))

    @property
    def shear_coefficient(self) -> float:
        """Cowper's kappa of a ring, 6 (1 + nu) (1 + m^2)^2 / ((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2), m = d_i/d."""
        nu, m2 = self.poissons_ratio, (self.inner_diameter / self.diameter) ** 2
        return 6.0 * (1.0 + nu) * (1.0 + m2) ** 2 / ((7.0 + 6.0 * nu) * (1.0 + m2) ** 2 + (20.0 + 12.0 * nu) * m2)


@table
class Shaft:
    """A stepped circular shaft of one material.

    `nodes` are the axial positions z (m) of the finite-element nodes, ascending. `diameter` and `inner_diameter` (m)
    hold one value for each element, or one for all. `theory` is `timoshenko`, or `rayleigh` without shear deformation.
    """

    nodes: tuple[Annotated[StrictFloat, Unit("m")], ...]
    diameter: Diameters
    youngs_modulus: Annotated[StrictFloat, Gt(0.0), Unit("Pa")]
    density: Annotated[StrictFloat, Gt(0.0), Unit("kg/m3")]
    poissons_ratio: Annotated[StrictFloat, Gt(-1.0), Lt(0.5)]
    inner_diameter: InnerDiameters = (0.0,)
    theory: Theory = "timoshenko"

    def __post_init__(self) -> None:
        ascending = all(b > a for a, b in pairwise(self.nodes))
        require(len(self.nodes) >= 2 and ascending, "nodes", f"{list(self.nodes)} m", "ascending, two or more")
        count = len(self.nodes) - 1
        for name in ("diameter", "inner_diameter"):
            given = getattr(self, name)
            require(len(given) in (1, count), name, f"{list(given)} m", f"one value, or one for each of {count}")
            object.__setattr__(self, name, given * count if len(given) == 1 else given)
        for outer, inner in zip(self.diameter, self.inner_diameter, strict=True):
            require(inner < outer, "inner_diameter", f"{inner} m", f">= 0 m and < {outer} m, the diameter")

    def node_at(self, z: float) -> int | None:
        """Return the number (from 1) of the node at z (m), None where there is none."""
        return next((k for k, place in enumerate(self.nodes, start=1) if abs(place - z) <= SAME_PLACE), None)

    def with_nodes_at(self, places: Iterable[float]) -> Shaft:
        """Return the same shaft with nodes at `places` (m) too, all within its ends."""
        z = list(self.nodes)
        for place in places:
            if all(abs(place - other) > SAME_PLACE for other in z):
                z.append(place)
        return self.on_nodes(tuple(sorted(z)))

    def on_nodes(self, nodes: tuple[float, ...]) -> Shaft:
        """Return the same shaft on other nodes (m), such that no section changes between two of them.

        Raises
        ------
        ValueError
            If the section of the shaft changes between two of the nodes.
        """
        sections = [self._section(a, b) for a, b in pairwise(nodes)]
        return replace(
            self,
            nodes=nodes,
            diameter=tuple(outer for outer, _ in sections),
            inner_diameter=tuple(inner for _, inner in sections),
        )

    def _section(self, begin: float, end: float) -> tuple[float, float]:
        """Outer and inner diameter (m) from `begin` to `end` (m), which must be one section."""
        pieces = zip(pairwise(self.nodes), self.diameter, self.inner_diameter, strict=True)
        found = {(outer, inner) for (a, b), outer, inner in pieces if a < end and b > begin}
        between = f"{begin:g} m to {end:g} m"
        require(len(found) == 1, f"element from {between}", sorted(found), "of one diameter and one inner diameter (m)")
        return found.pop()

    @property
    def elements(self) -> tuple[Element, ...]:
        """The elements between the nodes."""
        return tuple(
            Element(b - a, outer, inner, self.youngs_modulus, self.density, self.poissons_ratio, self.theory)
            for (a, b), outer, inner in zip(pairwise(self.nodes), self.diameter, self.inner_diameter, strict=True)
        )
