"""A controller made in Python replaces an FMU in scenarios and systems, without a file."""

import pickle

import numpy as np
import pytest

import amb_cosim
from amb_cosim.cosim.system.assembly import assemble
from amb_cosim.cosim.system.differences import LARGEST, described
from amb_cosim.scenario.prepare_run import assemble_scenario, system_of
from amb_files.user_cache import user_cache
from tests.support.messages import raises_naming

AXES = [f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
DEMANDS = [f"{bearing}.i_{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]


def proportional(gain):
    return amb_cosim.linear_controller(-gain * np.eye(4), AXES, DEMANDS, 1e-4, sampled_arrays=True)


@pytest.fixture
def scenario():
    return amb_cosim.Scenario.load("compressor_levitated")


def fmu_of(scenario, controller):
    """Return the archive of the FMU that implements the scenario's controller."""
    changed = scenario.changed(fmu={"rolac_controller": controller})
    return assemble_scenario(changed).fmus["rolac_controller"].path.read_bytes()


def test_controller_needs_no_file(scenario, tmp_path):
    """The FMU is that of its file, and the cache has no `.npz`."""
    before = {*user_cache().glob("*.npz")}
    controller = proportional(2e4)
    assert fmu_of(scenario, controller) == fmu_of(scenario, str(controller.save(tmp_path / "law.npz")))
    assert {*user_cache().glob("*.npz")} == before


def test_each_law_has_its_fmu(scenario):
    laws = proportional(2e4), proportional(3e4)
    assert fmu_of(scenario, laws[0]) != fmu_of(scenario, laws[1])
    assert repr(laws[0]) == repr(proportional(2e4)) != repr(laws[1])
    assert repr(pickle.loads(pickle.dumps(laws[0]))) == repr(laws[0])


def test_controller_runs_in_a_system_file(scenario):
    system = system_of(scenario).with_fmu("rolac_controller", proportional(2e4))
    assembly = assemble(system, rotor=scenario.rotor)
    assert {*AXES} <= assembly.interfaces["rolac_controller"].ports.keys()


def test_sources_of_a_run_describe_the_law(scenario):
    sources = assemble_scenario(scenario.changed(fmu={"rolac_controller": proportional(2e4)})).sources
    name, content = sources["file of rolac_controller"]
    assert name == "LinearController of Python"
    assert content["laws"]["0.0"]["D"][0][0] == -2e4
    rows = round(LARGEST**0.5) + 1
    law = np.eye(rows) / 2.0, np.ones((rows, 1)), np.ones((1, rows)), np.zeros((1, 1))
    _, content = described(amb_cosim.linear_controller(law, AXES[:1], DEMANDS[:1], 1e-4, sampled_arrays=True))
    assert len(content["laws"]["0.0"]["A"]) == 64  # hexadecimal digits


def test_a_scenario_with_a_controller_of_python_is_not_written(scenario, tmp_path):
    changed = scenario.changed(fmu={"rolac_controller": proportional(2e4)}).changed(end_cycle=2)
    with raises_naming(ValueError, "fmu.rolac_controller", "linear_controller"):
        changed.save(tmp_path / "own.toml")
    assert "LinearController(" in changed.model_dump_json()
