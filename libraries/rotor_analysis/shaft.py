"""The shaft of a rotor: nodes along z and the sections between them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from annotated_types import MinLen
from pydantic import AfterValidator, BeforeValidator, Discriminator, Tag

from amb_files.checks import require
from amb_files.toml import table
from rotor_analysis.checks import Length, Name, Position, Size, as_tuple
from rotor_analysis.element import Density, Element, Material, PoissonsRatio, Shear, Theory, YoungsModulus
from rotor_analysis.sections import PER_ELEMENT, SAME_PLACE, ElementSection, ShaftSection, Sleeve

MassModel = Literal["consistent", "diagonal"]
MASS_MODELS: tuple[MassModel, ...] = get_args(MassModel)


SHORTEST = 1e-4  # of the shaft's length; a shorter element is so stiff that rounding hides the rest
Diameters = Annotated[tuple[Length, ...], BeforeValidator(as_tuple)]
InnerDiameters = Annotated[tuple[Size, ...], BeforeValidator(as_tuple)]
MaterialNames = Annotated[tuple[Name | None, ...], BeforeValidator(as_tuple)]


@table
class Shaft:
    """A stepped circular shaft. Elements without a separate material have the material defined here."""

    nodes: tuple[Position, ...]
    """Positions z of the nodes, ascending."""
    diameter: Diameters
    """Outer diameters: one value for each element, or one for all."""
    youngs_modulus: YoungsModulus | None = None
    """Modulus E of elements without a named material."""
    density: Density | None = None
    """Density rho of these elements."""
    poissons_ratio: PoissonsRatio | None = None
    """Poisson's ratio nu of these elements."""
    inner_diameter: InnerDiameters = (0.0,)
    """Inner diameters: one value for each element, or one for all."""
    theory: Theory = "timoshenko"
    """`timoshenko`, or `rayleigh` without shear deformation."""
    diameter_end: Diameters = ()
    """Diameters at the other end of conical elements."""
    inner_diameter_end: InnerDiameters = ()
    """Inner diameters at the other end of conical elements."""
    material: MaterialNames = ()
    """Names of `materials`, one for each element or one for all."""
    shear: Shear = "cowper"
    """Author of the shear coefficient, Cowper or Hutchinson."""
    mass_matrix: MassModel = "diagonal"
    """`diagonal` or `consistent`."""
    sleeves: tuple[Sleeve, ...] = ()
    """Rings that bend with the shaft."""

    def __post_init__(self) -> None:
        ascending = all(b > a for a, b in pairwise(self.nodes))
        require(len(self.nodes) >= 2 and ascending, "nodes", f"{list(self.nodes)} m", "ascending, two or more")
        shortest = SHORTEST * (self.nodes[-1] - self.nodes[0])
        for a, b in pairwise(self.nodes):
            apart = (
                f"{shortest:.2g} m apart or more; the ends of sections and the positions of parts also count as nodes"
            )
            require(b - a >= shortest, "nodes", f"{a!r} m, {b!r} m", apart)
        if len(self.material) == 1:
            object.__setattr__(self, "sleeves", _of_material(self.sleeves, self.material[0]))
        count = len(self.nodes) - 1
        for name, unit in PER_ELEMENT.items():
            values = self._per_element(name)
            require(len(values) == count, name, f"{list(values)}{unit}", f"one value, or one for each of {count}")
            object.__setattr__(self, name, values)
        for piece in self._pieces():
            piece.check()
        for name, default in (
            ("diameter_end", self.diameter),
            ("inner_diameter_end", self.inner_diameter),
            ("material", (None,) * count),
        ):
            if getattr(self, name) == default:
                object.__setattr__(self, name, ())
        _check_material(self, (*(self.material or (None,)), *(sleeve.material for sleeve in self.sleeves)))
        for k, sleeve in enumerate(self.sleeves):
            for name, place in (("begin", sleeve.begin), ("end", sleeve.end)):
                inside = self.nodes[0] - SAME_PLACE <= place <= self.nodes[-1] + SAME_PLACE
                allowed = f"from {self.nodes[0]:g} m to {self.nodes[-1]:g} m, on the shaft"
                require(inside, f"sleeves[{k}].{name}", f"{place} m", allowed)

    def node_at(self, z: float) -> int | None:
        """Return the number (from 1) of the node at z (m), or None if there is no node."""
        return next((k for k, place in enumerate(self.nodes, start=1) if abs(place - z) <= SAME_PLACE), None)

    def with_nodes_at(self, places: Iterable[float]) -> Shaft:
        """Return the same shaft with additional nodes at `places` (m) between its ends, and at the ends of sleeves."""
        z = list(self.nodes)
        for place in (*places, *(end for sleeve in self.sleeves for end in (sleeve.begin, sleeve.end))):
            if all(abs(place - other) > SAME_PLACE for other in z):
                z.append(place)
        return self.on_nodes(tuple(sorted(z))) if len(z) > len(self.nodes) else self

    def on_nodes(self, nodes: tuple[float, ...]) -> Shaft:
        """Return the same shaft with other nodes (m), between which no section may change.

        Raises
        ------
        ValueError
            If the section of the shaft changes between two of the nodes.
        """
        for sleeve in self.sleeves:
            for place in (sleeve.begin, sleeve.end):
                has_node = any(abs(place - z) <= SAME_PLACE for z in nodes)
                require(has_node, "nodes", f"{list(nodes)} m", f"a list that contains {place:g} m, where a sleeve ends")
        elements = list(zip(pairwise(self.nodes), self._pieces(), strict=True))
        pieces = [_piece(elements, a, b) for a, b in pairwise(nodes)]
        per_element: dict[str, Any] = {name: tuple(getattr(piece, name) for piece in pieces) for name in PER_ELEMENT}
        return replace(self, nodes=nodes, **per_element)

    def elements(self, materials: Mapping[str, Material]) -> tuple[tuple[Element, ...], ...]:
        """Return the elements between the nodes, each followed by the sleeves on it, with `materials` by name."""
        unnamed = None
        if self.youngs_modulus is not None and self.density is not None and self.poissons_ratio is not None:
            unnamed = Material(self.youngs_modulus, self.density, self.poissons_ratio)

        def element(length: float, piece: ElementSection) -> Element:
            material = unnamed if piece.material is None else materials[piece.material]
            assert material is not None, "checked when the shaft was made"
            outer, inner = (piece.diameter, piece.diameter_end), (piece.inner_diameter, piece.inner_diameter_end)
            return Element(length, outer, inner, material, self.theory, self.shear)

        return tuple(
            tuple(element(b - a, p) for p in (piece, *(s.on(a, b) for s in self.sleeves if s.covers(a, b))))
            for (a, b), piece in zip(pairwise(self.nodes), self._pieces(), strict=True)
        )

    def _pieces(self) -> list[ElementSection]:
        return [ElementSection(*values) for values in zip(*map(self._per_element, PER_ELEMENT), strict=True)]

    def _per_element(self, name: str) -> tuple[Any, ...]:
        """Return the values of a field, one per element; values at the other end default to those at the first."""
        values = getattr(self, name) or ((None,) if name == "material" else getattr(self, name.removesuffix("_end")))
        return values * (len(self.nodes) - 1) if len(values) == 1 else values


@table
class SectionedShaft:
    """A shaft defined by its sections from z = 0, with nodes at their ends."""

    sections: Annotated[tuple[ShaftSection, ...], MinLen(1)]
    """The sections, in sequence."""
    youngs_modulus: YoungsModulus | None = None
    """Modulus E of sections without a named material."""
    density: Density | None = None
    """Density rho of these sections."""
    poissons_ratio: PoissonsRatio | None = None
    """Poisson's ratio nu of these sections."""
    theory: Theory = "timoshenko"
    """`timoshenko`, or `rayleigh` without shear deformation."""
    material: Name | None = None
    """Material of the sections and sleeves without a named material."""
    shear: Shear = "cowper"
    """Author of the shear coefficient, Cowper or Hutchinson."""
    mass_matrix: MassModel = "consistent"
    """`diagonal` or `consistent`."""
    sleeves: tuple[Sleeve, ...] = ()
    """Rings that bend with the shaft."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "sleeves", _of_material(self.sleeves, self.material))
        _check_material(self, (*self._materials(), *(sleeve.material for sleeve in self.sleeves)))

    def _materials(self) -> tuple[str | None, ...]:
        """Return the names of the sections' materials."""
        return tuple(section.material or self.material for section in self.sections)

    def on_its_ends(self) -> Shaft:
        """Return the shaft with one element for each section."""
        nodes = tuple(accumulate((section.length for section in self.sections), initial=0.0))
        values: dict[str, Any] = {field.name: getattr(self, field.name) for field in fields(self)}
        sections = values.pop("sections")
        values |= {name: tuple(getattr(section, name) for section in sections) for name in PER_ELEMENT}
        values["material"] = self._materials()
        return Shaft(nodes=nodes, **values)


def _of_material(sleeves: tuple[Sleeve, ...], material: str | None) -> tuple[Sleeve, ...]:
    """Return the sleeves with `material` as their default."""
    return tuple(replace(sleeve, material=sleeve.material or material) for sleeve in sleeves)


def _check_material(shaft: Shaft | SectionedShaft, named: Iterable[str | None]) -> None:
    """Raise a ValueError if the shaft lacks a material that an element needs, or defines one that no element needs."""
    needed = any(name is None for name in named)
    for name in ("youngs_modulus", "density", "poissons_ratio"):
        missing = getattr(shaft, name) is None
        if needed and missing:
            raise ValueError(f"{name} is missing")
        if not needed and not missing:
            raise ValueError(f"{name} is set, but every element has a named material")


def _kind_of_shaft(value: object) -> str:
    by_sections = "sections" in value if isinstance(value, dict) else isinstance(value, SectionedShaft)
    return "by_sections" if by_sections else "by_nodes"


if TYPE_CHECKING:
    ShaftOrSections = Shaft
else:
    ShaftOrSections = Annotated[
        Annotated[Shaft, Tag("by_nodes")]
        | Annotated[SectionedShaft, AfterValidator(SectionedShaft.on_its_ends), Tag("by_sections")],
        Discriminator(_kind_of_shaft),
    ]


def _piece(elements: Sequence[tuple[tuple[float, float], ElementSection]], begin: float, end: float) -> ElementSection:
    """Return the section from `begin` to `end` (m): part of an element, or several identical uniform elements."""
    covered = [(piece, a, b) for (a, b), piece in elements if a < end and b > begin]
    if len(covered) == 1:
        piece, a, b = covered[0]
        return piece.part((begin - a) / (b - a), (end - a) / (b - a))
    sections = {piece for piece, _, _ in covered}
    diameters = sorted({(piece.diameter, piece.inner_diameter) for piece in sections})
    require(
        len(sections) == 1 and not any(piece.is_tapered for piece in sections),
        f"element from {begin:g} m to {end:g} m",
        diameters,
        "of one outer diameter (m), one inner diameter (m) and one material",
    )
    return sections.pop()
