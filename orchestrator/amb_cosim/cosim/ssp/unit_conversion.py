"""Conversion of values between units, and linear transformations, in connections and parameter mappings.

A law is a pair (f, o): the target is f source + o. A unit is defined by its base units, b = factor v + offset, if the
document or the FMU contains a definition. Other units are looked up by their names.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any, NamedTuple

from amb_cosim.cosim.fmu.fmu_interface import UnitDefinition
from amb_cosim.cosim.ssp.schema import NAMESPACES
from amb_cosim.cosim.system.system import UNCHANGED
from fmi_export.building.units import SI, to_unit

Law = tuple[float, float]


class Unit(NamedTuple):
    """A unit with its definition, if it has one; values of a `relative` quantity are converted without offsets."""

    name: str
    definition: UnitDefinition | None = None
    relative: bool = False


def unit_definitions(root: Any, prefix: str) -> dict[str, UnitDefinition]:
    """Return the definitions of a document's units by name; `prefix` is the prefix of the document's namespace."""
    return {
        unit.get("name"): (
            *(float(base.get(name, 0.0)) for name in SI),
            float(base.get("factor", 1.0)),
            float(base.get("offset", 0.0)),
        )
        for unit in root.iterfind(f"{prefix}:Units/ssc:Unit", NAMESPACES)
        for base in unit.iterfind("ssc:BaseUnit", NAMESPACES)
    }


def unit_of(name: str | None, *definitions: Mapping[str, UnitDefinition]) -> Unit | None:
    """Return a unit with the first definition of its name; None if the name is empty or `-`.

    A name in brackets without a definition, such as `[m]`, means the unit in the brackets; some tools for requirements
    engineering write units in this way.
    """
    if not name or name == "-":
        return None
    definition = next((table[name] for table in definitions if name in table), None)
    if definition is None and (bracketed := re.fullmatch(r"\s*\[(.*)\]\s*", name)):
        return unit_of(bracketed[1], *definitions)
    return Unit(name, definition)


def conversion(source: Unit, target: Unit) -> Law | None:
    """Return the law from one unit to another; None if a value cannot be converted.

    Examples
    --------
    >>> conversion(Unit("mm"), Unit("m"))
    (0.001, 0.0)
    """
    law = _conversion(source, target)
    return law if law is None or not (source.relative or target.relative) else (law[0], 0.0)


def _conversion(source: Unit, target: Unit) -> Law | None:
    """Return the law for values that are not relative."""
    if source == target or (source.name == target.name and None in (source.definition, target.definition)):
        return UNCHANGED
    if source.definition is None or target.definition is None:
        try:
            offset = to_unit(f"0 {source.name}", target.name, "unit")
            return to_unit(f"1 {source.name}", target.name, "unit") - offset, offset
        except ValueError:
            return None
    (*powers, factor, offset), (*others, target_factor, target_offset) = source.definition, target.definition
    if powers != others or not target_factor:
        return None
    law = factor / target_factor, (offset - target_offset) / target_factor
    return law if all(map(math.isfinite, law)) else None


def composed(first: Law, second: Law) -> Law:
    """Return the law that is equivalent to two laws applied in turn."""
    return second[0] * first[0], second[0] * first[1] + second[1]


def law_of(element: Any) -> Law | None:
    """Return the linear transformation of a connection or a mapping entry, if it has one."""
    transformation = element.find("ssc:LinearTransformation", NAMESPACES)
    if transformation is None:
        return None
    law = float(transformation.get("factor", 1.0)), float(transformation.get("offset", 0.0))
    if not all(map(math.isfinite, law)):
        raise ValueError(f"a LinearTransformation has factor {law[0]} and offset {law[1]}; both must be finite numbers")
    return law


def suppresses_units(element: Any) -> bool:
    """Return whether a connection or a mapping entry suppresses the conversion of units."""
    return element.get("suppressUnitConversion", "false") in ("true", "1")
