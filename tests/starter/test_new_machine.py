"""A first design of a machine: its sizes, its files, and that it levitates, lands and is lifted off again."""

import math

import numpy as np
import pytest
from click.testing import CliRunner

import amb_cosim
from amb_cosim.acceptance.machine_file import load_machine
from amb_cosim.commands.cli import main
from amb_cosim.design.magnetic_bearing import axis_parameters, load_capacity
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.starter.files import TEMPLATES, new_machine
from amb_cosim.starter.levitation import operating_points
from amb_cosim.starter.sizing import CAPACITY, machine_sizes
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor_file import load_rotor

RPM = math.pi / 30.0
MACHINES = {"blower": (12.0, 0.6, 30000.0), "pump": (60.0, 1.2, 12000.0), "turbine": (1500.0, 3.2, 6000.0)}
SCENARIOS = ("levitation", "runup", "landing", "relevitation", "sensor_loss", "shock")


@pytest.fixture(scope="module")
def pump(tmp_path_factory):
    mass, length, rpm = MACHINES["pump"]
    return new_machine(tmp_path_factory.mktemp("new") / "pump", machine_sizes(mass, length, rpm * RPM))


@pytest.mark.parametrize("name", MACHINES)
def test_magnets_carry_the_weight_with_force_to_spare(name):
    mass, length, rpm = MACHINES[name]
    sizes = machine_sizes(mass, length, rpm * RPM)
    assert math.hypot(sum(sizes.load), sum(sizes.load)) == pytest.approx(9.81 * mass)
    for load, point in zip(sizes.load, operating_points(sizes), strict=True):
        names = ("turns", "pole_area", "gap", "bias_current", "current_limit")
        axis = axis_parameters(**{name: getattr(sizes, name) for name in names}, static_current=0.0)
        assert load_capacity(axis, np.array([load])).up[0] > (CAPACITY - 1.0) * load
        assert 0.0 < point.static_current < sizes.bias_current


def test_bearings_share_the_weight_by_the_levers_of_statics():
    sizes = machine_sizes(60.0, 1.2, 1000.0, (0.2, 0.9))
    left, right = sizes.load
    z_left, z_right = sizes.bearings
    centre = (left * z_left + right * z_right) / (left + right)
    assert centre == pytest.approx(0.7 * 0.6 + 0.3 * sizes.wheel)


def test_the_rotor_file_has_the_mass_that_was_asked_for(pump):
    body = rigid_body(load_rotor(pump.folder / "rotor.toml"))
    assert body.mass == pytest.approx(60.0, rel=1e-4)


def test_every_file_of_a_new_machine_can_be_read(pump):
    assert {file.name for file in pump.folder.iterdir()} == {file.name for file in TEMPLATES.iterdir()}
    for name in SCENARIOS:
        scenario = load_scenario(str(pump.folder / f"{name}.toml"))
        assert "pump" in scenario.description
        assert load_rotor(scenario.rotor).name == "pump"


def test_a_new_machine_levitates_with_room_to_its_retainers(pump):
    """No vibration of its loop grows, and a run of the scenario agrees: orbits stay within a tenth of the clearance."""
    assert pump.gains.quality > 0.5
    result = amb_cosim.run(load_scenario(str(pump.folder / "levitation.toml")).changed(settle_cycles=20, end_time=0.05))
    assert result.outcome.status == "completed"
    assert all(orbit < 0.1e3 * pump.sizes.clearance for orbit in result.summary.orbit_largest.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["blower", "pump"])
def test_a_new_machine_lands_and_is_lifted_off_again(tmp_path, name):
    mass, length, rpm = MACHINES[name]
    made = new_machine(tmp_path / name, machine_sizes(mass, length, rpm * RPM))
    landed = amb_cosim.run(str(made.folder / "relevitation.toml"))
    assert landed.summary.recovery == "recovered"
    shaken = amb_cosim.run(str(made.folder / "shock.toml"))
    assert shaken.summary.recovery in ("prevented", "recovered")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((0.0, 1.0, 100.0), "mass = 0 kg"),
        ((60.0, math.nan, 100.0), "length = nan m"),
        ((60.0, 0.5, 60000.0 * RPM), "the surface of the shaft"),
        ((600.0, 0.5, 100.0), "thicker than a quarter"),
        ((60.0, 1.2, 100.0, (0.9, 0.2)), "bearings = 0.9 m, 0.2 m"),
    ],
)
def test_numbers_of_which_no_machine_can_be_made_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        machine_sizes(*given)


def test_a_folder_that_exists_is_left_alone(tmp_path):
    sizes = machine_sizes(60.0, 1.2, 1000.0)
    with pytest.raises(ValueError, match="exists"):
        new_machine(tmp_path, sizes)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_command_takes_units_and_says_what_levitates(tmp_path):
    asked = ("new", str(tmp_path / "fan"), "--mass", "60000 g", "--length", "1200 mm", "--speed", "200 Hz")
    done = CliRunner().invoke(main, [*asked, "--bearings", "0.25 m, 950mm"])
    assert done.exit_code == 0, done.output
    assert "levitates with K_b" in done.output
    assert (tmp_path / "fan" / "landing.toml").is_file()


@pytest.mark.parametrize("given", ["0.2 m", "0.2m 0.5 m, 0.9"])
def test_bearings_are_two_positions(tmp_path, given):
    asked = ("new", str(tmp_path / "fan"), "--mass", "60 kg", "--length", "1.2 m", "--speed", "200 Hz")
    assert "two positions" in CliRunner().invoke(main, [*asked, "--bearings", given]).stderr


def test_the_machine_to_assess_lands_in_the_retainers_of_its_landing(pump):
    landing = load_scenario(str(pump.folder / "landing.toml")).parameters["rotor_contact"]
    machine = load_machine(pump.folder / "machine.toml").parameters["rotor_contact"]
    assert {name: landing[name] for name in machine} == machine
