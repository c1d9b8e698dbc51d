"""The modelDescription.xml of a built FMU."""

import sys
import zipfile
from xml.etree import ElementTree

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from rig import ACTUATOR

from fmi_export.building.description import model_description
from fmi_export.building.description3 import model_description3
from fmi_export.building.integers import with_integers
from fmi_export.building.python_fmu import python_guid
from fmi_export.building.units import base_unit

LARGEST = sys.float_info.max  # of a variable without limits


def xml_of(path):
    with zipfile.ZipFile(path) as archive:
        return archive.read("modelDescription.xml")


@pytest.fixture(scope="module", params=["lag", "actuator"])
def model(request):
    return request.getfixturevalue("lag") if request.param == "lag" else ACTUATOR


@pytest.fixture(scope="module")
def fmu(model, build_fmu):
    return build_fmu(model)


def test_fmpy_finds_no_problem(fmu):
    assert validate_fmu(str(fmu)) == []


@pytest.mark.parametrize(("epoch", "time"), [("1700000000", "2023-11-14T22:13:20Z"), (None, None)])
def test_an_fmu_states_its_author_and_the_time_of_source_date_epoch(monkeypatch, epoch, time):
    """SOURCE_DATE_EPOCH sets the build time, so that the same commit gives the same bytes."""
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    if epoch:
        monkeypatch.setenv("SOURCE_DATE_EPOCH", epoch)
    for describe in (model_description(ACTUATOR, "", "", ""), model_description3(ACTUATOR, "", "", "")):
        assert (describe.get("author"), describe.get("generationDateAndTime")) == ("The amb-cosim authors", time)


def test_different_constants_give_a_different_guid(model):
    assert python_guid(model, np.zeros(1)) != python_guid(model, np.ones(1)) != python_guid(model, np.ones(2))


def test_variables_are_in_the_order_of_the_table(model, fmu):
    described = fmpy.read_model_description(str(fmu)).modelVariables
    assert [v.name for v in described] == [v.name for v in model.interface.variables]
    for reference, (d, v) in enumerate(zip(described, model.interface.variables, strict=True)):
        assert d.valueReference == reference
        kind = "Enumeration" if v.enumeration else v.type
        assert (d.type, d.causality, d.variability) == (kind, v.causality, v.variability)
        assert d.description == v.description
        if v.type == "Real":
            assert d.unit == v.unit
        if v.causality == "output":
            assert (d.start, d.initial) == (None, "calculated")
        elif v.type != "Boolean":
            assert float(d.start) == v.start
            ends = (float(-LARGEST if d.min is None else d.min), float(LARGEST if d.max is None else d.max))
            assert ends == (v.minimum, v.maximum)


def test_displacements_currents_and_forces_have_nominal_sizes(build_fmu):
    sizes = {"m": 1e-4, "A": 1.0, "N": 1e3}
    described = fmpy.read_model_description(str(build_fmu(ACTUATOR))).modelVariables
    changing = [v for v in described if v.type == "Real" and v.causality != "parameter"]
    assert {v.unit for v in changing} >= set(sizes)
    assert {v.name: v.nominal and float(v.nominal) for v in changing} == {v.name: sizes.get(v.unit) for v in changing}
    assert {v.nominal for v in described if v.causality == "parameter"} == {None}


def test_every_unit_is_defined_with_its_base_exponents(model, fmu):
    definitions = {u.name: u.baseUnit for u in fmpy.read_model_description(str(fmu)).unitDefinitions}
    assert set(definitions) == {v.unit for v in model.interface.variables if v.type == "Real"}
    for unit, base in definitions.items():
        expected = base_unit(unit)
        for exponent in ("kg", "m", "s", "A", "rad"):
            assert getattr(base, exponent) == expected.get(exponent, 0), (unit, exponent)


def test_a_switch_is_an_enumeration_whose_values_have_names(build_fmu):
    described = {v.name: v for v in fmpy.read_model_description(str(build_fmu(ACTUATOR))).modelVariables}
    law = described["force_law"]
    assert (law.type, law.start, law.min, law.max) == ("Enumeration", "0", "0", "2")
    assert [(item.value, item.name) for item in law.declaredType.items] == [
        ("0", "linear"),
        ("1", "measured"),
        ("2", "nonlinear"),
    ]
    assert all(item.description for item in law.declaredType.items)


def test_a_copy_describes_enumerations_as_integers(build_fmu, tmp_path):
    fmu = build_fmu(ACTUATOR)
    copy = tmp_path / "copy.fmu"
    copy.write_bytes(with_integers(fmu.read_bytes()))
    assert validate_fmu(str(copy)) == []
    given, copied = (fmpy.read_model_description(str(path)) for path in (fmu, copy))
    assert (given.guid, len(given.modelVariables)) == (copied.guid, len(copied.modelVariables))
    assert copied.typeDefinitions == []
    facts = [[(v.name, v.valueReference, v.start, v.min, v.max) for v in d.modelVariables] for d in (given, copied)]
    assert facts[0] == facts[1]
    assert {v.type for v in copied.modelVariables} == {"Real", "Integer", "Boolean"}
    with zipfile.ZipFile(fmu) as before, zipfile.ZipFile(copy) as after:
        names = [name for name in before.namelist() if name != "modelDescription.xml"]
        assert all(before.read(name) == after.read(name) for name in names)


def test_no_type_has_the_name_of_a_variable(model):
    assert not set(model.interface.enumerations) & set(model.interface.position)


def test_display_units_are_those_of_the_field(build_fmu):
    description = fmpy.read_model_description(str(build_fmu(ACTUATOR)))
    shown = {v.name: v.displayUnit for v in description.modelVariables if v.type == "Real"}
    assert (shown["mb1.x"], shown["mb1.gap_x"], shown["mb1.half_angle_x"]) == ("um", "mm", "deg")
    assert (shown["mb1.bandwidth_x"], shown["mb1.f_x"], shown["mb1.k_xx"]) == (None, None, "N/um")
    factors = {u.name: {d.name: float(d.factor) for d in u.displayUnits} for u in description.unitDefinitions}
    assert factors["m"] == {"mm": 1e3, "um": 1e6}
    assert factors["rad"]["deg"] == pytest.approx(180.0 / np.pi)
    assert {
        name for name, unit in shown.items() if unit and unit not in factors[ACTUATOR.interface[name].unit]
    } == set()


def test_outputs_declare_the_inputs_that_reach_them_without_delay(model, fmu):
    structure = fmpy.read_model_description(str(fmu)).outputs
    declared = {o.variable.name: {d.name for d in o.dependencies} for o in structure}
    assert declared == {v.name: set(v.depends_on) for v in model.interface.of("output")}


def test_warnings_and_rules_over_a_step_are_declared(build_fmu, lag):
    root = ElementTree.fromstring(xml_of(build_fmu(lag)))
    declared = {
        variable.get("name"): [(item.tag, item.attrib) for item in variable.find("Annotations/Tool[@name='amb-cosim']")]
        for variable in root.iterfind("ModelVariables/ScalarVariable[Annotations]")
    }
    assert declared == {
        "steps": [("OverStep", {"rule": "largest"})],
        "high": [("Warning", {"sentence": lag.interface["high"].warning})],
    }


def test_all_outputs_are_initial_unknowns(model, fmu):
    root = ElementTree.fromstring(xml_of(fmu))
    indices = [int(u.get("index")) for u in root.iterfind("ModelStructure/InitialUnknowns/Unknown")]
    names = [model.interface.variables[i - 1].name for i in indices]
    assert names == [v.name for v in model.interface.of("output")]


def test_initial_unknowns_declare_their_dependencies(build_fmu, lag):
    actuator = {u.get("index"): u for u in ElementTree.fromstring(xml_of(build_fmu(ACTUATOR))).iter("Unknown")}
    position = {v.name: str(k) for k, v in enumerate(ACTUATOR.interface.variables, 1)}
    reference = actuator[position["mb1.x_ref"]]
    assert (reference.get("dependencies"), reference.get("dependenciesKind")) == (position["mb1.x"], "constant")
    gradient = actuator[position["mb1.k_xx"]].get("dependencies").split()
    assert {position["force_law"], position["mb1.x"], position["mb1.gap_x"]} < set(gradient)
    assert not {position["mb1.gap_y"], position["mb1.bandwidth_x"], position["mb1.f_x"]} & set(gradient)
    assert actuator[position["mb1.voltage_limited_x"]].get("dependencies") == ""
    unknowns = fmpy.read_model_description(str(build_fmu(lag))).initialUnknowns
    assert {u.variable.name: u.dependencies is None for u in unknowns}["steps"]  # nothing is declared


def test_capability_flags_match_the_slave(fmu):
    ability = fmpy.read_model_description(str(fmu)).coSimulation
    assert ability.canGetAndSetFMUstate
    assert ability.canSerializeFMUstate
    assert ability.canHandleVariableCommunicationStepSize
    assert ability.needsExecutionTool
    assert not ability.canBeInstantiatedOnlyOncePerProcess
