"""modelDescription.xml of a model, from its variable table alone; the same for every flavour of FMU."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fmi_export.building.units import DISPLAYED, base_unit, display_unit
from fmi_export.log_categories import LOG_CATEGORIES
from fmi_export.model import Model
from fmi_export.variables import LARGEST, TOOL, Variable


def model_description(model: Model, guid: str, tool: str, version: str, needs_tool: bool = True) -> Element:
    """Return the root element of the FMI 2.0 co-simulation description of `model`.

    Variables come in table order with value reference = position; outputs are `calculated`, listed with the
    inputs they depend on without delay. They are the initial unknowns, with what their initial
    values depend on as far as the table declares it.
    """
    root = Element("fmiModelDescription", {"fmiVersion": "2.0", "guid": guid, **own_attributes(model, tool, version)})
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        needsExecutionTool=str(needs_tool).lower(),
        canHandleVariableCommunicationStepSize=str(model.variable_step).lower(),
        canBeInstantiatedOnlyOncePerProcess="false",
        canNotUseMemoryManagementFunctions="true",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
    )
    add_units(root, model)
    _add_enumerations(root, model)
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize=repr(model.step_size))

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
        if v.starts_as:
            unknown.set("dependenciesKind", "constant")
    return root


def xml_file(root: Element) -> bytes:
    """Return the content of a modelDescription.xml."""
    indent(root)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True))


def own_attributes(model: Model, tool: str, version: str) -> dict[str, str]:
    """Return the attributes of the root element that every version of FMI has."""
    return {
        "modelName": model.name,
        "description": model.description,
        "license": "BSD-3-Clause",
        "version": version,
        "generationTool": tool,
        "variableNamingConvention": "structured",
    }


def add_log_categories(root: Element) -> None:
    """Add the categories of the log."""
    categories = SubElement(root, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=description)


def add_units(root: Element, model: Model, *further: str) -> None:
    """Add the units of the variables, what they are shown in, and further units."""
    reals = [v for v in model.interface.variables if v.type == "Real"]
    definitions = SubElement(root, "UnitDefinitions")
    for unit in sorted({*further, *(v.unit for v in reals)}):
        definition = SubElement(definitions, "Unit", name=unit)
        SubElement(definition, "BaseUnit", _numbers(base_unit(unit)))
        for shown in sorted({shown_in(v) for v in reals if v.unit == unit} - {""}):
            SubElement(definition, "DisplayUnit", {"name": shown} | _numbers(display_unit(unit, shown)))


def _numbers(values: Mapping[str, float]) -> dict[str, str]:
    return {name: repr(value) for name, value in values.items()}


def shown_in(v: Variable) -> str:
    """Return the display unit of a Real, empty where that is its unit."""
    return v.display_unit or DISPLAYED.get(v.unit, "")


def _add_enumerations(root: Element, model: Model) -> None:
    if not model.interface.enumerations:
        return
    definitions = SubElement(root, "TypeDefinitions")
    for enumeration in model.interface.enumerations.values():
        items = SubElement(SubElement(definitions, "SimpleType", name=enumeration.name), "Enumeration")
        for number, (name, description) in enumerate(enumeration.items):
            item = SubElement(items, "Item", name=name, value=str(number))
            if description:
                item.set("description", description)


def _scalar_variable(reference: int, v: Variable) -> Element:
    attributes = {
        "name": v.name,
        "valueReference": str(reference),
        "description": v.description,
        "causality": v.causality,
        "variability": v.variability,
    }
    if v.causality != "input":
        attributes["initial"] = "exact" if v.causality == "parameter" else "calculated"
    element = Element("ScalarVariable", attributes)
    value: dict[str, str] = {}
    if v.causality != "output":
        value["start"] = v.literal(v.start)
    if v.type == "Real":
        value["unit"] = v.unit
        if shown_in(v):
            value["displayUnit"] = shown_in(v)
    if v.type != "Boolean":
        if v.minimum > -LARGEST:
            value["min"] = v.literal(v.minimum)
        if v.maximum < LARGEST:
            value["max"] = v.literal(v.maximum)
    if v.enumeration:
        SubElement(element, "Enumeration", {"declaredType": v.enumeration.name} | value)
    else:
        SubElement(element, v.type, value)
    if v.warning:
        SubElement(SubElement(SubElement(element, "Annotations"), "Tool", name=TOOL), "Warning", sentence=v.warning)
    return element
