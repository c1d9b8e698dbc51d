"""Description of a rotor: shaft, rigid bodies, bearings and planes. SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Literal, get_args

Theory = Literal["timoshenko", "rayleigh"]
Tensor = tuple[tuple[float, float], tuple[float, float]]  # ((xx, xy), (yx, yy))


def require(condition: bool, what: str, value: object, allowed: str) -> None:
    """Raise a ValueError that says what `what` must be, unless `condition` holds."""
    if not condition:
        raise ValueError(f"{what} = {value} is not allowed; it must be {allowed}")


@dataclass(frozen=True)
class Element:
    """A piece of shaft with constant ring section: length, diameters (m), E (Pa), density (kg/m^3), Poisson's ratio."""

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


@dataclass(frozen=True)
class Shaft:
    """A stepped circular shaft of one material.

    `nodes` are the axial positions z (m) of the finite-element nodes, ascending. `diameter` and `inner_diameter` (m)
    hold one value for each element, or one for all. `theory` is `timoshenko`, or `rayleigh` without shear deformation.
    """

    nodes: tuple[float, ...]
    diameter: tuple[float, ...]
    youngs_modulus: float
    density: float
    poissons_ratio: float
    inner_diameter: tuple[float, ...] = (0.0,)
    theory: Theory = "timoshenko"

    def __post_init__(self) -> None:
        ascending = all(b > a for a, b in pairwise(self.nodes)) and all(map(math.isfinite, self.nodes))
        require(len(self.nodes) >= 2 and ascending, "shaft.nodes", f"{list(self.nodes)} m", "ascending, two or more")
        count = len(self.nodes) - 1
        for name in ("diameter", "inner_diameter"):
            given = getattr(self, name)
            require(
                len(given) in (1, count), f"shaft.{name}", f"{list(given)} m", f"one value, or one for each of {count}"
            )
            object.__setattr__(self, name, given * count if len(given) == 1 else given)
        for outer, inner in zip(self.diameter, self.inner_diameter, strict=True):
            require(0.0 < outer < math.inf, "shaft.diameter", f"{outer} m", "> 0 m")
            require(0.0 <= inner < outer, "shaft.inner_diameter", f"{inner} m", f">= 0 m and < {outer} m, the diameter")
        require(0.0 < self.youngs_modulus < math.inf, "shaft.youngs_modulus", f"{self.youngs_modulus} Pa", "> 0 Pa")
        require(0.0 < self.density < math.inf, "shaft.density", f"{self.density} kg/m3", "> 0 kg/m3")
        require(-1.0 < self.poissons_ratio < 0.5, "shaft.poissons_ratio", self.poissons_ratio, "in (-1, 0.5)")
        require(self.theory in get_args(Theory), "shaft.theory", repr(self.theory), f"one of {get_args(Theory)}")

    @property
    def elements(self) -> tuple[Element, ...]:
        """The pieces between the nodes."""
        return tuple(
            Element(b - a, outer, inner, self.youngs_modulus, self.density, self.poissons_ratio, self.theory)
            for (a, b), outer, inner in zip(pairwise(self.nodes), self.diameter, self.inner_diameter, strict=True)
        )


@dataclass(frozen=True)
class Body:
    """A rigid disc, ring or core on the shaft at `node` (counted from 1): mass (kg), inertias (kg m^2)."""

    name: str
    node: int
    mass: float
    diametral_inertia: float = 0.0
    polar_inertia: float = 0.0

    def __post_init__(self) -> None:
        require(0.0 < self.mass < math.inf, f"{self.name}.mass", f"{self.mass} kg", "> 0 kg")
        for name in ("diametral_inertia", "polar_inertia"):
            value = getattr(self, name)
            require(0.0 <= value < math.inf, f"{self.name}.{name}", f"{value} kg m2", ">= 0 kg m2")

    @classmethod
    def disc(cls, name: str, node: int, mass: float, radius: float, width: float) -> Body:
        """A homogeneous disc: I_d = m r^2/4 + m w^2/12, I_p = m r^2/2, of mass (kg), radius and width (m)."""
        require(0.0 <= radius < math.inf, f"{name}.radius", f"{radius} m", ">= 0 m")
        require(0.0 <= width < math.inf, f"{name}.width", f"{width} m", ">= 0 m")
        return cls(name, node, mass, mass * (radius**2 / 4.0 + width**2 / 12.0), mass * radius**2 / 2.0)


@dataclass(frozen=True)
class Bearing:
    """A linear bearing at `node`: 2 x 2 stiffness (N/m) and damping (N s/m), cross-coupled where they are not diagonal.

    The analyses stand the rotor on it. In co-simulation the forces of the bearings come from elsewhere, and only the
    node counts.
    """

    name: str
    node: int
    stiffness: Tensor = ((0.0, 0.0), (0.0, 0.0))
    damping: Tensor = ((0.0, 0.0), (0.0, 0.0))

    def __post_init__(self) -> None:
        for name, unit in (("stiffness", "N/m"), ("damping", "N s/m")):
            tensor = getattr(self, name)
            finite = all(math.isfinite(value) for row in tensor for value in row)
            require(finite, f"{self.name}.{name}", f"{tensor} {unit}", "finite")


@dataclass(frozen=True)
class Planes:
    """Node numbers (from 1): masters of the reduction, discs, sensor planes and retainer bearings."""

    master: tuple[int, ...] = ()
    discs: tuple[int, ...] = ()
    sensors: tuple[int, ...] = ()
    retainers: tuple[int, ...] = ()


@dataclass(frozen=True)
class Rotor:
    """A rotor and where it is held, loaded and seen.

    Raises
    ------
    ValueError
        If a value is out of range or a plane names no node; the message says which and what is allowed.
    """

    name: str
    shaft: Shaft
    bodies: tuple[Body, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    planes: Planes = Planes()

    def __post_init__(self) -> None:
        count = len(self.shaft.nodes)
        placed: tuple[Body | Bearing, ...] = (*self.bodies, *self.bearings)
        named = [(f"{part.name}.node", (part.node,)) for part in placed]
        named += [(f"planes.{field.name}", getattr(self.planes, field.name)) for field in fields(Planes)]
        for what, nodes in named:
            for node in nodes:
                whole = isinstance(node, int) and 1 <= node <= count
                require(whole, what, node, f"a node number from 1 to {count}")
        master = list(self.planes.master)
        require(len(set(master)) == len(master), "planes.master", master, "a list without repetition")
        missing = sorted({*self.bearing_nodes, *self.planes.retainers} - set(master))
        require(
            not master or not missing, "planes.master", master, f"a list that includes bearings and retainers {missing}"
        )

    @property
    def bearing_nodes(self) -> tuple[int, ...]:
        """Node numbers of the bearings."""
        return tuple(bearing.node for bearing in self.bearings)

    def on_equal_bearings(self, stiffness: float, damping: float) -> Rotor:
        """The same rotor on isotropic bearings of the given stiffness (N/m) and damping (N s/m)."""
        k, c = ((stiffness, 0.0), (0.0, stiffness)), ((damping, 0.0), (0.0, damping))
        return replace(self, bearings=tuple(replace(b, stiffness=k, damping=c) for b in self.bearings))

    @property
    def mass(self) -> float:
        """Total mass (kg)."""
        return sum(e.density * e.area * e.length for e in self.shaft.elements) + sum(b.mass for b in self.bodies)
