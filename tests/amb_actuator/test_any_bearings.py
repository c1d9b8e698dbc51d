"""Actuators of other rotors than the rig: any number of bearings, of any name."""

import textwrap
from pathlib import Path

import pytest

import amb_actuator
from amb_actuator.actuator import MAX_BEARINGS, constants_for, model_for
from amb_actuator.interface import CONSTANTS_FROM_GEOMETRY
from fmi_export.model import Fault, Instance
from tests.support.messages import raises_naming

H = 250e-6


def actuator(*bearings, thrust=""):
    return Instance(model_for(bearings, thrust), constants_for(bearings, thrust))


@pytest.mark.parametrize("count", [1, 3, 16])
def test_every_bearing_of_any_number_acts_as_a_single_one(count):
    """The same current at every axis gives the force of a bearing alone, to the last bit."""
    names = [f"bearing{k}" for k in range(count)]
    many, alone = actuator(*names), actuator("b")
    for actuators, its_names in ((many, names), (alone, ["b"])):
        actuators["force_law"], actuators["amplifier"] = 2.0, 1.0
        for name in its_names:
            actuators[f"{name}.i_x"], actuators[f"{name}.y"] = 1.5, 1e-4
        actuators.initialise()
        for n in range(5):
            for name in its_names:
                actuators[f"{name}.i_x"] = -2.0
            actuators.step(n * H, H)
    for name in names:
        for output in ("f_x", "f_y", "k_xx", "i_upper_x", "v_lower_y"):
            assert many[f"{name}.{output}"] == alone[f"b.{output}"]
    assert alone["b.f_x"] < 0.0


@pytest.mark.parametrize(
    ("setting", "value", "facts"),
    [
        ("last.y", 2e-3, ("last.y", "0.002 m", "air gap")),
        ("last.bias_current_y", 9.5, ("last.bias_current_y", "9.5 A", "last.static_current_y", "1.14 A")),
        ("last.voltage_limit_y", 1.0, ("last.voltage_limit_y", "1 V")),
    ],
)
@pytest.mark.parametrize("others", [0, 2, 6, 15])
def test_fault_of_the_last_axis_names_that_axis(others, setting, value, facts):
    instance = actuator(*(f"bearing{k}" for k in range(others)), "last")
    instance["amplifier"] = 1.0
    instance[setting] = value
    with raises_naming(Fault, *facts) as fault:
        instance.initialise()
    assert fault.value.code < 100


def test_both_linear_laws_of_an_unmeasured_bearing_agree():
    """With the same start values both linear laws then agree."""
    instance = actuator("thrust_end")
    forces = []
    for law in (0.0, 1.0):
        instance["force_law"], instance["thrust_end.x"], instance["thrust_end.i_x"] = law, 1e-4, 0.5
        instance.initialise()
        forces.append(instance["thrust_end.f_x"])
    assert forces[0] == pytest.approx(forces[1], rel=1e-12)


@pytest.mark.parametrize("count", [0, MAX_BEARINGS + 1])
def test_no_bearings_or_more_than_fault_codes_are_refused(count):
    with raises_naming(ValueError, f"{count}", "1", f"{MAX_BEARINGS}"):
        model_for([f"b{k}" for k in range(count)])


def test_example_of_the_readme_without_fmi_runs(capsys):
    """Its current of 1 A has the force K_i of the geometry."""
    text = (Path(amb_actuator.__path__[0]) / "README.md").read_text(encoding="utf-8").partition("without FMI:\n")[2]
    exec(textwrap.dedent(text.partition("\n## ")[0]), {})
    assert float(capsys.readouterr().out) == pytest.approx(CONSTANTS_FROM_GEOMETRY[1])
