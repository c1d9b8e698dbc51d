"""Writes modelDescription.xml for FMI 3.0 from a model's variable table; `description` does so for FMI 2.0."""

from __future__ import annotations

import json
from xml.etree.ElementTree import Element, SubElement

from fmi_export.building.arrays import Slot, slots
from fmi_export.building.description import describe, identity_of, range_of
from fmi_export.interface import Interface
from fmi_export.model import Model
from fmi_export.variables import TOOL

NOTES = f"extra/{TOOL}/variables.json"
TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}


def model_description3(model: Model, token: str, tool: str, version: str) -> Element:
    """Return the root element of the FMI 3.0 co-simulation description of `model`; `token` is the instantiation token.

    Value references are the same as in FMI 2.0; `arrays.slots` forms the arrays. The variable `time`, which FMI 3.0
    requires, is added after the last variable.
    """
    root = Element("fmiModelDescription", fmiVersion="3.0", instantiationToken=token)
    states, derivatives = ("canGetAndSetFMUState", "canSerializeFMUState"), ("Directional", "Adjoint")
    abilities = (*states, *(f"provides{kind}Derivatives" for kind in derivatives))
    describe(root, model, tool, version, False, abilities, _enumeration, "s")
    variables = SubElement(root, "ModelVariables")
    table_slots = slots(model.interface)
    for slot in table_slots:
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
    _add_structure(SubElement(root, "ModelStructure"), model.interface, table_slots)
    return root


def variable_notes(table: Interface) -> bytes:
    """Return the file `NOTES` with warnings, rules over a step, and FMI 2.0 names and descriptions of array elements.

    The notes are listed by the names of the variables. They are not written as annotations, because FMI Library reports
    annotations of FMI 3.0 as unknown.
    """
    result: dict[str, dict[str, object]] = {}
    for slot in slots(table):
        if sentence := slot.variables[0].warning:
            result.setdefault(slot.name, {})["warning"] = sentence
        if (rule := slot.variables[0].over_step) != "end":
            result.setdefault(slot.name, {})["over_step"] = rule
        if slot.shape:
            result.setdefault(slot.name, {})["elements"] = [[item.name, item.description] for item in slot.variables]
    return json.dumps(result, indent=1).encode()


def _enumeration(types: Element, name: str) -> Element:
    return SubElement(types, "EnumerationType", name=name)


def _variable(slot: Slot) -> Element:
    v = slot.variables[0]
    attributes = identity_of(v, slot.name, slot.reference, slot.description)
    if v.causality != "output":
        attributes["start"] = " ".join(item.literal(item.start) for item in slot.variables)
    element = Element("Enumeration" if v.enumeration else TYPES[v.type], attributes | range_of(v))
    for size in slot.shape:
        SubElement(element, "Dimension", start=str(size))
    return element


def _add_structure(structure: Element, table: Interface, slots: list[Slot]) -> None:
    """Add the outputs and the initial unknowns; an array has the union of the dependencies of its elements.

    An output without declared initial dependencies may depend on everything; FMI expresses this by omitting the
    dependencies.
    """
    reference_of = {v.name: slot.reference for slot in slots for v in slot.variables}
    outputs = [slot for slot in slots if slot.variables[0].causality == "output"]

    def add(kind: str, slot: Slot, needs: list[tuple[str, ...] | None]) -> None:
        unknown = SubElement(structure, kind, valueReference=str(slot.reference))
        if None not in needs:
            dependencies = sorted({reference_of[name] for names in needs for name in names or ()})
            unknown.set("dependencies", " ".join(map(str, dependencies)))
            if kind == "InitialUnknown" and all(v.initially_equals for v in slot.variables):
                unknown.set("dependenciesKind", " ".join("constant" for _ in dependencies))

    for slot in outputs:
        add("Output", slot, [v.depends_on for v in slot.variables])
    for slot in outputs:
        add("InitialUnknown", slot, [table.initial_dependencies.get(v.name) for v in slot.variables])
