"""Verdicts on the axial axis of the strange machine, and machines without thrust bearing."""

import json
import math

import numpy as np
import pytest
from strange_machine import LEVITATION

from amb_analysis.linear.axial_loop import AxialLoop, AxialPlant
from amb_analysis.machine.coupled import coupled_loop
from amb_assessment.assessment.analyses import axial
from amb_assessment.assessment.engine.assess import ANALYSES, assess, check_machine, chosen_parts
from amb_assessment.assessment.engine.findings import Judgement
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.thrust_bearing import ThrustBearing
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.stability import least_stable
from amb_assessment.assessment.physics.stages import real_coefficients
from amb_cosim.controllers.linear_controller import linear_controller
from tests.support.messages import assert_names, raises_naming

FILE = LEVITATION.parent / "machine.toml"
AXIAL = ["axial", "axial_margins"]


def machine_with(**changes):
    """The strange machine with other data of its thrust bearing."""
    file = load_machine(FILE)
    data = file.thrust_bearing.model_dump(exclude_none=True) | changes
    return file.model_copy(update={"thrust_bearing": ThrustBearing(**data)})


def quantities(result):
    return {item.measured.quantity: item.measured for item in result.findings}


def test_a_missing_controller_or_part_is_refused_before_any_analysis():
    with raises_naming(ValueError, "controller file"):
        assess(machine_with(controller="nowhere.toml"), only=["axial"])
    with raises_naming(ValueError, "'blowr'", "blower"):
        assess(machine_with(at="blowr"), only=["axial"])


def test_a_machine_without_thrust_bearing_has_no_axial_part():
    file = load_machine(FILE)
    without = file.model_copy(update={"thrust_bearing": None})
    assert chosen_parts(file) == list(ANALYSES)
    assert chosen_parts(without) == [name for name in ANALYSES if name not in AXIAL]
    assert chosen_parts(without, ["axial"]) == ["axial"]
    assert assess(without, only=["axial"]).unanswered == {"axial": "machine machine has no [thrust_bearing]"}
    assert not {"thrust_bearing", "tilt"} & set(without.model_dump(mode="json", exclude_none=True))


def test_the_tilted_disc_acts_in_the_lateral_loop():
    """-K_s (1 + (F/capacity)^2) (r_i^2 + r_o^2)/4 under 40 N of 250 N; a hundred times as much tilts the rotor away."""
    (disc,) = assessed_machine_of(load_machine(FILE)).thrust_tilt
    k = -0.5e6 * (1.0 + (40.0 / 250.0) ** 2) * (0.020**2 + 0.042**2) / 4.0
    np.testing.assert_allclose(disc.tilt_stiffness, k * np.eye(2), rtol=1e-9)
    strong = assessed_machine_of(machine_with(k_s="50 N/um"))
    loops = [coupled_loop(strong, others) for others in (real_coefficients(strong), real_coefficients(strong)[:-1])]
    with_disc, without = (loop.poles(0.0).stability for loop in loops)
    assert without.is_stable
    assert not with_disc.is_stable
    assert least_stable(strong).growth_rate >= with_disc.growth_rate > 1.0


def test_the_axial_axis_is_judged_like_the_radial_ones():
    result = assess(FILE, only=AXIAL)
    assert not result.unanswered
    assert not result.failed
    judged = {item.criterion.key for item in result.findings if item.criterion is not None}
    assert {"sensitivity_zone", "sensitivity_at_acceptance", "stable", "axial_load", "axial_capacity"} <= judged
    found = quantities(result)
    assert found["axial_load"].value == pytest.approx(100.0 * 40.0 / 250.0)
    assert found["sensitivity_varied"].value > found["sensitivity_peak"].value > 1.0
    assert found["decrement_varied"].value < found["decrement_anywhere"].value


def test_peak_of_the_sensitivity_is_that_of_the_loop_at_its_load():
    """Of `AxialLoop`, which tests/amb_analysis compares with python-control; K_s is that under 40 N of 250 N."""
    file = load_machine(FILE)
    result = quantities(assess(file, only=["axial_margins"]))["sensitivity_peak"]
    mass, k_s, omega_b, T = 3.908928636, 5e5 * (1.0 + (40.0 / 250.0) ** 2), 2.0 * math.pi * 1500.0, 50e-6
    law = linear_controller(FILE.parent / "axial.toml").state_space()
    plant = AxialPlant(mass, 100.0, k_s, omega_b, file.thrust_bearing.corner)
    loop = AxialLoop(plant, law, T, 1.5)
    assert result.value == pytest.approx(abs(loop.sensitivity(np.array([result.facts["frequency"]]))[0]), rel=1e-6)


@pytest.fixture
def falling(tmp_path):
    """The strange machine with a thrust bearing whose magnets push the rotor away."""
    text = (FILE.parent / "axial.toml").read_text(encoding="utf-8").replace("gain = -1.0", "gain = 1.0")
    (tmp_path / "axial.toml").write_text(text, encoding="utf-8")
    return machine_with(controller=str(tmp_path / "axial.toml"))


def test_an_axial_gain_of_the_wrong_sign_is_missed_and_has_no_margins(falling):
    result = assess(falling, only=AXIAL)
    assert {item.criterion.key for item in result.failed} >= {"stable"}
    assert set(result.unanswered) == {"axial_margins"}
    assert_names(result.unanswered["axial_margins"], "axial loop", "not stable", "drift")
    assert "sensitivity_peak" not in quantities(result)
    assert json.loads(json.dumps(result.as_dict(), allow_nan=False))


def test_an_unstable_axial_loop_leaves_lateral_parts_unanswered(falling):
    result = assess(falling, only=["unbalance", "envelope", "axial_margins"])
    assert set(result.unanswered) == {"unbalance", "envelope", "axial_margins"}
    assert not result.findings


def test_an_axial_corner_that_is_not_stable_misses_its_sensitivity():
    """With half of K_i the gain returns K_i k_p = 0.63 N/um, and the magnets pull by 1.4 times 0.51 N/um."""
    file = machine_with()
    weak = file.model_copy(update={"tolerances": file.tolerances.model_copy(update={"k_s": 0.4, "k_i": 0.5})})
    found = {item.criterion.key: item for item in assess(weak, only=["axial_margins"]).findings if item.criterion}
    for key in ("stable_with_tolerances", "sensitivity_with_tolerances"):
        assert found[key].verdict is Judgement.FAILED
    assert found["sensitivity_with_tolerances"].measured.shown == "without bound"
    assert found["sensitivity_zone"].verdict is Judgement.MET


def test_a_thrust_beyond_the_capacity_is_missed_and_has_no_loop():
    result = assess(machine_with(thrust=["0 N", "300 N"]), only=[*AXIAL, "unbalance"])
    assert [item.criterion.key for item in result.failed] == ["axial_load"]
    assert result.failed[0].verdict is Judgement.FAILED
    assert quantities(result)["axial_load"].value == pytest.approx(120.0)
    (part,) = (part for part in result.parts if part.key == "axial")
    assert_names(part.result.notes[0], "-300 N", "no loop")
    assert [row[0] for row in part.result.tables[0].rows] == ["0"]
    assert set(result.unanswered) == {"axial_margins", "unbalance"}
    assert_names(result.unanswered["unbalance"], "-300 N", "250 N")


def test_a_thrust_of_either_sign_is_judged_without_load_too():
    """At its rest position the bearing has the least negative stiffness."""
    (part,) = assess(machine_with(thrust=["-100 N", "150 N"]), only=["axial"]).parts
    rows = [[float(text) for text in row[:4]] for row in part.result.tables[0].rows]
    assert [row[0] for row in rows] == [100.0, -150.0, 0.0]
    assert min(rows, key=lambda row: row[2])[0] == 0.0


@pytest.mark.parametrize("gravity", [0.0, "0 m/s^2"])
def test_a_vertical_machine_without_gravity_is_refused(gravity):
    """Its thrust bearing would carry nothing; a scenario of a vertical shaft has `gravity = 0`."""
    file = machine_with(thrust=0.0).model_copy(update={"tilt": "90 deg", "gravity": gravity})
    with raises_naming(ValueError, "gravity = 0 m/s2", "tilt = 90 deg", "9.81 m/s^2", "machine file"):
        check_machine(file)


def test_a_vertical_machine_carries_its_weight_along_the_shaft():
    file = machine_with(thrust=0.0).model_copy(update={"tilt": "90 deg"})
    found = quantities(assess(file, only=AXIAL))
    assert found["axial_load"].value == pytest.approx(100.0 * 3.908928636 * 9.81 / 250.0, rel=1e-6)
    assert "under 38.3" in found["sensitivity_peak"].where  # upwards, along z
    assert axial.NAME in found["axial_load"].where
