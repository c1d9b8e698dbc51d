"""Writes terminalsAndIcons.xml of FMI 3.0: groups of variables that an importer connects at once."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement

from fmi_export.building.arrays import slots
from fmi_export.building.description import xml_file
from fmi_export.interface import Interface
from fmi_export.variables import FAULT_CODE

FILE = "terminalsAndIcons/terminalsAndIcons.xml"
NAME = "signals"


def terminals(table: Interface) -> bytes:
    """Return the file with a single terminal: a bus of all inputs and outputs by name.

    In this project's models, an output has the same name as the inputs that it feeds. Connecting two buses therefore
    connects each output of one to the input of the same name in the other.
    """
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    bus = SubElement(
        SubElement(root, "Terminals"),
        "Terminal",
        name=NAME,
        matchingRule="bus",
        description="All inputs and outputs, where an output feeds the inputs of the same name",
    )
    for slot in slots(table):
        if slot.variables[0].causality != "parameter" and slot.name != FAULT_CODE:
            SubElement(
                bus, "TerminalMemberVariable", variableName=slot.name, memberName=slot.name, variableKind="signal"
            )
    return xml_file(root)
