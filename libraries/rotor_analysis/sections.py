"""Pieces of a shaft: its sections, and the sleeves on it."""

from __future__ import annotations

from dataclasses import dataclass, fields

from amb_files.checks import require
from amb_files.toml import table
from rotor_analysis.checks import Length, Name, Position, Size
from rotor_analysis.element import between

SAME_PLACE = 1e-9  # m; positions this close are the same


@dataclass(frozen=True)
class ElementSection:
    """An element's section, which may change along its length, and its material's name; the position is left out."""

    diameter: float
    inner_diameter: float
    diameter_end: float
    inner_diameter_end: float
    material: str | None

    @property
    def is_tapered(self) -> bool:
        return self.diameter != self.diameter_end or self.inner_diameter != self.inner_diameter_end

    def check(self) -> None:
        """Raise a ValueError unless the bore is smaller than the shaft at both ends."""
        for end in ("", "_end"):
            outer, inner = getattr(self, f"diameter{end}"), getattr(self, f"inner_diameter{end}")
            require(inner < outer, f"inner_diameter{end}", f"{inner} m", f">= 0 m and < {outer} m, the outer diameter")

    def part(self, begin: float, end: float) -> ElementSection:
        """Return the part from `begin` to `end`, which are both fractions of the length."""
        outer = [between((self.diameter, self.diameter_end), s) for s in (begin, end)]
        inner = [between((self.inner_diameter, self.inner_diameter_end), s) for s in (begin, end)]
        return ElementSection(outer[0], inner[0], outer[1], inner[1], self.material)


PER_ELEMENT = {field.name: "" if field.name == "material" else " m" for field in fields(ElementSection)}  # field: unit


@table
class ShaftSection:
    """A piece of shaft."""

    length: Length
    """Its length."""
    diameter: Length
    """Outer diameter; for a cone, at its beginning."""
    inner_diameter: Size = 0.0
    """Inner diameter."""
    diameter_end: Length | None = None
    """Outer diameter at the other end of a cone."""
    inner_diameter_end: Size | None = None
    """Inner diameter there."""
    material: Name | None = None
    """Name of one of the `materials`; by default the shaft's material."""

    def __post_init__(self) -> None:
        _complete_diameters(self)


@table
class Sleeve:
    """A cylindrical or conical ring that bends with the shaft."""

    begin: Position
    """Position z at which the sleeve begins."""
    end: Position
    """Position z at which the sleeve ends."""
    diameter: Length
    """Outer diameter; for a cone, at its beginning."""
    inner_diameter: Size
    """Inner diameter."""
    diameter_end: Length | None = None
    """Outer diameter at the other end of a cone."""
    inner_diameter_end: Size | None = None
    """Inner diameter there."""
    material: Name | None = None
    """Name of one of the `materials`; by default the shaft's material."""

    def __post_init__(self) -> None:
        require(self.begin < self.end, "end", f"{self.end} m", f"> {self.begin} m, where the sleeve begins")
        _complete_diameters(self)

    def covers(self, begin: float, end: float) -> bool:
        """Return whether the sleeve covers the whole element from `begin` to `end` (m)."""
        return self.begin - SAME_PLACE <= begin and end <= self.end + SAME_PLACE

    def on(self, begin: float, end: float) -> ElementSection:
        """Return the part of the sleeve from `begin` to `end` (m)."""
        whole = ElementSection(*(getattr(self, name) for name in PER_ELEMENT))
        length = self.end - self.begin
        return whole.part((begin - self.begin) / length, (end - self.begin) / length)


def _complete_diameters(part: ShaftSection | Sleeve) -> None:
    """Replace missing end diameters by the diameters at the beginning, and check all four diameters of a part."""
    for name in ("diameter", "inner_diameter"):
        if getattr(part, f"{name}_end") is None:
            object.__setattr__(part, f"{name}_end", getattr(part, name))
    ElementSection(*(getattr(part, name) for name in PER_ELEMENT)).check()
