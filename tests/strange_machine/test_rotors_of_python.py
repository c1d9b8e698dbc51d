"""A rotor made in Python in the place of a rotor file: the same runs, and no file between them."""

import json
import pickle
from dataclasses import replace

import numpy as np
import pytest
from strange_machine import LEVITATION, ROTOR

import amb_cosim
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.model_interface import interface_of
from amb_cosim.export.planned import plan_models
from amb_cosim.scenario.scenario import Scenario
from amb_files.archive import unpack
from amb_files.toml import validate
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

SHORT = Scenario.load(LEVITATION).changed(settle_cycles=0, end_cycle=4)


@pytest.fixture(scope="module")
def rotor():
    return load_rotor(ROTOR)


def table_of(result):
    return np.array([result.signals[name].values for name in result.signals.variables])


def test_rotor_made_in_python_runs_as_its_file_to_the_last_bit(rotor):
    of_file, of_object = amb_cosim.run(SHORT), amb_cosim.run(SHORT, rotor=rotor)
    assert np.array_equal(table_of(of_file), table_of(of_object), equal_nan=True)


def test_a_scenario_keeps_its_rotor_through_changes_and_processes(rotor):
    scenario = SHORT.changed(rotor=rotor).changed(Omega=500.0)
    assert scenario.rotor is rotor
    assert pickle.loads(pickle.dumps(scenario)) == scenario


def test_the_data_of_a_run_contain_the_whole_rotor(rotor):
    data = json.loads(amb_cosim.run(SHORT, rotor=rotor).dataset.attrs["scenario_data"])
    assert validate(data["rotor"], Rotor, "rotor") == rotor


def test_a_scenario_with_a_rotor_made_in_python_is_not_written(rotor, tmp_path):
    with raises_naming(ValueError, "'expander'", "Python"):
        SHORT.changed(rotor=rotor).save(tmp_path / "saved.toml")
    assert not (tmp_path / "saved.toml").exists()


def test_tables_of_a_file_and_of_a_rotor_are_changed_alike(rotor):
    tables = {"shaft": {"mass_matrix": "consistent"}, "reduction": {"accuracy": 1e-4}}
    assert load_rotor(rotor, tables) == load_rotor(ROTOR, tables) != rotor


def test_the_interface_of_a_model_equals_that_of_its_fmu(tmp_path):
    prepared = plan_models(LEVITATION)
    for file in amb_cosim.build(tmp_path, scenario=LEVITATION, flavour="python"):
        unpack(file, tmp_path / file.stem, file.stem)
        of_file = read_interface(tmp_path / file.stem, file.stem)
        of_model = interface_of(prepared.made[file.stem][0])
        assert [(p.name, p.unit, p.minimum, p.definition) for p in of_model.ports.values()] == [
            (p.name, p.unit, p.minimum, p.definition) for p in of_file.ports.values()
        ]
        given = {
            "guid": of_file.guid,
            "version": of_file.version,
            "internal_step": of_file.internal_step,
        }  # of the FMU alone
        starts = {name: replace(p, start=of_file.ports[name].start) for name, p in of_model.ports.items()}
        assert replace(of_model, ports=starts, **given) == of_file
