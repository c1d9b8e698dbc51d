"""Writes modelDescription.xml from a model's variable table; the file is the same for every flavour of FMU."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fmi_export.building.units import DISPLAYED, NOMINAL, base_unit, display_unit
from fmi_export.log_categories import LOG_CATEGORIES
from fmi_export.model import Model
from fmi_export.variables import LARGEST, TOOL, Variable

EPOCH = "SOURCE_DATE_EPOCH"  # environment variable: time of the build in s since 1970; default: no time


def model_description(
    model: Model, guid: str, tool: str, version: str, needs_tool: bool = True, sources: Sequence[str] = ()
) -> Element:
    """Return the root element of the FMI 2.0 co-simulation description of `model`.

    Variables are in the order of the table, and their positions are the value references. Outputs are `calculated` and
    listed with the inputs on which they depend without delay. They are also the initial unknowns, with the dependencies
    of their initial values if the table declares these. `sources` are the names of the C files from which the FMU can
    be compiled.
    """
    root = Element("fmiModelDescription", fmiVersion="2.0", guid=guid)
    states = ("canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate", "canSerializeFMUstate")
    abilities = (*states, "providesDirectionalDerivative")
    describe(root, model, tool, version, needs_tool, abilities, _enumeration)
    if sources:
        files = SubElement(root[0], "SourceFiles")  # of CoSimulation
        for name in sources:
            SubElement(files, "File", name=name)
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(model.interface.variables):
        variables.append(_scalar_variable(reference, variable))

    index = {v.name: str(i + 1) for i, v in enumerate(model.interface.variables)}
    structure = SubElement(root, "ModelStructure")
    outputs = SubElement(structure, "Outputs")
    for v in model.interface.of("output"):
        SubElement(outputs, "Unknown", index=index[v.name], dependencies=" ".join(index[n] for n in v.depends_on))
    unknowns = SubElement(structure, "InitialUnknowns")
    for v in model.interface.of("output"):
        unknown = SubElement(unknowns, "Unknown", index=index[v.name])
        if v.name in model.interface.initial_dependencies:
            unknown.set("dependencies", " ".join(index[n] for n in model.interface.initial_dependencies[v.name]))
        if v.initially_equals:
            unknown.set("dependenciesKind", "constant")
    return root


def xml_file(root: Element) -> bytes:
    """Return the content of an XML file with this root element."""
    indent(root)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True))


def describe(
    root: Element,
    model: Model,
    tool: str,
    version: str,
    needs_tool: bool,
    abilities: tuple[str, ...],
    enumeration: Callable[[Element, str], Element],
    *further: str,
) -> None:
    """Add everything that precedes the variables, for any version of FMI.

    Parameters
    ----------
    abilities
        Names of the co-simulation attributes that are true, as spelt in this version of FMI.
    enumeration
        Function that adds an Enumeration with this name to the types, and returns the element for its items.
    further
        Units to add to those of the variables.
    """
    root.attrib |= {
        "modelName": model.name,
        "description": model.description,
        "license": "BSD-3-Clause",
        "version": version,
        "generationTool": tool,
        "variableNamingConvention": "structured",
    }
    if model.author:
        root.set("author", model.author)
    if epoch := os.environ.get(EPOCH):
        root.set("generationDateAndTime", datetime.fromtimestamp(int(epoch), UTC).strftime("%Y-%m-%dT%H:%M:%SZ"))
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        needsExecutionTool=str(needs_tool).lower(),
        canHandleVariableCommunicationStepSize=str(model.variable_step).lower(),
        canBeInstantiatedOnlyOncePerProcess="false",
    ).attrib.update(dict.fromkeys(abilities, "true"))
    _add_units(root, model, *further)
    types = SubElement(root, "TypeDefinitions") if model.interface.enumerations else root
    for entry in model.interface.enumerations.values():
        items = enumeration(types, entry.name)
        for number, (name, description) in enumerate(entry.items):
            item = SubElement(items, "Item", name=name, value=str(number))
            if description:
                item.set("description", description)
    categories = SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=description)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize=repr(model.step_size))


def identity_of(v: Variable, name: str, reference: int, description: str) -> dict[str, str]:
    """Return a variable's identifying attributes; an array shares all but the first three with its first element."""
    attributes = {
        "name": name,
        "valueReference": str(reference),
        "description": description,
        "causality": v.causality,
        "variability": v.variability,
    }
    if v.causality != "input":
        attributes["initial"] = "exact" if v.causality == "parameter" else "calculated"
    return attributes


def range_of(v: Variable) -> dict[str, str]:
    """Return the type attributes that a variable has: units, nominal value, limits and Enumeration."""
    values: dict[str, str] = {}
    if v.type == "Real":
        values["unit"] = v.unit
        if display_unit_of(v):
            values["displayUnit"] = display_unit_of(v)
        if v.unit in NOMINAL and v.causality != "parameter":
            values["nominal"] = repr(NOMINAL[v.unit])
    if v.type != "Boolean":
        if v.minimum > -LARGEST:
            values["min"] = v.literal(v.minimum)
        if v.maximum < LARGEST:
            values["max"] = v.literal(v.maximum)
    return values | ({"declaredType": v.enumeration.name} if v.enumeration else {})


def _add_units(root: Element, model: Model, *further: str) -> None:
    """Add the units and the display units of the variables, and the `further` units."""
    reals = [v for v in model.interface.variables if v.type == "Real"]
    definitions = SubElement(root, "UnitDefinitions")
    for unit in sorted({*further, *(v.unit for v in reals)}):
        definition = SubElement(definitions, "Unit", name=unit)
        SubElement(definition, "BaseUnit", _numbers(base_unit(unit)))
        for name in sorted({display_unit_of(v) for v in reals if v.unit == unit} - {""}):
            SubElement(definition, "DisplayUnit", {"name": name} | _numbers(display_unit(unit, name)))


def _numbers(values: Mapping[str, float]) -> dict[str, str]:
    return {name: repr(value) for name, value in values.items()}


def display_unit_of(v: Variable) -> str:
    """Return the display unit of a Real, or an empty text if its values are displayed in its own unit."""
    return v.display_unit or DISPLAYED.get(v.unit, "")


def _enumeration(types: Element, name: str) -> Element:
    return SubElement(SubElement(types, "SimpleType", name=name), "Enumeration")


def _scalar_variable(reference: int, v: Variable) -> Element:
    element = Element("ScalarVariable", identity_of(v, v.name, reference, v.description))
    start = {} if v.causality == "output" else {"start": v.literal(v.start)}
    SubElement(element, "Enumeration" if v.enumeration else v.type, start | range_of(v))
    if v.warning or v.over_step != "end":
        tool = SubElement(SubElement(element, "Annotations"), "Tool", name=TOOL)
        if v.warning:
            SubElement(tool, "Warning", sentence=v.warning)
        if v.over_step != "end":
            SubElement(tool, "OverStep", rule=v.over_step)
    return element
