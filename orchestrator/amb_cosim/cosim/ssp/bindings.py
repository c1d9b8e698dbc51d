"""Parameter bindings of an archive: values by hierarchical name, from sets in the document or in files, with mappings.

If there is a mapping, only the mapped values are applied; they are transformed and get their new names. Otherwise, all
values are applied under their own names. Names in a mapping include the prefix of the binding.

Modelica Association, System Structure and Parameterization, version 2.0, 2024, section 5.4 (ParameterBindings).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lxml import etree

from amb_cosim.cosim.fmu.fmu_interface import UnitDefinition
from amb_cosim.cosim.ssp.hierarchy import NAMES, Document
from amb_cosim.cosim.ssp.parameter_values import ParameterValue, read_parameters
from amb_cosim.cosim.ssp.schema import MAPPING, PARAMETERS, check, parse
from amb_cosim.cosim.ssp.unit_conversion import Law, law_of, suppresses_units, unit_definitions
from amb_cosim.cosim.system.values import Raw

SET, MAP = "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"


@dataclass(frozen=True)
class Setting:
    """Values of a variable, or of the elements of an array; `name` is its name in a system or component.

    `law` is the linear transformation of a mapping; it is applied after the conversion of units. `suppresses_units`
    disables this conversion.
    """

    name: str
    values: tuple[ParameterValue, ...]
    units: dict[str, UnitDefinition]
    law: Law | None = None
    suppresses_units: bool = False


def read_bindings(element: Any, document: Document, resources: Path | None) -> Iterator[Setting]:
    """Return the values in the parameter bindings of an element; later values take precedence.

    Parameters
    ----------
    element, document
        The element, and the document that contains it.
    resources
        Folder for sources inside the element: the resources of its FMU, or the folder of the document of its system.

    Raises
    ------
    ValueError
        If a source is missing or invalid.
    """
    for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMES):
        owner = f"{document.what}: the binding of {element.get('name')}"
        root = _content(binding, "ssd:ParameterValues/ssv:ParameterSet", (SET, PARAMETERS), document, resources, owner)
        if root is None:
            continue
        units = {**document.units, **unit_definitions(root, "ssv")}
        prefix = binding.get("prefix") or ""
        settings = [
            Setting(f"{prefix}{name}", tuple(values), units)
            for name, values in read_parameters(root, document.what).items()
        ]
        mapping = binding.find("ssd:ParameterMapping", NAMES)
        entries = (
            None
            if mapping is None
            else _content(mapping, "ssm:ParameterMapping", (MAP, MAPPING), document, resources, owner)
        )
        yield from settings if entries is None else _mapped(settings, entries, owner)


def _content(
    element: Any, inline: str, kind: tuple[str, str], document: Document, resources: Path | None, owner: str
) -> Any:
    """Return a parameter set or mapping from the file that an element names, or from the element; None if missing."""
    mime_type, schema = kind
    source = element.get("source")
    if element.get("type", mime_type) != mime_type:
        raise ValueError(f"{owner} has a source of type {element.get('type')}, which is not supported")
    if source is None:
        result = element.find(inline, NAMES)
        if result is not None:  # which the schema of structures does not check
            check(result, schema, owner)
        return result
    is_inside = element.get("sourceBase") == "component"
    if is_inside and resources is None:
        raise ValueError(f"{owner} has the source {source!r} in an FMU, but belongs to an element without an FMU")
    return parse(
        document.file(source, resources if is_inside else None).read_bytes(), schema, f"{document.what}: {source}"
    )


def _mapped(settings: list[Setting], entries: Any, owner: str) -> Iterator[Setting]:
    """Return the values that a mapping names, under their new names."""
    by_name = {setting.name: setting for setting in settings}
    for entry in entries.iterfind("ssm:MappingEntry", NAMES):
        setting = by_name.get(entry.get("source"))
        if setting is None:
            continue  # a mapping may be for larger sets
        target = entry.get("target")
        values = tuple(_translated(value, entry, f"{owner}: {target}") for value in setting.values)
        yield replace(setting, name=target, values=values, law=law_of(entry), suppresses_units=suppresses_units(entry))


def _translated(value: ParameterValue, entry: Any, what: str) -> ParameterValue:
    """Return a value, translated by a mapping entry's table of Booleans, Integers or Enumerations if it has one."""
    for element in entry:
        kind = etree.QName(element).localname
        if kind not in TABLES:
            continue
        read = TABLES[kind]
        table = {read(pair.get("source")): read(pair.get("target")) for pair in element.iterfind("ssc:MapEntry", NAMES)}
        if isinstance(value, tuple) or value not in table:
            raise ValueError(f"{what}: {kind} has no entry for {value}; there are {', '.join(map(str, table))}")
        return table[value]
    return value


TABLES: dict[str, Callable[[str], Raw]] = {
    "BooleanMappingTransformation": lambda text: text in ("true", "1"),
    "IntegerMappingTransformation": int,
    "EnumerationMappingTransformation": str,
}
