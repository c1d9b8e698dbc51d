"""Description of a rotor: shaft, rigid bodies, bearings and planes. SI units.

The classes declare the form of a rotor file, with limits and units; `rotor_file.load_rotor` reads one. Made in Python,
they check their values in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Annotated, Any, Literal

from annotated_types import Ge, Gt, Lt
from pydantic import BeforeValidator, Discriminator, StrictFloat, StrictInt, StrictStr, Tag

from amb_files.toml import table
from amb_files.validation_errors import Unit

Theory = Literal["timoshenko", "rayleigh"]
Tensor = tuple[tuple[float, float], tuple[float, float]]  # ((xx, xy), (yx, yy))


def _as_tuple(value: object) -> object:
    """One number for all elements."""
    return value if isinstance(value, list | tuple) else (value,)


def _as_tensor(value: object) -> object:
    """A 2 x 2 tensor, or one number for both axes of an isotropic bearing."""
    rows: Any = value if isinstance(value, list | tuple) else ((value, 0.0), (0.0, value))
    whole = len(rows) == 2 and all(isinstance(row, list | tuple) and len(row) == 2 for row in rows)
    if not whole or not all(_is_finite(number) for row in rows for number in row):
        raise ValueError("it must be a finite number or [[xx, xy], [yx, yy]] of finite numbers")
    return tuple(tuple(float(number) for number in row) for row in rows)


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


Node = Annotated[StrictInt, Ge(1)]
Mass = Annotated[StrictFloat, Gt(0.0), Unit("kg")]
Inertia = Annotated[StrictFloat, Ge(0.0), Unit("kg m2")]
Diameters = Annotated[tuple[Annotated[StrictFloat, Gt(0.0), Unit("m")], ...], BeforeValidator(_as_tuple)]
InnerDiameters = Annotated[tuple[Annotated[StrictFloat, Ge(0.0), Unit("m")], ...], BeforeValidator(_as_tuple)]
TensorOrNumber = Annotated[Tensor, BeforeValidator(_as_tensor)]


def require(condition: bool, what: str, value: object, allowed: str) -> None:
    """Raise a ValueError with the name `what`, its value and what is allowed, unless `condition` holds."""
    if not condition:
        raise ValueError(f"{what} = {value} is not allowed; it must be {allowed}")


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

    @property
    def elements(self) -> tuple[Element, ...]:
        """The elements between the nodes."""
        return tuple(
            Element(b - a, outer, inner, self.youngs_modulus, self.density, self.poissons_ratio, self.theory)
            for (a, b), outer, inner in zip(pairwise(self.nodes), self.diameter, self.inner_diameter, strict=True)
        )


@table
class Body:
    """A rigid body on the shaft at `node` (counted from 1): mass (kg), inertias (kg m^2)."""

    name: StrictStr
    node: Node
    mass: Mass
    diametral_inertia: Inertia
    polar_inertia: Inertia


@table
class Disc:
    """A homogeneous rigid disc or core on the shaft at `node` (counted from 1): mass (kg), radius and width (m)."""

    name: StrictStr
    node: Node
    mass: Mass
    radius: Annotated[StrictFloat, Ge(0.0), Unit("m")]
    width: Annotated[StrictFloat, Ge(0.0), Unit("m")]

    @property
    def diametral_inertia(self) -> float:
        """I_d = m r^2/4 + m w^2/12 (kg m^2)."""
        return self.mass * (self.radius**2 / 4.0 + self.width**2 / 12.0)

    @property
    def polar_inertia(self) -> float:
        """I_p = m r^2/2 (kg m^2)."""
        return self.mass * self.radius**2 / 2.0


def _kind_of_body(value: object) -> str:
    """A body with a radius or a width is a disc."""
    if isinstance(value, dict):
        return "disc" if {"radius", "width"} & set(value) else "body"
    return "disc" if isinstance(value, Disc) else "body"


BodyOrDisc = Annotated[
    Annotated[Body, Tag("body")] | Annotated[Disc, Tag("disc")],
    Discriminator(_kind_of_body),
]


@table
class Bearing:
    """A linear bearing at `node`: 2 x 2 stiffness (N/m) and damping (N s/m), or one number for both axes.

    The tensors are cross-coupled where they are not diagonal. The analyses place the rotor on this bearing. In
    co-simulation the forces of the bearings come from another component, and only the node counts.
    """

    name: StrictStr
    node: Node
    stiffness: TensorOrNumber = ((0.0, 0.0), (0.0, 0.0))
    damping: TensorOrNumber = ((0.0, 0.0), (0.0, 0.0))


@table
class Planes:
    """Node numbers (from 1): masters of the reduction, discs, sensor planes and retainer bearings."""

    master: tuple[Node, ...] = ()
    discs: tuple[Node, ...] = ()
    sensors: tuple[Node, ...] = ()
    retainers: tuple[Node, ...] = ()


@table
class Rotor:
    """A rotor: its shaft with bodies and bearings, and the planes where forces act and displacements are measured.

    Raises
    ------
    ValueError
        If a value is out of range or a plane is at a node that does not exist; one line for each mistake.
    """

    name: StrictStr
    shaft: Shaft
    bodies: tuple[BodyOrDisc, ...] = ()
    bearings: tuple[Bearing, ...] = ()
    planes: Planes = Planes()

    def __post_init__(self) -> None:
        count, master = len(self.shaft.nodes), list(self.planes.master)
        wrong = [f"{what} = {node} is not allowed; it must be a node number from 1 to {count}"
                 for what, node in self._placed() if node > count]  # fmt: skip
        if wrong:
            raise ValueError("\n".join(wrong))
        require(len(set(master)) == len(master), "planes.master", master, "a list without repetition")
        missing = sorted({*self.bearing_nodes, *self.planes.retainers} - set(master))
        require(
            not master or not missing, "planes.master", master, f"a list that includes bearings and retainers {missing}"
        )

    def _placed(self) -> Iterator[tuple[str, int]]:
        """Every node number and its key."""
        for key, parts in (("bodies", self.bodies), ("bearings", self.bearings)):
            for k, part in enumerate(parts):
                yield f"{key}[{k}].node ({part.name})", part.node
        for field in fields(Planes):
            for k, node in enumerate(getattr(self.planes, field.name)):
                yield f"planes.{field.name}[{k}]", node

    @property
    def bearing_nodes(self) -> tuple[int, ...]:
        """Node numbers of the bearings."""
        return tuple(bearing.node for bearing in self.bearings)

    def on_equal_bearings(self, stiffness: float, damping: float) -> Rotor:
        """Return the same rotor on isotropic bearings of the given stiffness (N/m) and damping (N s/m)."""
        k, c = ((stiffness, 0.0), (0.0, stiffness)), ((damping, 0.0), (0.0, damping))
        return replace(self, bearings=tuple(replace(b, stiffness=k, damping=c) for b in self.bearings))

    @property
    def mass(self) -> float:
        """Total mass (kg)."""
        return sum(e.density * e.area * e.length for e in self.shaft.elements) + sum(b.mass for b in self.bodies)
