"""FMUs with a scenario's values, wired by hand in FMPy: the run of the orchestrator, to the last bit."""

import math
from typing import Any

import fmpy
import pytest
from fmpy.fmi2 import FMU2Slave
from host_marks import in_host
from strange_machine import LEVITATION

import amb_cosim
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from tests.support.messages import raises_naming

SCENARIO = Scenario.load(LEVITATION).changed(settle_cycles=0, end_cycle=4)


class Component:
    """An FMU as a script has it: values by name."""

    def __init__(self, path, folder):
        description = fmpy.read_model_description(path)
        self.variables = {v.name: v for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(path, folder / path.stem),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=path.stem,
        )
        self.fmu.instantiate()
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()

    def get(self, name) -> Any:
        v = self.variables[name]
        return getattr(self.fmu, f"get{v.type.replace('Enumeration', 'Integer')}")([v.valueReference])[0]

    def set(self, name, value):
        v = self.variables[name]
        getattr(self.fmu, f"set{v.type.replace('Enumeration', 'Integer')}")([v.valueReference], [value])


def wired_by_hand(files, wires, names, h, steps, folder):
    """Controller, actuator and plant in turn; only connected inputs are set."""
    fmus = {path.stem: Component(path, folder) for path in files}

    def feed(target):
        for source, end in wires:
            component, name = end.split(".", 1)
            if component == target:
                origin, output = source.split(".", 1)
                fmus[target].set(name, fmus[origin].get(output))

    for component in list(fmus) * 3:
        feed(component)
    for component in fmus.values():
        component.fmu.exitInitializationMode()
    record = {name: [] for name in names}
    for n in range(steps + 1):
        for component in fmus if n else ():
            feed(component)
            fmus[component].fmu.doStep((n - 1) * h, h)
        for name, values in record.items():
            component, output = name.split(".", 1)
            values.append(fmus[component].get(output))
    for component in fmus.values():
        component.fmu.terminate()
        component.fmu.freeInstance()
    return record


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return amb_cosim.build(tmp_path_factory.mktemp("by_hand"), scenario=SCENARIO)


@in_host("FMPy", "three of a scenario, wired by hand")
def test_hand_wired_fmus_equal_the_orchestrator_to_the_last_bit(files, tmp_path):
    ours = amb_cosim.run(SCENARIO, progress=False)
    plan = prepare_run(SCENARIO)
    assert plan.last == 320
    outputs = [name for name in plan.recorded if name not in plan.inputs]
    wires = [(link.source, link.target) for link in plan.system.connections]
    theirs = wired_by_hand(files, wires, outputs, plan.step_size, plan.last, tmp_path)
    assert len(outputs) > 60
    assert [name for name in outputs if theirs[name] != ours.signals[name].values.tolist()] == []
    assert 1e-7 < max(map(abs, theirs["rotor_contact.north.x"])) < 1e-4


def test_exported_descriptions_have_the_values_of_the_scenario(files):
    starts = {path.stem: {v.name: v.start for v in fmpy.read_model_description(path).modelVariables} for path in files}
    assert list(starts) == ["rolac_controller", "amb_actuator", "rotor_contact"]
    assert float(starts["rolac_controller"]["sample_time"]) == pytest.approx(50e-6, rel=1e-15)
    assert float(starts["rotor_contact"]["Omega"]) == pytest.approx(15000.0 * math.pi / 30.0, rel=1e-15)
    assert float(starts["rotor_contact"]["turbine.u"]) == pytest.approx(0.5e-6, rel=1e-15)
    assert starts["rolac_controller"]["rolac_enable"] == "false"
    assert starts["amb_actuator"]["force_law"] == "2"  # nonlinear
    assert (starts["rotor_contact"]["gravity"], starts["rotor_contact"]["gravity_angle"]) == (
        "9.81",
        "4.71238898038469",
    )


def test_exported_default_experiments_have_the_steps_of_the_scenario(files):
    for path in files:
        assert float(fmpy.read_model_description(path).defaultExperiment.stepSize) == 50e-6
        assert [item.is_equal for item in amb_cosim.verify(path)] == [True]


def test_exported_fmus_have_the_names_of_their_components(tmp_path):
    law = tmp_path / "law.toml"
    law.write_text((LEVITATION.parents[2] / "examples/controllers/lead_notches.toml").read_text("utf-8"), "utf-8")
    scenario = Scenario.load("compressor_levitated").changed(fmu={"rolac_controller": str(law)})
    files = amb_cosim.build(tmp_path / "fmus", scenario=scenario)
    assert [path.name for path in files] == ["rolac_controller.fmu", "amb_actuator.fmu", "rotor_contact.fmu"]
    assert fmpy.read_model_description(files[0]).modelName == "linear_controller"


def test_values_of_a_scenario_cannot_be_exported_into_a_foreign_fmu(tmp_path):
    (tmp_path / "mine.fmu").touch()
    with raises_naming(ValueError, "amb_actuator", "models"):
        amb_cosim.build(tmp_path / "fmus", scenario=SCENARIO.changed(fmu={"amb_actuator": str(tmp_path / "mine.fmu")}))
    assert not (tmp_path / "fmus").exists()
