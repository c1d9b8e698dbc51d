"""The interface of an assembled FMU, and systems that can be assembled."""

from dataclasses import replace

import pytest

from amb_cosim.export.assembled import levitated_rotor
from amb_cosim.export.models import amb_actuator, rolac_controller, rotor_contact
from amb_cosim.scenario.scenario import load_scenario
from fmi_export.variables import FAULT_CODE
from tests.support.messages import raises_naming

PARTS = {"rolac_controller": rolac_controller, "amb_actuator": amb_actuator, "rotor_contact": rotor_contact}


@pytest.fixture(scope="module")
def table():
    return levitated_rotor("fig4_9")[0].interface


@pytest.fixture(scope="module")
def parts():
    return {name: make()[0].interface for name, make in PARTS.items()}


def test_parameters_and_outputs_of_the_parts_are_exposed(table, parts):
    for causality in ("parameter", "output"):
        expected = [
            replace(v, name=f"{part}.{v.name}", field="")
            for part, local in parts.items()
            for v in local.of(causality)
            if v.name != FAULT_CODE
        ]
        result = [v for v in table.of(causality) if v.name != FAULT_CODE]
        assert [v.name for v in result] == [v.name for v in expected]
        for v, local in zip(result, expected, strict=True):
            reached = {
                "depends_on": v.depends_on,
                "initially_depends_on": v.initially_depends_on,
                "initially_equals": v.initially_equals,
            }
            assert v == replace(local, start=v.start, warning=v.warning, array=v.array, **reached), v.name


def test_inputs_are_the_unconnected_inputs_of_the_parts(table, parts):
    names = [v.name for v in table.of("input")]
    assert names[:2] == ["Omega", "Omega_dot"]
    for name in ("rotor_contact.d1.u", "rotor_contact.d1.f_x", "amb_actuator.mb1.stuck_x", "rotor_contact.base.a_x"):
        assert name in names
    for name in ("rolac_controller.rolac_enable", "rolac_controller.s1.fault_dead", "rolac_controller.mb1.set_x"):
        assert name in names
    fed = [name for name in names if name.endswith((".i_x", ".mb1.x", ".k_xx", ".theta", ".contact_state", ".s1"))]
    assert fed == []
    every = sum(len(local.of("input")) for local in parts.values())
    connections = 4 + 4 + 4 + 8 + 8 + 2  # currents, displacements, forces, gradients, sensors, angle and contact
    assert len(names) == every - connections - 1


def test_range_of_a_shared_signal_is_that_of_all_its_inputs(table, parts):
    assert table["Omega"].maximum == parts["rolac_controller"]["Omega"].maximum
    assert table["Omega"].unit == "rad/s"


def test_direct_dependencies_pass_through_connections(table):
    reach = set(table["amb_actuator.mb1.f_x"].depends_on)
    assert {"rolac_controller.mb1.set_x", "amb_actuator.mb1.stuck_x", "rolac_controller.rolac_enable"} <= reach
    assert "rolac_controller.mb2.set_y" not in reach
    assert table["rotor_contact.mb1.x"].depends_on == ()


def test_initial_dependencies_pass_through_connections(table):
    force = set(table.initial_dependencies["amb_actuator.mb1.f_x"])
    assert {"amb_actuator.mb1.k_i_measured_x", "rolac_controller.mb1.set_x", "rolac_controller.mb1.k_b_x"} <= force
    assert "rolac_controller.mb2.k_b_y" not in force
    declared = table.initial_dependencies
    assert [v.name for v in table.of("output") if v.name not in declared] == []


def test_start_values_are_those_of_the_scenario(table):
    start = {v.name: v.start for v in table.variables}
    assert start["Omega"] == 260.0
    assert start["rotor_contact.d1.u"] == pytest.approx(0.5e-3)
    assert start["rotor_contact.contact.impact_law"] == 0
    assert start["amb_actuator.mb1.k_s_measured_x"] == 2e6
    assert start["rotor_contact.eb1.enabled"] == 0


def test_start_values_without_a_scenario_are_those_of_the_system():
    start = {v.name: v.start for v in levitated_rotor()[0].interface.variables}
    assert start["rotor_contact.contact.impact_law"] == 1
    assert start["rolac_controller.mb1.k_s_x"] == 2e6
    assert start["Omega"] == 0.0


def test_a_scenario_determines_the_rotor():
    model, _ = levitated_rotor("compressor_levitated")
    names = {v.name for v in model.interface.variables}
    rig = {v.name for v in levitated_rotor("fig4_9")[0].interface.variables}
    assert names - rig
    assert model.interface["Omega"].start == pytest.approx(load_scenario("compressor_levitated").initial_speed)


def test_a_measured_speed_is_no_input_of_the_controller():
    model, _ = levitated_rotor(load_scenario("fig4_9").changed(system="levitated_free_spin"))
    assert "Omega" in {v.name for v in model.interface.of("input")}
    assert "rolac_controller.Omega" not in {v.name for v in model.interface.variables}


def test_iterative_coupling_and_foreign_fmus_cannot_be_assembled(tmp_path):
    (tmp_path / "mine.fmu").touch()
    scenario = load_scenario("fig4_9")
    with raises_naming(ValueError, "'iterative'"):
        levitated_rotor(scenario.changed(coupling="iterative"))
    with raises_naming(ValueError, "amb_actuator", "levitated", "models"):
        levitated_rotor(scenario.changed(fmu={"amb_actuator": str(tmp_path / "mine.fmu")}))


def test_an_assembled_fmu_has_the_name_of_its_system():
    model, _ = levitated_rotor("passive")
    assert (model.name, [part.name for part in model.parts]) == ("passive", ["rotor_contact"])
    assert levitated_rotor(load_scenario("fig4_9").changed(coupling="jacobi"))[0].name == "levitated"
