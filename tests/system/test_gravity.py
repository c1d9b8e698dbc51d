"""Gravity in a scenario: the static currents carry the rotor's weight, each bearing its share, in any direction."""

import math
from dataclasses import replace

import pytest

import amb_cosim
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import make_scenario
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import raises_naming

WEIGHT = 96.0254 * 9.81  # N


def levitated(**changes):
    """The rig at 260 rad/s without unbalance, for 1.5 s."""
    fields = {"Omega": "260 rad/s", "settle_cycles": 60, "end_cycle": 1, "gravity": "9.81 m/s2"} | changes
    return make_scenario(fields, "levitated")


def at_the_end(scenario, *names):
    dataset = amb_cosim.run(scenario, progress=False).dataset
    return [float(dataset[name].values[-1]) for name in names]


AXES = [f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
PLACES = [f"rotor_contact.{axis}" for axis in AXES]
FORCES = [f"amb_actuator.{bearing}.f_{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]


@pytest.mark.parametrize("law", [0, 1, 2], ids=["linear", "measured", "nonlinear"])
def test_levitated_rotor_sits_at_its_setpoint(law):
    """Within 1 um; where the static currents do not carry the weight it sags by 0.37 mm."""
    scenario = levitated(parameters={"amb_actuator": {"force_law": law}})
    places = at_the_end(scenario, *PLACES)
    assert max(abs(x) for x in places) < 1e-6


def test_a_seal_that_carries_weight_leaves_the_rotor_at_its_setpoint():
    """Within 1 um; with the static currents of the whole weight a seal between the bearings lifts it by 55 um."""
    seal = Bearing("gland", 7, ((1e6, 1e5), (-1e5, 1e6)), 200.0)
    scenario = levitated(rotor=replace(load_rotor("bath_rig"), seals=(seal,)))
    assert max(abs(x) for x in at_the_end(scenario, *PLACES)) < 1e-6


@pytest.mark.parametrize("settling", ["simulated", "automatic"])
def test_rotor_at_rest_levitates_at_its_setpoint(settling):
    """Its 60 cycles of settling last 0.6 s; they may be left to the choice of the run."""
    scenario = levitated(Omega=0, settling=settling)
    *places, cycle, angle = at_the_end(scenario, *PLACES, "cycle", "rotor_contact.theta")
    assert max(abs(x) for x in places) < 1e-6
    assert (cycle, angle) == (1.0, 0.0)


def test_without_static_currents_the_weight_displaces_the_rotor():
    """By a bearing's share of m g/sqrt(2) over K_b along each axis."""
    scenario = levitated(gravity=None, parameters={"rotor_contact": {"gravity": "9.81 m/s2"}})
    sag = {"mb1": 53.732 * 9.81 / math.sqrt(2.0) / 1e6, "mb2": 42.294 * 9.81 / math.sqrt(2.0) / 1e6}
    for place, x in zip(PLACES, at_the_end(scenario, *PLACES), strict=True):
        assert x == pytest.approx(-sag[place.split(".")[1]], rel=0.01)


@pytest.mark.parametrize("angle", [225.0, 270.0, 45.0], ids=["diagonal", "along y", "upwards"])
def test_bearings_together_pull_the_weight_against_gravity(angle):
    scenario = levitated(gravity_angle=f"{angle} deg")
    *forces, x = at_the_end(scenario, *FORCES, PLACES[0])
    assert sum(forces[::2]) == pytest.approx(-WEIGHT * math.cos(math.radians(angle)), abs=1e-3)
    assert sum(forces[1::2]) == pytest.approx(-WEIGHT * math.sin(math.radians(angle)), abs=1e-3)
    assert abs(x) < 1e-6


def test_static_currents_are_those_of_the_shares_of_the_weight():
    """K_i/2 I_s = share g/sqrt(2): MB1 carries 53.7 kg, MB2 42.3 kg."""
    values = prepare_run(levitated()).parameters["amb_actuator"]
    for bearing, mass in (("mb1", 53.732), ("mb2", 42.294)):
        for axis in "xy":
            expected = 2.0 * mass * 9.81 / math.sqrt(2.0) / 563.0
            assert values[f"{bearing}.static_current_{axis}"] == pytest.approx(expected, rel=1e-4)
    assert values["total_force"] == 1.0


def test_controller_constants_of_a_system_file_take_precedence(tmp_path):
    """Also if they are written as in the file that it is based on."""
    (tmp_path / "own.toml").write_text('base = "levitated"\n[parameters.rolac_controller]\n"mb1.k_s_?" = "2e6 N/m"\n')
    scenario = levitated(parameters={"amb_actuator": {"force_law": 0}}, system=str(tmp_path / "own.toml"))
    parameters = prepare_run(scenario).parameters["rolac_controller"]
    assert parameters["mb1.k_s_x"] == 2e6
    assert parameters["mb2.k_s_x"] != 2e6


def test_parameters_of_the_scenario_take_precedence():
    scenario = levitated(parameters={"amb_actuator": {"mb1.static_current_x": "2 A"}})
    setting = {"rolac_controller.mb2.k_i_?": 600.0}
    parameters = prepare_run(scenario, setting).parameters
    assert parameters["amb_actuator"]["mb1.static_current_x"] == 2.0
    assert parameters["amb_actuator"]["mb1.static_current_y"] != 2.0
    assert parameters["rolac_controller"]["mb2.k_i_y"] == 600.0
    assert parameters["rolac_controller"]["mb1.k_i_y"] == 563.0


def test_rotor_on_springs_has_gravity_and_no_static_currents():
    parameters = prepare_run(levitated(system="passive", gravity_angle="3 rad")).parameters["rotor_contact"]
    assert (parameters["gravity"], parameters["gravity_angle"]) == (9.81, 3.0)


def test_weight_that_a_bearing_cannot_carry_is_refused():
    with pytest.raises(ValueError, match=r"gravity: mb1\.x .* load = 1519\.\d+ N .* >= "):
        prepare_run(levitated(gravity="40 m/s2", parameters={"amb_actuator": {"force_law": 2}}))


@pytest.mark.parametrize("law", [0, 1, 2], ids=["linear", "measured", "nonlinear"])
def test_a_machine_turned_by_180_degrees_has_the_same_coil_currents(law):
    """The coil pair without weight has the bias current; K_s and K_i do not depend on which pair that is."""
    coils, constants = [], []
    for angle in (225.0, 45.0):
        parameters = {"amb_actuator": {"force_law": law, "*.bias_current_?": "4.4 A"}}
        plan = prepare_run(levitated(gravity_angle=f"{angle} deg", parameters=parameters))
        local = plan.parameters["amb_actuator"]
        pairs = [(local[f"{b}.bias_current_{a}"], local[f"{b}.static_current_{a}"]) for b, a in map(split, AXES)]
        coils.append([(bias + static, bias) for bias, static in pairs])
        names = [f"{axis.replace('.', f'.{name}_')}" for axis in AXES for name in ("k_s", "k_i")]
        constants.append([plan.parameters["rolac_controller"].get(name) for name in names])
    for (upper, lower), (turned_upper, turned_lower) in zip(*coils, strict=True):
        assert lower == pytest.approx(4.4)
        assert upper > 4.5
        assert (turned_upper, turned_lower) == (pytest.approx(lower), pytest.approx(upper))
    assert constants[0] == pytest.approx(constants[1])


def split(axis):
    bearing, _, direction = axis.partition(".")
    return bearing, direction


@pytest.mark.parametrize(("tilt", "across"), [("30 deg", math.sqrt(0.75)), ("-60 deg", 0.5), ("90 deg", 0.0)])
def test_bearings_carry_the_weight_across_a_tilted_shaft(tilt, across):
    """A rotor without a thrust disc does not move along its shaft."""
    plan = prepare_run(levitated(tilt=tilt, rotor="bath_rig"))
    whole = prepare_run(levitated(gravity=9.81 * across, rotor="bath_rig"))
    assert plan.parameters["rotor_contact"]["gravity"] == pytest.approx(9.81 * across, rel=1e-12, abs=0.0)
    currents, expected = (
        [p.parameters["amb_actuator"][f"{axis.replace('.', '.static_current_')}"] for axis in AXES]
        for p in (plan, whole)
    )
    assert currents == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "facts"),
    [({"tilt": "91 deg"}, ("tilt", "91 deg", "90 deg")), ({"tilt": "10 deg", "gravity": None}, ("tilt", "gravity"))],
    ids=["beyond the vertical", "without gravity"],
)
def test_a_tilt_that_makes_no_sense_is_refused(changes, facts):
    with raises_naming(ValueError, *facts):
        levitated(**changes)
