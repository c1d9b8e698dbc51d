"""Machine files: errors name the fault, and paths are relative to the file."""

import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from amb_assessment.assessment import commands
from amb_assessment.assessment.analyses.robustness import variations
from amb_assessment.assessment.format.machine_file import CompressorStage, MachineFile, load_machine, packaged_machines
from amb_assessment.assessment.page.description import inductance_doubt, magnet_numbers
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.stages import cross_coupling
from amb_cosim.commands.cli import main
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, static_current_for
from tests.support.messages import raises_naming

BLOWER = Path(__file__).parent / "blower"
SPEED = {"minimum": "7000 rpm", "maximum": "9000 rpm"}
DATA = {"power": "500 kW", "diameter": "0.5 m", "width": "20 mm"}


def machine(**changes):
    return MachineFile(**({"rotor": "compressor", "speed": SPEED} | changes))


def test_cross_coupling_of_a_stage_matches_a_hand_calculation():
    Omega = 942.477796076938  # 9000 rpm
    by_hand = 500e3 * 3.0 * 9.55 * 1.2 / (0.5 * 0.02 * 9000.0)
    assert CompressorStage(at="wheel", density_ratio=1.2, **DATA).anticipated(Omega) == pytest.approx(by_hand)
    axial = CompressorStage(at="wheel", kind="axial", **DATA).anticipated(Omega)
    assert axial == pytest.approx(500e3 * 1.5 * 9.55 / (0.5 * 0.02 * 9000.0))


@pytest.mark.parametrize(
    ("values", "facts"),
    [
        ({"cross_coupling": "-57 kN/m"}, ("cross_coupling of stage at wheel = -57000 N/m (-57 kN/m)", ">= 0 N/m")),
        ({"cross_coupling": math.nan}, ("cross_coupling of stage at wheel = nan", "finite")),
        ({"cross_coupling": 1e6, "real": "inf N/m"}, ("real of stage at wheel = inf N/m", "finite")),
        (DATA | {"power": "nan kW"}, ("power of stage at wheel = nan kW", "finite")),
    ],
)
def test_cross_coupling_that_drives_nothing_is_refused(values, facts):
    with raises_naming(ValueError, *facts):
        CompressorStage(at="wheel", **values)


def test_cross_coupling_pushes_along_a_forward_circle():
    angle = np.linspace(0.0, 2.0 * np.pi, 9)
    q, velocity = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    K, C, M = cross_coupling("wheel", 3, 2.0).at(700.0)
    np.testing.assert_allclose(((-K @ q) * velocity).sum(axis=0), 2.0)
    backward = np.array([[1.0], [-1.0]])
    np.testing.assert_allclose(((-K @ (backward * q)) * (backward * velocity)).sum(axis=0), -2.0)
    assert not C.any()
    assert not M.any()


def test_level_two_takes_the_stated_coupling_of_a_stage():
    stage = CompressorStage(at="wheel", cross_coupling="1 MN/m", real="0.2 MN/m")
    assert stage.anticipated(900.0) == pytest.approx(1e6)
    assert stage.level_two(900.0) == pytest.approx(2e5)


def test_real_coefficients_of_a_stage_are_those_of_a_seal_over_speed():
    rows = [
        {"speed": Omega, "stiffness": [[1e6, Q], [-Q, 1e6]], "damping": 1e3, "mass": 2.0}
        for Omega, Q in ((0.0, 0.0), (900.0, 3e5))
    ]
    stage = CompressorStage(at="wheel", cross_coupling="1 MN/m", real=rows)
    assert stage.level_two(450.0) == pytest.approx(1.5e5)
    K, C, M = stage.coefficients().at(450.0)
    assert K[0].tolist() == pytest.approx([1e6, 1.5e5])
    assert (C[0, 0], M[1, 1]) == pytest.approx((1e3, 2.0))
    constant = CompressorStage(at="wheel", cross_coupling="1 MN/m", real=rows[1:])
    assert constant.level_two(20.0) == pytest.approx(3e5)


def test_trip_and_frequencies_follow_from_the_largest_speed():
    result = machine()
    assert result.speed.tripping == pytest.approx(1.05 * result.speed.highest)
    assert result.highest_frequency == pytest.approx(2.1 * result.speed.highest)
    assert machine(up_to="700 Hz").highest_frequency == pytest.approx(4398.23, rel=1e-6)


@pytest.mark.parametrize("grade", ["2.5 mm/s", "G 2.5", "G2.5", 0.0025])
def test_a_balancing_grade_is_written_as_the_standard_or_with_its_unit(grade):
    assert machine(balancing={"grade": grade}).balancing.speed == pytest.approx(2.5e-3)


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"rotor": None}, ("rotor", "scenario")),
        ({"speed": {"minimum": "9 krpm", "maximum": "7 krpm"}}, ("speed.maximum", "7000 rpm (7 krpm)", ">= 9000 rpm")),
        ({"speed": {"minimum": "0 rpm", "maximum": "7 krpm"}}, ("speed.minimum", "0 rpm", "> 0 rpm")),
        (
            {"speed": {"minimum": "7 krpm", "maximum": "9 krpm", "trip": "8 krpm"}},
            ("speed.trip", "8000 rpm (8 krpm)", ">= 9000 rpm, the maximum"),
        ),
        (
            {"speed": {"minimum": "1 Hz", "maximum": "1e5 rad/s"}},
            ("speed.trip", "1.05 x 1e5", "<= 954930 rpm"),
        ),
        ({"speed": {"minimum": "900", "maximum": "9 krpm"}}, ("speed.minimum", "900 rpm", "900 rad/s")),
        (
            {"speed": {"minimum": "9 krpm", "maximum": "120000 rad/s"}},
            ("speed.maximum", "120000 rad/s", "<= 954930 rpm"),
        ),
        ({"balancing": {"grade": "-1 mm/s"}}, ("balancing.grade", "-0.001 m/s")),
        ({"balancing": {"grade": "2.5 kg"}}, ("balancing.grade",)),
        ({"balancing": {"grade": 2.5}}, ("balancing.grade", "2.5 m/s", "'G 2.5'")),
        ({"balancing": {"grade": "G 2.5.1"}}, ("balancing.grade", "'G 2.5.1'", "'G 2.5'")),
        ({"balancing": {"grade": "G -2"}}, ("balancing.grade", "'G -2'", "'G 2.5'")),
        ({"stages": [{"at": "wheel", "power": "500 kW"}]}, ("cross_coupling", "power", "diameter", "width")),
        (
            {"stages": [{"at": "wheel", "cross_coupling": 1e6, **DATA}]},
            ("cross_coupling", "power", "diameter", "width"),
        ),
        ({"stages": [{"at": "wheel", **DATA, "width": "0 mm"}]}, ("width", "wheel")),
        (
            {"stages": [{"at": "wheel", "cross_coupling": 1e6, "real": [{"speed": 2.0}, {"speed": 1.0}]}]},
            ("ascending",),
        ),
        ({"gravity": "9.81 m"}, ("gravity = '9.81 m'", "m/s2")),
        ({"gravity_angle": "225 m"}, ("gravity_angle = '225 m'", "rad")),
        ({"up_to": "0 Hz"}, ("up_to", "0 rad/s")),
        # below the trip speed no mode might be excited, so that the least decrement would be met
        ({"up_to": "10 Hz"}, ("up_to", "10 Hz", ">= 157.5 Hz, the trip speed")),
        ({"up_to": "1 rad/s"}, ("up_to", "0.1592 Hz (1 rad/s)", ">= 157.5 Hz", "trip")),
        ({"tolerances": {"k_i": 1.0}}, ("less than 1",)),
    ],
)
def test_an_invalid_machine_is_refused(changes, facts):
    with raises_naming(ValueError, *facts):
        machine(**changes)


def test_a_machine_of_a_scenario_has_its_parts_and_none_of_its_loads():
    scenario = machine(rotor=None, scenario="compressor_levitated", gravity="9.81 m/s2").as_scenario(900.0)
    assert scenario.rotor == "compressor"
    assert scenario.parameters["amb_actuator"]["*.turns_?"] == 48
    assert "rotor_contact" not in scenario.inputs
    assert scenario.event == ()
    assert (scenario.gravity, scenario.initial_speed) == ("9.81 m/s2", 900.0)


@pytest.mark.parametrize("is_on", [True, False])
def test_an_assessment_states_that_it_omits_synchronous_control(tmp_path, is_on):
    """Its poles, responses and co-simulations are those of the feedback alone."""
    lines = (
        f"base = '{BLOWER / 'levitation.toml'}'",
        "[inputs.rolac_controller]",
        f"rolac_enable = {str(is_on).lower()}",
    )
    (tmp_path / "levitation.toml").write_text("\n".join(lines), encoding="utf-8")
    file = machine(scenario=str(tmp_path / "levitation.toml"), rotor=None)
    assert file.has_synchronous_control == is_on
    assert file.as_scenario(800.0).inputs["rolac_controller"]["rolac_enable"] is False


def test_paths_of_a_machine_file_are_relative_to_it(tmp_path):
    (tmp_path / "own.toml").write_text(
        'rotor = "shaft.toml"\ncontroller = "law.toml"\ncriteria = ["works.toml", "api_617"]\n'
        '[speed]\nminimum = "1 krpm"\nmaximum = "2 krpm"\n'
    )
    result = load_machine(tmp_path / "own.toml")
    assert result.rotor == str(tmp_path / "shaft.toml")
    assert result.controller == str(tmp_path / "law.toml")
    assert result.criteria == (str(tmp_path / "works.toml"), "api_617")
    assert result.name == "own"


def test_mistakes_of_a_machine_file_are_one_line_each(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text('rotr = "x"\nrotor = "x"\n[speed]\nminimum = "1 krpm"\n')
    with raises_naming(ValueError, "rotr", "rotor") as error:
        load_machine(path)
    assert len(str(error.value).splitlines()) == 2
    with raises_naming(ValueError, "compresor", "compressor"):
        load_machine("compresor")


def test_all_corners_of_the_tolerances_are_varied():
    corners = variations(machine().tolerances)
    assert len(corners) == 17
    assert min(v.k_i for v in corners.values()) == pytest.approx(0.9 / 1.05**2)
    assert max(v.k_s for v in corners.values()) == pytest.approx(1.15 / 0.95**3)


def test_magnet_numbers_match_the_closed_forms():
    """F = mu_0 N^2 A cos(phi) (I_upper^2 - I_lower^2)/s^2 with the full control current in one coil pair."""
    values = {"turns": 50.0, "pole_area": 4e-4, "gap": 5e-4, "half_angle": 0.3, "b_sat": 900.0, "inductance": 6e-3}
    p = axis_parameters(**values, bias_current=3.0, static_current=1.0, current_limit=8.0)
    gap, upper, lower, least, most, _, _, settings, of_gap = magnet_numbers(p, 0)
    assert (gap, upper, lower, settings) == pytest.approx((0.5, 4.0, 3.0, 6.0))
    c = 4e-7 * math.pi * 50.0**2 * 4e-4 * math.cos(0.3) / 5e-4**2
    assert most == pytest.approx(c * (7.0**2 - 0.0**2), rel=1e-6)
    assert least == pytest.approx(c * (0.0**2 - 7.0**2), rel=1e-6)
    assert of_gap == pytest.approx(2e3 * 4e-7 * math.pi * 50.0**2 * 4e-4 / 5e-4)


def test_differential_drive_keeps_k_i_under_any_load():
    """Upper coils i_0 + F/K_i and lower coils i_0 - F/K_i carry F, for F = K_i (I_upper - I_lower)/2."""
    constants = {"turns": 50.0, "pole_area": 4e-4, "gap": 5e-4, "half_angle": 0.3, "b_sat": 900.0, "current_limit": 8.0}
    unloaded = axis_parameters(**constants, bias_current=4.0, static_current=0.0)
    k_i = magnet_numbers(unloaded, 2)[6]
    shift = 50.0 / k_i
    loaded = axis_parameters(**constants, bias_current=4.0 - shift, static_current=2.0 * shift)
    assert magnet_numbers(loaded, 2)[6] == pytest.approx(k_i, rel=1e-9)
    assert static_current_for(50.0, loaded, 2) == pytest.approx(2.0 * shift, rel=1e-6)


@pytest.mark.parametrize(("given", "warns"), [(22.0, False), (14.0, False), (22e3, True), (0.022, True)])
def test_an_inductance_far_from_that_of_the_gap_warns_of_its_unit(given, warns):
    result = inductance_doubt("left.x", given, 14.0)
    assert [("inductance_x = " in line, "check its unit" in line) for line in result] == [(True, True)] * warns


@pytest.mark.parametrize("name", sorted(packaged_machines()))
def test_packaged_magnets_have_about_the_inductance_of_their_gap(name):
    subject = assessed_machine_of(load_machine(name))
    for bearing, axis in subject.loop.axes:
        given, of_gap = magnet_numbers(subject.axis(bearing, axis), 0)[-2:]
        assert 0.7 < given / of_gap < 1.5


@pytest.mark.parametrize("key", ["minimum", "maximum", "trip"])
def test_speeds_of_a_machine_file_need_a_unit(tmp_path, key):
    """9000 was 9000 rad/s, or 85,944 rpm; in Python numbers are in rad/s."""
    speeds = {"minimum": "'7000 rpm'", "maximum": "'9000 rpm'", "trip": "'9900 rpm'"} | {key: "9000"}
    text = "".join(f"{name} = {value}\n" for name, value in speeds.items())
    (tmp_path / "machine.toml").write_text(f'rotor = "compressor"\n[speed]\n{text}')
    with raises_naming(ValueError, "machine.toml", f"speed.{key} = 9000", "9000 rpm", "9000 rad/s"):
        load_machine(tmp_path / "machine.toml")
    assert machine(speed={"minimum": 100.0, "maximum": 200.0}).speed.lowest == 100.0


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("up_to = 700", "up_to"),
        ("[thrust_bearing]\nbandwidth = 2000", "thrust_bearing.bandwidth"),
        ("[thrust_bearing]\niron = { corner = 300 }", "thrust_bearing.iron.corner"),
        ("[[stages]]\nat = 'wheel'\n[[stages.real]]\nspeed = 9000", "stages[0].real[0].speed"),
    ],
)
def test_frequencies_of_a_machine_file_need_a_unit(tmp_path, text, name):
    """700 was 700 rad/s, although a controller's file takes it for 700 Hz."""
    (tmp_path / "machine.toml").write_text(f'rotor = "compressor"\n{text}\n')
    with raises_naming(ValueError, "machine.toml", f"{name} = ", "unit", "rad/s"):
        load_machine(tmp_path / "machine.toml")


def test_a_name_with_slashes_is_one_folder(tmp_path, monkeypatch):
    """The page of `name = "pump/../../x"` was written outside the folder of results."""
    text = 'name = "pump 3/4 / ../x"\nrotor = "compressor"\n[speed]\nminimum = "7000 rpm"\nmaximum = "9000 rpm"\n'
    (tmp_path / "machine.toml").write_text(text)
    folders = []
    monkeypatch.setattr(commands, "check_writable", lambda folder, **_: folders.append(folder) or 1 / 0)
    CliRunner().invoke(main, ["assess", str(tmp_path / "machine.toml")])
    assert folders == [Path("results") / "assess_pump 3_4 _ .._x"]
