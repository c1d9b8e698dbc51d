"""A table of receptances made in Python in the place of its file: the same controller, and no file between them."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from rig import random_receptance

import amb_cosim
from amb_cosim.export.planned import plan_models
from amb_cosim.model_constants.receptance_file import empty_table
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.scenario.scenario import Scenario
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

RIG = Scenario.load("fig5_6")


@pytest.fixture(scope="module")
def table():
    """A table of the rig in the loop of the scenario, with receptances that no rotor has."""
    rotor, prepared = load_rotor(RIG.rotor), plan_models(RIG)
    table = empty_table(rotor.name, control_loop(rotor), prepared.plan.parameters[CONTROLLER])
    return table.updated(60.0, random_receptance(3)).updated(100.0, random_receptance(4))


def constants_of(**fields):
    return plan_models(RIG.changed(**fields)).made[CONTROLLER][1]


def test_table_made_in_python_gives_the_controller_of_its_file(table, tmp_path):
    table.write(tmp_path / "t.toml")
    expected = constants_of(receptances=str(tmp_path / "t.toml"))
    np.testing.assert_array_equal(constants_of(receptances=table), expected)
    assert len(expected) < len(constants_of())


def test_text_of_a_table_has_all_digits_of_a_receptance(table):
    first, *others = table.entries
    other = replace(table, entries=(replace(first, receptance=first.receptance * (1.0 + 2.0**-52)), *others))
    assert repr(other) != repr(table), "models are cached by it"


def test_a_scenario_keeps_its_table_through_changes_and_processes(table):
    scenario = RIG.changed(receptances=table).changed(Omega=500.0)
    assert scenario.receptances is table
    assert repr(pickle.loads(pickle.dumps(scenario)).receptances) == repr(table)


def test_a_table_of_another_rotor_or_loop_is_refused(table):
    with raises_naming(ValueError, "'other'", f"{table.rotor!r}"):
        plan_models(RIG.changed(receptances=replace(table, rotor="other")))
    with raises_naming(ValueError, "sample_time", "identify again"):
        parameters = {CONTROLLER: {"sample_time": "500 us"}}
        plan_models(RIG.changed(receptances=table, parameters=parameters))


def test_a_scenario_with_a_table_made_in_python_is_not_written(table, tmp_path):
    with raises_naming(ValueError, "receptances", f"{table.rotor!r}", "Python"):
        RIG.changed(receptances=table).save(tmp_path / "saved.toml")
    assert not (tmp_path / "saved.toml").exists()


@pytest.mark.slow
def test_a_run_takes_a_table_as_an_argument(table):
    result = amb_cosim.run(RIG.changed(settle_cycles=0), receptances=table, until=0.001, progress=False)
    assert "[[receptance]]" in result.signals.attrs["scenario_data"]
