"""The elements in a file saved by ROSS, and their features that a rotor file cannot describe.

ROSS (ross-rotordynamics, 2.3 to 3.1) counts nodes from 0 and lists shaft elements by node, several per node if sleeves
bend with the shaft. Its elements have six degrees of freedom per node; a rotor file has only the four of bending.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from amb_files.toml import read_toml, validate
from rotor_analysis.ross_magnets import magnet_of
from rotor_analysis.ross_parts import AXES, SavedBearing, SavedDisk, SavedMass, SavedShaftElement


@dataclass
class SavedRotor:
    """The elements in a file, in the order of the file.

    others
        Names of tables of other kinds.
    over_both
        Tags of bearings and seals with coefficients that depend on both speed and frequency.
    """

    title: str
    elements: list[SavedShaftElement] = field(default_factory=list)
    disks: list[SavedDisk] = field(default_factory=list)
    masses: list[SavedMass] = field(default_factory=list)
    bearings: list[SavedBearing] = field(default_factory=list)
    seals: list[SavedBearing] = field(default_factory=list)
    others: list[str] = field(default_factory=list)
    over_both: list[str] = field(default_factory=list)


def read_saved(path: Path, frequency: float | None = None) -> SavedRotor:
    """Read the elements of a rotor saved by ROSS as TOML; coefficients over frequency require a `frequency` (rad/s).

    Raises
    ------
    ValueError
        If the file cannot be read, is not a ROSS file, or has features that a rotor file cannot describe; the message
        lists them.
    """
    name = f"ROSS file {path}"
    data = read_toml(path, name)
    is_old = str(data.get("ross_version", "2")).partition(".")[0] < "3"
    parameters = data.get("parameters")
    title = parameters.get("tag") if isinstance(parameters, dict) else None
    rotor = SavedRotor(str(title or path.stem))
    for key, table in data.items():
        if key in ("ross_version", "parameters", "_note"):
            continue
        what, kind = f"{name}, {key!r}", key.partition("_")[0]
        if isinstance(table, dict) and {"kxx", "cxx"} <= set(table):
            supports = rotor.seals if kind == "SealElement" else rotor.bearings
            if table.get("speed") and table.get("frequency"):
                rotor.over_both.append(str(table.get("tag", key)))
                continue
            if is_old and "g0" not in table:
                table = {**table, "speed": table.get("frequency"), "frequency": None, "interpolation": "spline"}
            supports.append(validate(table, SavedBearing, what))
        elif kind == "ShaftElement":
            rotor.elements.append(validate(table, SavedShaftElement, what))
        elif kind == "DiskElement":
            rotor.disks.append(validate(table, SavedDisk, what))
        elif kind == "PointMass":
            rotor.masses.append(validate(table, SavedMass, what))
        else:
            rotor.others.append(key)
    if not rotor.elements:
        raise ValueError(f"{name} has no table such as ['ShaftElement_1']; it must be a rotor saved by ROSS as TOML")
    by_reason: dict[str, list[str]] = {}
    for reason, tag in _unsupported(rotor, frequency):
        by_reason.setdefault(reason, []).append(tag)
    if by_reason:
        lines = (
            f"{name}: {reason} ({_few(tags)}); a rotor file cannot contain this" for reason, tags in by_reason.items()
        )
        raise ValueError("\n".join(lines))
    return rotor


def _unsupported(rotor: SavedRotor, frequency: float | None) -> Iterator[tuple[str, str]]:
    """Yield each feature that a rotor file cannot describe, and the tag of its part."""
    for tag in rotor.over_both:
        yield "coefficients that depend on both speed and frequency", tag
    for key in rotor.others:
        yield "an element of another kind", key
    yield from _unsupported_in_shaft(rotor.elements)
    last = max(element.n for element in rotor.elements) + 1
    for part in (*rotor.disks, *rotor.masses, *rotor.bearings, *rotor.seals):
        if part.n > last:
            yield "a part beyond the end of the shaft", part.tag
    for mass in rotor.masses:
        if mass.mx != mass.my:
            yield "a mass that differs between x and y", mass.tag
    for bearing in (*rotor.bearings, *rotor.seals):
        if bearing.n_link is not None:
            yield "a bearing that is supported by another part", bearing.tag
        if bearing.frequency and frequency is None and magnet_of(bearing) is None:
            yield "coefficients that depend on the whirl frequency, without a `frequency` that selects one", bearing.tag
        count = len(bearing.speed or bearing.frequency or [0.0])
        settings = [getattr(bearing, f"{letter}{axes}") for letter in "kcm" for axes in AXES]
        if any(len(values) != count for values in settings if values):
            yield "more or fewer coefficients than speeds or frequencies", bearing.tag


def _unsupported_in_shaft(elements: list[SavedShaftElement]) -> Iterator[tuple[str, str]]:
    at_node: dict[int, SavedShaftElement] = {}
    for element in elements:
        first, innermost = elements[0], at_node.setdefault(element.n, element)
        for reason, applies in (
            ("an axial force", element.axial_force != 0.0),
            ("a torque", element.torque != 0.0),
            ("an element without rotary inertia", not element.rotary_inertia),
            ("an element without gyroscopic effect", not element.gyroscopic),
            ("elements with and without shear", element.shear_effects != first.shear_effects),
            ("different shear coefficients", element.shear_method_calc != first.shear_method_calc),
            ("an unknown shear coefficient", element.shear_method_calc not in ("cowper", "hutchinson")),
            ("different damping", (element.alpha, element.beta) != (first.alpha, first.beta)),
            ("layers of different length", abs(element.L - innermost.L) > 1e-9),
        ):
            if applies:
                yield reason, element.tag
    missing = next((n for n in range(max(at_node) + 1) if n not in at_node), None)
    if missing is not None:
        yield "a shaft in pieces", f"no element at node {missing}"


def _few(tags: list[str]) -> str:
    more = f" and {len(tags) - 3} more" if len(tags) > 3 else ""
    return ", ".join(tags[:3]) + more
