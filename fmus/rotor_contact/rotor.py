"""Description of a rotor: shaft, rigid bodies and planes, read from a TOML file. SI units."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

RIG = Path(__file__).parent / "rig.toml"


def _require(condition: bool, what: str, value: object, allowed: str) -> None:
    if not condition:
        raise ValueError(f"{what} = {value} is not allowed; it must be {allowed}")


@dataclass(frozen=True)
class Shaft:
    """A uniform circular shaft; `nodes` are the axial positions z (m) of the finite-element nodes, ascending."""

    diameter: float
    youngs_modulus: float
    density: float
    poissons_ratio: float
    nodes: tuple[float, ...]

    def __post_init__(self) -> None:
        _require(0.0 < self.diameter < math.inf, "shaft.diameter", f"{self.diameter} m", "> 0 m")
        _require(
            0.0 < self.youngs_modulus < math.inf,
            "shaft.youngs_modulus",
            f"{self.youngs_modulus} Pa",
            "> 0 Pa",
        )
        _require(0.0 < self.density < math.inf, "shaft.density", f"{self.density} kg/m3", "> 0 kg/m3")
        _require(-1.0 < self.poissons_ratio < 0.5, "shaft.poissons_ratio", self.poissons_ratio, "in (-1, 0.5)")
        ascending = all(b > a for a, b in zip(self.nodes, self.nodes[1:], strict=False))
        _require(
            len(self.nodes) >= 2 and ascending,
            "shaft.nodes",
            f"{list(self.nodes)} m",
            "ascending, two or more",
        )

    @property
    def area(self) -> float:
        """Cross-section area A (m^2)."""
        return math.pi * self.diameter**2 / 4.0

    @property
    def second_moment(self) -> float:
        """Second moment of area I (m^4)."""
        return math.pi * self.diameter**4 / 64.0

    @property
    def shear_modulus(self) -> float:
        """G = E / (2 (1 + nu)) (Pa)."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))


@dataclass(frozen=True)
class Body:
    """A rigid disc or core on the shaft at `node` (counted from 1): mass (kg), radius and width (m)."""

    name: str
    node: int
    mass: float
    radius: float
    width: float

    def __post_init__(self) -> None:
        _require(0.0 < self.mass < math.inf, f"{self.name}.mass", f"{self.mass} kg", "> 0 kg")
        _require(0.0 <= self.radius < math.inf, f"{self.name}.radius", f"{self.radius} m", ">= 0 m")
        _require(0.0 <= self.width < math.inf, f"{self.name}.width", f"{self.width} m", ">= 0 m")

    @property
    def diametral_inertia(self) -> float:
        """I_d = m r^2/4 + m w^2/12 (kg m^2)."""
        return self.mass * (self.radius**2 / 4.0 + self.width**2 / 12.0)

    @property
    def polar_inertia(self) -> float:
        """I_p = m r^2/2 (kg m^2)."""
        return self.mass * self.radius**2 / 2.0


@dataclass(frozen=True)
class Planes:
    """Node numbers (from 1): masters of the reduction, magnetic bearings, discs and sensor planes."""

    master: tuple[int, ...]
    bearings: tuple[int, ...]
    discs: tuple[int, ...]
    sensors: tuple[int, ...]


@dataclass(frozen=True)
class Rotor:
    """A rotor on two bearings.

    Raises
    ------
    ValueError
        If a value is out of range or a plane names no node; the message says which and what is allowed.
    """

    name: str
    shaft: Shaft
    bodies: tuple[Body, ...]
    planes: Planes

    def __post_init__(self) -> None:
        count = len(self.shaft.nodes)
        named = [(f"{body.name}.node", (body.node,)) for body in self.bodies]
        named += [(f"planes.{field.name}", getattr(self.planes, field.name)) for field in fields(Planes)]
        for what, nodes in named:
            for node in nodes:
                _require(1 <= node <= count, what, node, f"a node number from 1 to {count}")
        for what, wanted in (("bearings", 2), ("discs", 4), ("sensors", 4)):
            given = getattr(self.planes, what)
            _require(len(given) == wanted, f"planes.{what}", list(given), f"{wanted} node numbers")
        missing = sorted(set(self.planes.bearings) - set(self.planes.master))
        _require(
            not missing,
            "planes.master",
            list(self.planes.master),
            f"a list that includes the bearings {missing}",
        )
        twice = len(set(self.planes.master)) < len(self.planes.master)
        _require(not twice, "planes.master", list(self.planes.master), "a list without repetition")

    @property
    def mass(self) -> float:
        """Total mass (kg)."""
        length = self.shaft.nodes[-1] - self.shaft.nodes[0]
        return self.shaft.density * self.shaft.area * length + sum(body.mass for body in self.bodies)


def load_rotor(path: Path = RIG) -> Rotor:
    """Read a rotor description.

    Parameters
    ----------
    path
        TOML file with `name`, `[shaft]`, `[[bodies]]` and `[planes]`; the rig of the thesis by default.

    Raises
    ------
    ValueError
        If the file cannot be read, has a missing or unknown entry, or a value out of range.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ValueError(f"rotor file {path} cannot be read: {error}") from error
    try:
        return Rotor(
            name=data["name"],
            shaft=_make(Shaft, data["shaft"], "[shaft]"),
            bodies=tuple(_make(Body, body, "[[bodies]]") for body in data.get("bodies", [])),
            planes=_make(Planes, data["planes"], "[planes]"),
        )
    except KeyError as error:
        raise ValueError(f"rotor file {path}: {error} is missing") from error
    except ValueError as error:
        raise ValueError(f"rotor file {path}: {error}") from error


def _make(kind: Any, table: dict[str, Any], where: str) -> Any:
    wanted = {field.name for field in fields(kind)}
    wrong = sorted(wanted ^ set(table))
    if wrong:
        raise ValueError(f"{where} must have exactly {', '.join(sorted(wanted))}; check {', '.join(wrong)}")
    return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in table.items()})
