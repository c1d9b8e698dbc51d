"""Thrust bearings in machine files: constants, refusals, signs of thrust and gravity."""

import math
from pathlib import Path

import numpy as np
import pytest
from strange_machine import LEVITATION

from amb_assessment.assessment.engine.assess import check_machine
from amb_assessment.assessment.format.machine_file import MachineFile, load_machine
from amb_assessment.assessment.format.thrust_bearing import DATA_HEADS, ThrustBearing
from amb_assessment.assessment.physics import axial_cases
from amb_cosim import linear_controller
from tests.support.messages import raises_naming

FILE = LEVITATION.parent / "machine.toml"
SPEED = {"minimum": 100.0, "maximum": 200.0}
GEOMETRY = {
    "at": "wheel",
    "controller": str(FILE.parent / "axial.toml"),
    "bandwidth": "2 kHz",
    "inner_radius": "25 mm",
    "outer_radius": "55 mm",
    "pole_area": "12 cm^2",
    "gap": "0.5 mm",
    "turns": 80,
    "bias_current": "4 A",
    "current_limit": "10 A",
    "saturation": "1.3 T",
}
IRON = {"conductivity": "4e6 S/m", "permeability": 500, "slot_depth": "15 mm"}
SHEET = {key: GEOMETRY[key] for key in ("at", "controller", "bandwidth", "inner_radius", "outer_radius")}
SHEET |= {"k_i": "120 N/A", "k_s": "1 N/um", "capacity": "480 N"}


def bearing(**changes):
    return ThrustBearing(**(GEOMETRY | changes))


def machine(**fields):
    return MachineFile(rotor="compressor", gravity="9.81 m/s2", speed=SPEED, **fields)


def test_constants_follow_from_the_geometry():
    point = bearing().bearing.operating_point()
    k_i = 4e-7 * math.pi * 80**2 * 12e-4 * 4.0 / 0.5e-3**2
    assert point.k_i == pytest.approx(k_i, rel=1e-6)
    assert point.k_s == pytest.approx(k_i * 4.0 / 0.5e-3, rel=1e-6)
    row = dict(zip(DATA_HEADS, bearing(iron=IRON).data(0.0), strict=True))
    assert float(row["K_i (N/A)"]) == pytest.approx(k_i, rel=1e-3)
    assert float(row["tilt (N m/rad)"]) < 0.0
    loaded = bearing(thrust="120 N", iron=IRON)
    k_s = [loaded.bearing.operating_point(load).k_s for load in (0.0, 120.0)]
    stated = dict(zip(DATA_HEADS, loaded.data(0.0), strict=True))["K_s (MN/m)"].split(" to ")
    assert [1e6 * float(text) for text in stated] == pytest.approx(k_s, rel=1e-3)
    unloaded, most = (
        float(text) for text in dict(zip(DATA_HEADS, loaded.data(0.0), strict=True))["tilt (N m/rad)"].split(" to ")
    )
    assert most / unloaded == pytest.approx(k_s[1] / k_s[0], rel=1e-3)
    assert most == pytest.approx(-loaded.largest_moment_stiffness(0.0), rel=1e-3)
    assert bearing(thrust="1 MN").largest_moment_stiffness(0.0) == bearing(thrust="-1 MN").largest_moment_stiffness(0.0)
    assert bearing().data(0.0)[-1] == "laminated"


def test_material_and_corner_frequency_of_an_iron_give_the_same_lag():
    material = bearing(iron=IRON)
    corner = f"{material.corner / (2.0 * math.pi)!r} Hz"
    assert bearing(iron={"corner": corner}).corner == pytest.approx(material.corner, rel=1e-12)
    assert bearing().corner is None


def test_the_bearing_balances_thrust_and_weight():
    """A thrust along z is carried by a force against z, and so is a weight along z."""
    assert bearing(thrust="100 N").loads(0.0) == (-100.0,)
    assert bearing(thrust=["-50 N", "100 N"]).loads(-30.0) == (80.0, -70.0)
    assert bearing().loads(-30.0) == (30.0,)


@pytest.mark.parametrize(("tilt", "share"), [("0 deg", 0.0), ("30 deg", -0.5), ("90 deg", -1.0), ("-90 deg", 1.0)])
def test_gravity_pulls_against_z_if_the_end_of_largest_z_is_up(tilt, share):
    file = machine(tilt=tilt)
    assert file.axial_gravity == pytest.approx(9.81 * share, abs=1e-12)
    scenario = file.as_scenario(100.0)
    assert (scenario.gravity, scenario.tilt) == ("9.81 m/s2", tilt)


def test_a_machine_without_tilt_has_the_gravity_of_its_file():
    assert machine().as_scenario(100.0).gravity == "9.81 m/s2"
    assert machine().axial_gravity == 0.0


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"gap": "0 mm"}, ("gap", "0 m", "> 0 m")),
        ({"gap": "3 N"}, ("gap", "thrust bearing")),
        ({"pole_area": "50 cm^2"}, ("pole_area", "0.005 m2", "> 0 m2", "< 0.00377 m2")),
        ({"saturation": "0.2 T"}, ("bias_current", "4 A", "0.402 T")),
        ({"bandwidth": "0 Hz"}, ("bandwidth", "0 rad/s", "> 0 rad/s")),
        ({"thrust": ["5 N", "-5 N"]}, ("thrust", "5 to -5 N", "ascending")),
        ({"k_i": "100 N/A"}, ("pole_area, gap, turns",)),
        ({"turns": None}, ("pole_area, gap, turns",)),
        ({"iron": {"conductivity": "4e6 S/m"}}, ("corner", "conductivity, permeability, slot_depth")),
        ({"iron": IRON | {"corner": "90 Hz"}}, ("corner", "conductivity, permeability, slot_depth")),
        ({"iron": {}}, ("corner", "conductivity, permeability, slot_depth")),
        ({"iron": {"corner": "0 Hz"}}, ("corner", "thrust bearing", "0 rad/s")),
        ({"iron": {"corner": "1e-3 Hz"}}, ("corner", "eddy currents", "0.00628 rad/s", ">= 6.28 rad/s", "1 Hz")),
        ({"iron": IRON | {"permeability": 0.5}}, ("permeability", "0.5", "> 1")),
        ({"poles": 2}, ("thrust_bearing.poles",)),
    ],
)
def test_a_thrust_bearing_that_cannot_be_built_is_refused(changes, facts):
    with raises_naming(ValueError, *facts):
        machine(thrust_bearing=GEOMETRY | changes)


def test_iron_of_a_data_sheet_requires_a_corner_frequency():
    assert ThrustBearing(**SHEET).bearing.capacity == 480.0
    with raises_naming(ValueError, "iron", "k_i", "k_s", "corner"):
        ThrustBearing(**SHEET, iron=IRON)


def test_a_shaft_beyond_the_vertical_is_refused():
    with raises_naming(ValueError, "tilt", "91 deg", ">= -90 deg", "<= 90 deg"):
        machine(tilt="91 deg")


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ('inputs = ["a", "b"]\noutputs = ["i"]', ("2 signals", "1 demands")),
        ('inputs = ["a"]\noutputs = ["i"]\ngain = [["0 rpm", 1.0], ["9 rpm", 2.0]]', ("speed",)),
    ],
)
def test_a_controller_with_wrong_signals_or_speeds_is_refused(tmp_path, text, facts):
    head, _, gain = text.partition("\ngain")
    channel = '\nsample_time = "50 us"\n[[channel]]\nfrom = "a"\nto = "i"\n' + (f"gain{gain}" if gain else "")
    (tmp_path / "axial.toml").write_text(head + channel, encoding="utf-8")
    with raises_naming(ValueError, *facts):
        _ = bearing(controller=str(tmp_path / "axial.toml")).control


def test_a_law_and_the_gain_of_its_demand_make_the_loop_of_their_product(tmp_path):
    law = (np.eye(1), np.ones((1, 1)), -np.ones((1, 1)), np.full((1, 1), -1.2e4))
    for name, factor, gain in (("product", 1.0, 1.0), ("both", 0.5, 2.0)):
        K = (*law[:2], factor * law[2], factor * law[3])
        made = linear_controller(K, ["z"], ["i"], 50e-6, sampled_arrays=True, gains=gain, delay=1.5)
        made.save(tmp_path / f"{name}.npz")
    loops = [bearing(controller=str(tmp_path / f"{name}.npz")) for name in ("product", "both")]
    product, both = (item.loop(4.0, item.bearing.operating_point(), item.control).poles for item in loops)
    assert np.array_equal(both, product)


def test_the_path_of_the_controller_is_relative_to_the_machine_file():
    assert Path(load_machine(FILE).thrust_bearing.controller) == FILE.parent / "axial.toml"


PUMP = Path(__file__).parents[2] / "system" / "upright_pump"
OF_PUMP = """scenario = "levitation.toml"
[speed]
minimum = "18000 rpm"
maximum = "36000 rpm"
[thrust_bearing]
at = "thrust_disc"
bandwidth = "2 kHz"
inner_radius = "17 mm"
outer_radius = "34 mm"
k_i = "100 N/A"
k_s = "0.5 N/um"
capacity = "300 N"
"""
AXIAL = """inputs = ["thrust.z"]
outputs = ["thrust.i"]
sample_time = "50 us"
delay = 1
[[channel]]
from = "thrust.z"
to = "thrust.i"
gain = -1.0
blocks = [{ type = "pid", kp = "1.2e4 A/m", ki = "1e5 A/(m.s)", kd = "25 A.s/m", roll_off = "2 kHz" }]
"""


@pytest.fixture
def pump(tmp_path):
    """Return a function that writes the pump with another controller of five axes, or one of its axial axis alone."""

    def write(control=lambda text: text, axial=None):
        for name in ("levitation.toml", "rotor.toml"):
            (tmp_path / name).write_text((PUMP / name).read_text(encoding="utf-8"), encoding="utf-8")
        changed = control((PUMP / "control.toml").read_text(encoding="utf-8"))
        (tmp_path / "control.toml").write_text(changed, encoding="utf-8")
        (tmp_path / "axial.toml").write_text(axial or "", encoding="utf-8")
        named = 'controller = "axial.toml"\n' if axial else ""
        (tmp_path / "machine.toml").write_text(OF_PUMP + named, encoding="utf-8")
        return check_machine(load_machine(tmp_path / "machine.toml"))

    return write


def test_the_axial_control_is_that_of_the_machines_controller(pump):
    """The same law as a file of its own, with the same loop to rounding, and no pole of the other axes."""
    of_channel, of_file = pump(), pump(axial=AXIAL)
    assert not of_channel.axial_control.differs_from(of_file.axial_control)
    loops = [axial_cases.load_cases(subject)[0].loop for subject in (of_channel, of_file)]
    ours, theirs = (loop.vibrations for loop in loops)
    np.testing.assert_allclose(ours, theirs, rtol=1e-9)
    hertz = np.geomspace(1.0, 9e3, 30)
    np.testing.assert_allclose(*(loop.sensitivity(hertz) for loop in loops), rtol=1e-9)


PID = 'gain = -1.0\nblocks = [{ type = "pid", kp = "1.2e4'
ON_SPEED = PID.replace("-1.0", '[["0 rpm", -1.0], ["36000 rpm", -0.9]]')
FILES = [("gain = -1.0", "gain = -1.1"), ("delay = 1\n", "delay = 2\n"), ('"50 us"', '"100 us"')]


@pytest.mark.parametrize(
    ("change", "axial", "facts"),
    [
        *((str, AXIAL.replace(*change), ("axial.toml", "differs", "along the shaft")) for change in FILES),
        (
            lambda text: text + '\n[[channel]]\nfrom = "trans_x"\nto = "thrust.i_z"\ngain = 1.0\n',
            None,
            ("rolac_controller.thrust.i_z", "more than the displacement"),
        ),
        (lambda text: text.replace(PID, ON_SPEED), None, ("rolac_controller.thrust.i_z", "speed", "along the shaft")),
    ],
)
def test_an_axial_control_that_is_no_law_of_the_displacement_is_refused(pump, change, axial, facts):
    with raises_naming(ValueError, *facts):
        pump(change, axial)


def test_a_thrust_bearing_without_any_controller_is_refused():
    file = load_machine(FILE)
    data = file.thrust_bearing.model_dump(exclude_none=True)
    del data["controller"]
    without = file.model_copy(update={"thrust_bearing": ThrustBearing(**data)})
    with raises_naming(ValueError, file.name, "needs a controller", "north.x"):
        check_machine(without)
