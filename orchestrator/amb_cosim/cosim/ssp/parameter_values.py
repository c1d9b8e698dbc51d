"""Parameter sets of SSP (.ssv): values by name, each with the type of the FMU's variable."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from lxml import etree

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.ssp.schema import NAMESPACES, PARAMETERS, VERSION, document, tag
from amb_cosim.cosim.ssp.version_2 import FLOATS, INTEGERS, texts_of
from amb_cosim.cosim.system.values import Raw
from fmi_export.building.units import SI

ParameterValue = Raw | tuple[str, str]  # a number or truth value, an enumerator's name, or number and unit
READERS: dict[str, Callable[[str], Raw]] = {
    **dict.fromkeys(("Real", *FLOATS), float),
    **dict.fromkeys(("Integer", *INTEGERS), int),
    "Boolean": {"true": True, "1": True, "false": False, "0": False}.__getitem__,
    "Enumeration": str,
    "String": str,
    "Binary": str,  # hexadecimal digits
}


def parameter_set(name: str, values: Mapping[str, float], ports: Mapping[str, Port]) -> bytes:
    """Return a document with the values of a component.

    Parameters
    ----------
    name
        Name of the set.
    values
        Values by variable, in the unit of the FMU; Booleans are 0 and 1.
    ports
        The component's variables.
    """
    root = etree.Element(tag("ssv:ParameterSet"), nsmap={p: NAMESPACES[p] for p in ("ssv", "ssc")})
    root.attrib.update(dict(version=VERSION, name=name))
    parameters = etree.SubElement(root, tag("ssv:Parameters"))
    for variable, value in values.items():
        parameter = etree.SubElement(parameters, tag("ssv:Parameter"), name=variable)
        port = ports[variable]
        element = etree.SubElement(parameter, tag(f"ssv:{type_of(port)}"), value=text_of(value, port))
        if port.type == "Real" and port.unit and port.definition is not None:
            element.set("unit", port.unit)
        if port.items:
            element.set("name", variable)
    add_enumerations(root, "ssv", {variable: ports[variable] for variable in values})
    units = {p.unit: p for p in map(ports.__getitem__, values) if p.type == "Real" and p.unit and p.definition}
    add_units(etree.SubElement(root, tag("ssv:Units")) if units else None, units.values())
    return document(root, PARAMETERS)


def type_of(port: Port) -> str:
    """Return the SSP name of a variable's type."""
    return "Enumeration" if port.items else port.type


def general_type(kind: str) -> str:
    """Return the type of a variable from its SSP type `kind`: an Enumeration is an Integer, and a Float64 is a Real."""
    return {**dict.fromkeys(FLOATS, "Real"), **dict.fromkeys((*INTEGERS, "Enumeration"), "Integer")}.get(kind, kind)


def text_of(value: float, port: Port) -> str:
    """Return a value as XML text; for an Enumeration, its name."""
    if port.items:
        return next(name for name, number in port.items.items() if number == value)
    if port.type == "Boolean":
        return "true" if value else "false"
    return repr(float(value)) if port.type == "Real" else str(int(value))


def add_enumerations(root: Any, prefix: str, ports: Mapping[str, Port]) -> None:
    """Add the definitions of the Enumerations among ports, under the names of the ports in the mapping."""
    enumerations = {name: port.items for name, port in ports.items() if port.items}
    group = etree.SubElement(root, tag(f"{prefix}:Enumerations")) if enumerations else None
    for name, items in enumerations.items():
        enumeration = etree.SubElement(group, tag("ssc:Enumeration"), name=name)
        for item, value in items.items():
            etree.SubElement(enumeration, tag("ssc:Item"), name=item, value=str(value))


def add_units(parent: Any, ports: Iterable[Port]) -> None:
    """Add the definitions of the units of ports."""
    for port in ports:
        *exponents, factor, offset = port.definition or (0,) * len(SI) + (1.0, 0.0)
        unit = etree.SubElement(parent, tag("ssc:Unit"), name=port.unit or "1")
        base = {name: str(int(power)) for name, power in zip(SI, exponents, strict=True) if power}
        base |= {"factor": repr(factor)} if factor != 1.0 else {}
        base |= {"offset": repr(offset)} if offset != 0.0 else {}
        etree.SubElement(unit, tag("ssc:BaseUnit"), base)


def read_parameters(root: Any, what: str) -> dict[str, list[ParameterValue]]:
    """Return the values of a parameter set by name, each of them a single value or the values of an array, row by row.

    Raises
    ------
    ValueError
        For an unsupported type, or a value that does not match its type.
    """
    parameters: dict[str, list[ParameterValue]] = {}
    for parameter in root.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
        name, element = parameter.get("name"), parameter[0]
        kind = etree.QName(element).localname
        try:
            texts = texts_of(element) if kind == "String" else [text.strip() for text in texts_of(element)]
            parameters[name] = [_value(kind, text, element.get("unit")) for text in texts]
        except (KeyError, ValueError) as error:
            problem = f"= {element.get('value')!r} is not a value" if kind in READERS else "is"
            allowed = ", ".join(READERS)
            raise ValueError(f"{what}: parameter {name} {problem} of type {kind}; the types are {allowed}") from error
    return parameters


def _value(kind: str, text: str, unit: str | None) -> ParameterValue:
    value = READERS[kind](text)
    return (text, unit) if unit is not None else value
