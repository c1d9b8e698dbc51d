"""terminalsAndIcons.xml of FMI 3.0: FMUs that go together are connected by one terminal of each."""

import itertools
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import pytest
from lxml import etree

from amb_cosim.cosim.fmu.fmus import model_source
from fmi_export.building.arrays import slots
from fmi_export.building.terminals import terminals

MODELS = ("rolac_controller", "amb_actuator", "rotor_contact")


@pytest.fixture(scope="module")
def interfaces():
    return {name: model_source(name)[0].interface for name in MODELS}


def test_terminals_follow_the_schema_of_fmi_3(interfaces):
    schema = etree.XMLSchema(file=Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd")
    for table in interfaces.values():
        schema.assertValid(etree.fromstring(terminals(table)))


def test_terminal_members_of_equal_name_are_the_connections(interfaces):
    causality = {name: {s.name: s.variables[0].causality for s in slots(table)} for name, table in interfaces.items()}
    members = {}
    for name, table in interfaces.items():
        (terminal,) = ElementTree.fromstring(terminals(table)).iterfind("Terminals/Terminal")
        assert (terminal.get("name"), terminal.get("matchingRule")) == ("signals", "bus")
        members[name] = {member.get("memberName"): member.get("variableName") for member in terminal}
    joined = {
        (one, other, name)
        for one, other in itertools.permutations(MODELS, 2)
        for name in members[one].keys() & members[other].keys()
        if causality[one][members[one][name]] == "output"
    }
    axes = [(bearing, axis) for bearing in ("mb1", "mb2") for axis in "xy"]
    expected = {("rolac_controller", "amb_actuator", f"{b}.i_{a}") for b, a in axes}
    expected |= {("rotor_contact", "amb_actuator", f"{b}.{a}") for b, a in axes}
    expected |= {
        ("amb_actuator", "rotor_contact", f"{b}.{v}") for b, a in axes for v in (f"f_{a}", f"k_{a}{a}", f"{a}_ref")
    }
    expected |= {("rotor_contact", "rolac_controller", name) for name in ("sensors", "theta", "contact_state")}
    assert joined == expected
    assert all(causality[other][members[other][name]] == "input" for _, other, name in joined)
