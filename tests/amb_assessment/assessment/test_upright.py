"""Upright machines: gravity acts along the shaft, where only a rotor with a thrust disc moves."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fall_over_top import RIGID

from amb_assessment.assessment.analyses import faults, landing, recovery, rest
from amb_assessment.assessment.engine.assess import check_machine
from amb_assessment.assessment.engine.findings import Judgement, judge
from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import CompressorStage, load_machine
from amb_assessment.assessment.page.description import description
from amb_assessment.assessment.physics.runs import clearance_used, simulate, times_of, upright, without_power
from amb_assessment.assessment.physics.whirl_friction import whirl_friction
from amb_cosim.results.component_names import PLANT
from tests.support.messages import assert_names

BLOWER = Path(__file__).parent / "blower" / "machine.toml"
PUMP = Path(__file__).parents[2] / "system" / "upright_pump"


def tilted(degrees, machine=BLOWER):
    changes = {"tilt": f"{degrees} deg", "gravity": "9.81 m/s2"}
    return check_machine(load_machine(machine).model_copy(update=changes))


@pytest.fixture(scope="module")
def standing():
    return tilted(90.0)


@pytest.mark.parametrize(("degrees", "share"), [(0.0, 1.0), (60.0, 0.5), (89.0, 0.01745), (90.0, 0.0), (-90.0, 0.0)])
def test_gravity_across_an_upright_shaft_is_exactly_nothing(degrees, share):
    subject = tilted(degrees)
    across = subject.parameters[PLANT]["gravity"]
    assert across == (0.0 if share == 0.0 else pytest.approx(9.81 * share, rel=1e-3))
    assert bool(upright(subject)) == (share == 0.0)


@pytest.fixture(scope="module")
def pump(tmp_path_factory):
    speeds = '[speed]\nminimum = "18000 rpm"\nmaximum = "36000 rpm"\n'
    path = tmp_path_factory.mktemp("pump") / "machine.toml"
    path.write_text(f"scenario = {str(PUMP / 'levitation.toml')!r}\n{speeds}", encoding="utf-8")
    return check_machine(load_machine(path))


def test_landings_of_an_upright_machine_with_faces_are_judged(pump):
    """Gravity and tilt are those of its scenario."""
    assert pump.parameters[PLANT]["gravity"] == 9.81
    assert pump.gravity_across == 0.0
    assert pump.file.axial_gravity == pytest.approx(-9.81)
    assert pump.falls_onto_a_face
    assert not upright(pump)


def test_a_face_is_a_place_to_land_on(pump):
    assert set(pump.lands_on) == {"catch_lower", "catch_upper", "seat", "stop"}
    assert set(pump.retainers) == {"catch_lower", "catch_upper"}


def test_heat_on_a_face_warms_the_retainer_below_it_further(pump):
    heats = {"seat": [0.0, 5.0, 45.0], "catch_lower": [0.0, 10.0, 30.0], "catch_upper": [0.0, 0.0, 20.0]}
    signals = {f"{PLANT}.{site}.heat": SimpleNamespace(values=values) for site, values in heats.items()}
    found = rest._recent_heats(pump, SimpleNamespace(signals=signals), heats)
    assert found == {"catch_lower": 60.0, "catch_upper": 20.0}


def test_the_clearance_along_the_shaft_is_used_up_by_a_fall(pump):
    """It falls 0.25 mm freely, away from the upper face, and both journals stay within their retainers."""
    run = simulate(pump, pump.file.speed.highest, {}, end_time=0.012, **without_power(pump, 0.0))
    used, times = clearance_used(pump, run), times_of(run)
    touched = times[np.argmax(used["seat"] >= 1.0)]
    assert touched == pytest.approx(np.sqrt(2.0 * 0.25e-3 / 9.81), abs=1.2e-3)  # currents decay in about a millisecond
    assert used["seat"][times < 0.5 * touched].max() < 0.3
    assert used["stop"].max() < 0.05
    assert used["catch_lower"].max() < 1.0


def test_the_axis_along_the_shaft_can_fail_and_be_shaken(pump):
    assert pump.controlled_axes == (*pump.loop.lateral_axes, ("thrust", "z"))
    kinds = faults._kinds(pump)
    assert "power of thrust.z lost" in kinds["power of one axis lost"]
    (shocks,) = (cases for kind, cases in kinds.items() if "shock" in kind)
    assert {name.rpartition(" ")[2] for name in shocks} == {f"{sign}{axis}" for axis in "xyz" for sign in "+-"}


def test_an_overload_along_the_shaft_ends_at_a_face(pump):
    assert pump.directions_of_contact == "xyz"
    *_, overload, run = recovery._rising(pump, pump.file.speed.highest, {}, "z", "+")
    assert overload.where.startswith("seat is touched first")  # the base rises towards the rotor
    assert 0.0 < overload.value < recovery.MOST
    assert clearance_used(pump, run)["seat"].max() >= 1.0


def test_the_axis_carries_against_its_weight_what_the_demand_limit_leaves():
    """The static current holds the weight of 108 N; 1.6 A about it are 174 N at the centre, and less off it."""
    machine = check_machine(load_machine("turbo_pump"))
    (carried,) = recovery._carried(machine, machine.file.speed.highest, {})
    assert carried.where == "along +z"
    assert carried.value == pytest.approx(44.0, abs=10.0)
    assert carried.facts["capacity"] == pytest.approx(271.4, rel=1e-3)


def weights(subject):
    """Return stiffness and displacement in the balls' rows, and the line on criteria, of the data of a machine."""
    blocks = description(subject, load_criteria(["physics"]))
    (balls,) = (block for block in blocks if "Ball bearings" in str(getattr(block, "title", "")))
    stiffness, displacement = (list(balls.columns[k].cells) for k in (4, 5))
    (line,) = (block for block in blocks if isinstance(block, str) and "criteria" in block)
    return stiffness, displacement, line


def test_balls_of_an_upright_machine_carry_no_weight_across():
    standing, lying, leaning = (tilted(degrees, "turbo_expander") for degrees in (90.0, 0.0, 60.0))
    stiffness, displacement, line = weights(standing)
    assert (set(stiffness), set(displacement)) == ({"-"}, {"0"})
    assert_names(line, f"{9.81 * standing.rotor.mass:.4g} N", "along the shaft")
    stiffness, displacement, line = weights(lying)
    assert "-" not in stiffness
    assert "along" not in line
    halved = weights(leaning)[1]  # pairs with preload, which are nearly linear
    assert [float(um) for um in halved] == pytest.approx([0.5 * float(um) for um in displacement], rel=0.02)


def test_no_fall_of_an_upright_machine_passes_a_top(standing):
    least = whirl_friction(standing, 0.15)
    assert least.value > RIGID
    assert_names(least.note, "along the shaft")
    (found,) = judge([least], load_criteria(["physics"]), {})
    assert found.verdict is Judgement.UNANSWERED


def test_whirl_of_a_standing_rotor_rests_on_the_stiffness_of_its_face(pump):
    """With little friction the race follows slowly, against the drag of its balls, and whirl has time to grow."""
    least = whirl_friction(pump, 0.02)
    assert least.where.startswith("seat, ")
    assert 0.02 < least.value < 1.0
    assert least.may_worsen_because
    assert_names(least.note, "stiffness", "measured")
    (found,) = judge([least], load_criteria(["physics"]), {})
    assert found.verdict is Judgement.UNANSWERED


def test_a_stage_moves_a_standing_rotor_without_friction(pump):
    """Its cross coupling Q lets the rotor drift with about sqrt(Q/(2 m)); whirl still needs friction."""
    stage = {"at": pump.rotor.bodies[0].name, "cross_coupling": "4.7 kN/m"}
    coupled = check_machine(pump.file.model_copy(update={"stages": (CompressorStage.model_validate(stage),)}))
    least = whirl_friction(coupled, 0.02)
    assert least.value == pytest.approx(whirl_friction(pump, 0.02).value, rel=0.3)
    assert_names(least.note, "without any friction", "stages", "1/s")


@pytest.mark.parametrize("whirls", [False, True])
def test_landings_across_an_upright_shaft_are_not_judged(standing, monkeypatch, whirls):
    def land(subject, inputs, mu, phase):
        return landing.Landing(mu, phase, {}, whirls, not whirls, None, (), ())

    monkeypatch.setattr(landing, "worst_inputs", lambda _: {})
    monkeypatch.setattr(landing, "_landed", land)
    measured = [item for item in landing.result_of(standing).quantities if item.quantity.startswith("landing_")]
    for item in measured:
        for found in judge([item], load_criteria(["physics"]), {}):
            assert found.verdict in (Judgement.UNANSWERED, Judgement.NOT_JUDGED)


@pytest.mark.parametrize("forces", [(0.0, 0.0), (0.0, 5.0), (5.0, 0.0)])
def test_forces_of_landings_without_contact_are_not_compared(monkeypatch, forces):
    left = iter(forces)
    monkeypatch.setattr(rest, "simulate", lambda *_, **__: None)
    monkeypatch.setattr(rest, "_largest", lambda _: next(left))
    subject = check_machine(load_machine(BLOWER))
    (item,) = rest._convergence(subject, 1000.0, {}, {})
    assert_names(item.note, "touches nothing", "0.2 s")
    for found in judge([item], load_criteria(["physics"]), {}):
        assert found.verdict in (Judgement.UNANSWERED, Judgement.NOT_JUDGED)
