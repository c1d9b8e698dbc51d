"""modelDescription.xml of a model for FMI 3.0, from its variable table, as `description` writes that of FMI 2.0."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from fmi_export.building.arrays import Slot, slots
from fmi_export.building.description import add_log_categories, add_units, own_attributes, shown_in
from fmi_export.interface import Interface
from fmi_export.model import Model
from fmi_export.variables import LARGEST, TOOL

TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}


def model_description3(model: Model, token: str, tool: str, version: str) -> Element:
    """Return the root element of the FMI 3.0 co-simulation description of `model`; `token` is the instantiation token.

    Value references are those of FMI 2.0. Arrays are as `arrays` finds them; `time`, which FMI 3.0 asks for, follows
    the last variable.
    """
    root = Element("fmiModelDescription", {"fmiVersion": "3.0", **own_attributes(model, tool, version)})
    root.set("instantiationToken", token)
    SubElement(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        needsExecutionTool="false",
        canBeInstantiatedOnlyOncePerProcess="false",
        canHandleVariableCommunicationStepSize=str(model.variable_step).lower(),
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
    )
    add_units(root, model, "s")
    _add_enumerations(root, model.interface)
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize=repr(model.step_size))
    variables = SubElement(root, "ModelVariables")
    found = slots(model.interface)
    for slot in found:
        variables.append(_variable(slot))
    SubElement(
        variables,
        "Float64",
        name="time",
        valueReference=str(len(model.interface.variables)),
        description="Simulated time",
        causality="independent",
        variability="continuous",
        unit="s",
    )
    _add_structure(SubElement(root, "ModelStructure"), model.interface, found)
    return root


def _add_enumerations(root: Element, table: Interface) -> None:
    if not table.enumerations:
        return
    definitions = SubElement(root, "TypeDefinitions")
    for enumeration in table.enumerations.values():
        items = SubElement(definitions, "EnumerationType", name=enumeration.name)
        for number, (name, description) in enumerate(enumeration.items):
            item = SubElement(items, "Item", name=name, value=str(number))
            if description:
                item.set("description", description)


def _variable(slot: Slot) -> Element:
    v = slot.variables[0]
    attributes = {
        "name": slot.name,
        "valueReference": str(slot.reference),
        "description": slot.description,
        "causality": v.causality,
        "variability": v.variability,
    }
    if v.causality != "input":
        attributes["initial"] = "exact" if v.causality == "parameter" else "calculated"
    if v.causality != "output":
        attributes["start"] = " ".join(one.literal(one.start) for one in slot.variables)
    if v.type == "Real":
        attributes["unit"] = v.unit
        if shown_in(v):
            attributes["displayUnit"] = shown_in(v)
    if v.type != "Boolean":
        if v.minimum > -LARGEST:
            attributes["min"] = v.literal(v.minimum)
        if v.maximum < LARGEST:
            attributes["max"] = v.literal(v.maximum)
    if v.enumeration:
        attributes["declaredType"] = v.enumeration.name
    element = Element("Enumeration" if v.enumeration else TYPES[v.type], attributes)
    if v.warning:
        annotation = SubElement(SubElement(element, "Annotations"), "Annotation", type=TOOL)
        SubElement(annotation, "Warning", sentence=v.warning)
    for size in slot.shape:
        SubElement(element, "Dimension", start=str(size))
    return element


def _add_structure(structure: Element, table: Interface, found: list[Slot]) -> None:
    """Add the outputs and the initial unknowns, which depend on what any element of theirs depends on.

    The initial dependencies of an output that declares none may be everything, which FMI says by leaving them out.
    """
    reference_of = {v.name: slot.reference for slot in found for v in slot.variables}
    outputs = [slot for slot in found if slot.variables[0].causality == "output"]

    def add(kind: str, slot: Slot, needs: list[tuple[str, ...] | None]) -> None:
        unknown = SubElement(structure, kind, valueReference=str(slot.reference))
        if None not in needs:
            known = sorted({reference_of[name] for names in needs for name in names or ()})
            unknown.set("dependencies", " ".join(map(str, known)))
            if kind == "InitialUnknown" and all(v.starts_as for v in slot.variables):
                unknown.set("dependenciesKind", " ".join("constant" for _ in known))

    for slot in outputs:
        add("Output", slot, [v.depends_on for v in slot.variables])
    for slot in outputs:
        add("InitialUnknown", slot, [table.initial_dependencies.get(v.name) for v in slot.variables])
