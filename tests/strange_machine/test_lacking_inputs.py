"""Events and initial values of inputs that a replaced FMU lacks: an error, or the first warning."""

from pathlib import Path

import pytest
from strange_machine import LEVITATION, ROTOR, SYSTEM, TOUCHDOWN

import amb_cosim
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from tests.support.changed_archive import with_text
from tests.support.messages import assert_names, raises_naming


@pytest.fixture(scope="module")
def actuator(tmp_path_factory) -> Path:
    """An actuator with another name for the input that switches off the amplifier of one axis."""
    folder = tmp_path_factory.mktemp("actuator")
    amb_cosim.build(folder, rotor=ROTOR)
    made, own = folder / "amb_actuator.fmu", folder / "own_actuator.fmu"
    return with_text(made, own, "modelDescription.xml", 'name="north.amplifier_off_x"', 'name="north.off_x"')


def with_event(actuator: Path, **values: float | bool) -> Scenario:
    event = {"label": "step", "role": "disturbance", "cycle": 2, "set": {"amb_actuator": values}}
    return Scenario.load(LEVITATION).changed(event=[event], fmu={"amb_actuator": str(actuator)}, end_cycle=4)


def test_an_event_without_any_variable_is_refused(actuator):
    scenario = with_event(actuator, **{"north.amplifier_off_x": True})
    facts = ("event step", "0.008 s", "amb_actuator (own_actuator.fmu)")
    with raises_naming(ValueError, *facts, "north.amplifier_off_x", "north.amplifier_off_y"):
        prepare_run(scenario)


def test_an_event_without_effect_is_refused_beside_others_at_its_time(actuator):
    scenario = with_event(actuator, **{"north.amplifier_off_x": True})
    other = {"cycle": 2, "set": {"rotor_contact": {"turbine.u": "1 g.mm"}}}
    with raises_naming(ValueError, "event step"):
        prepare_run(scenario.changed(event=[other, *(event.model_dump(exclude_none=True) for event in scenario.event)]))


def test_inputs_that_an_event_lacks_are_the_first_warning(actuator):
    """Both bearings touch where both lose their power; the other warnings of such a run come later."""
    scenario = Scenario.load(TOUCHDOWN).changed(fmu={"amb_actuator": str(actuator)}, end_cycle=8)
    off = {"north.amplifier_off_x": True, "north.amplifier_off_y": True, "south.amplifier_off_y": True}
    event = {"label": "step", "role": "disturbance", "cycle": 2, "set": {"amb_actuator": off}}
    warnings = amb_cosim.run(scenario.changed(event=[event])).summary.warnings
    assert len(warnings) > 1
    assert_names(warnings[0], "event step", "0.008 s", "amb_actuator (own_actuator.fmu)")
    assert "north.amplifier_off_x" in warnings[0]


@pytest.mark.parametrize("value", [True, 1, "2 A", "1e-3"])
def test_an_initial_value_without_effect_is_refused(actuator, value):
    first = {"amb_actuator": {"north.amplifier_off_x": value}}
    scenario = Scenario.load(LEVITATION).changed(fmu={"amb_actuator": str(actuator)}, inputs=first)
    with raises_naming(ValueError, "initial value", "amb_actuator.north.amplifier_off_x"):
        prepare_run(scenario)


@pytest.mark.parametrize("value", [False, 0, "0 A", "-0.0", "false"])
def test_an_initial_value_of_zero_is_dropped_with_a_notice(actuator, value):
    first = {"amb_actuator": {"north.amplifier_off_x": value}}
    scenario = Scenario.load(LEVITATION).changed(fmu={"amb_actuator": str(actuator)}, inputs=first)
    dropped = "amb_actuator: own_actuator.fmu has no north.amplifier_off_x; such settings are ignored"
    assert dropped in prepare_run(scenario).notices


def test_an_event_of_a_system_file_is_refused_alike(actuator, tmp_path):
    system = tmp_path / "own.toml"
    system.write_text(
        f"""
        base = "{SYSTEM}"
        [[component]]
        name = "amb_actuator"
        fmu = "{actuator}"
        [experiment]
        communication_step = "50 us"
        stop_time = "1 ms"
        [[experiment.event]]
        time = "0.5 ms"
        set = {{ "amb_actuator.north.amplifier_off_x" = true }}
        """,
        encoding="utf-8",
    )
    with raises_naming(ValueError, "event 1", "0.0005 s", "amb_actuator (own_actuator.fmu)"):
        amb_cosim.simulate(system, rotor=ROTOR)
