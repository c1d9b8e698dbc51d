"""Controllers of other rotors than the rig: one bearing in one sensor plane, three bearings among five planes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from controller_bench import Bench
from rig import LOOP

from amb_cosim.model_constants.controller_data import pack
from fmi_export.model import Fault
from rolac_controller.control_loop import ControlLoop, SensorPlane
from rolac_controller.controller import FAULT_PLANES
from rolac_controller.enumerations import ADAPTING, NOT_STARTED, SLOT_BEFORE, last_stages
from tests.support.messages import raises_naming

H = 250e-6
OMEGA = 2.0 * math.pi / (40 * H)
MASS = 40.0  # kg
ONE = ControlLoop(("amb",), (SensorPlane("probe", "probe.x", "probe.y", 0.2),), ("probe",))
THREE = ControlLoop(
    ("mb1", "mb2", "mb3"),
    tuple(SensorPlane(f"p{k}", f"p{k}.x", f"p{k}.y", 0.4 * k) for k in range(5)),
    ("p3", "p0", "p2"),
)
loops = pytest.mark.parametrize("loop", [ONE, LOOP, THREE], ids=["one bearing", "the rig", "three bearings"])


def random_receptance(loop, seed=3):
    rng = np.random.default_rng(seed)
    return 1e-6 * (rng.normal(size=loop.shape) + 1j * rng.normal(size=loop.shape))


@loops
def test_pid_brings_a_mass_on_every_axis_to_the_centre(loop):
    """Each axis supports a mass that its bearing destabilises with K_s; only the sensors of its feedback measure it."""
    machine = Bench(loop=loop)
    k_s = machine[f"{loop.bearings[0]}.k_s_x"]
    at = [loop.sensor_names.index(axis.sensor) for axis in loop.axes]
    x, v = 1e-4 * (1.0 + np.arange(len(at))), np.zeros(len(at))
    start = x.copy()
    for _ in range(2000):
        displacements = np.zeros(loop.shape[0])
        displacements[at] = x
        machine.sense(displacements)
        machine.sample()
        force = machine.axis_forces()
        for _ in range(20):  # substeps of the masses
            v += (k_s * x + force) / MASS * H / 20
            x += v * H / 20
    assert np.all(np.abs(x) < 1e-4 * start)


@loops
def test_rolac_settles_at_the_least_squares_optimum(loop):
    """The plant is Q = Q_0 + R U without delay; the optimum is that of NumPy."""
    R = random_receptance(loop)
    Q_0 = 1e-4 * np.exp(1j * np.arange(loop.shape[0]))
    table = pack(loop, [1.0], [R])
    machine = Bench(table, loop, pid=False, Omega=OMEGA, rolac_enable=1.0, rolac__force_limit=1e9)
    for _ in range(6000):
        machine.sense(((Q_0 + R @ machine.forces()) * np.exp(1j * machine.theta)).real)
        machine.sample()
    assert machine["rolac_status"] == ADAPTING
    optimum = np.linalg.lstsq(R, -Q_0, rcond=None)[0]
    np.testing.assert_allclose(machine.forces(), optimum, rtol=1e-3, atol=1e-3 * np.abs(optimum).max())
    turning = machine.forces() * np.exp(1j * (machine.theta - OMEGA * H))
    np.testing.assert_allclose(machine.axis_forces(), turning.real)


@loops
def test_identification_finds_the_receptance_of_its_rotor(loop):
    """A slot for each axis and two idle ones; the plant follows held forces without delay."""
    rng = np.random.default_rng(5)
    gain = 1e-6 * rng.normal(size=loop.shape)
    machine = Bench(loop=loop, pid=False, sample_time=1.0 / 300.0, Omega=2.0 * math.pi * 15.0)
    stages = set()
    done = last_stages(loop.shape[1]).done
    for n in range(45 * 20 * (loop.shape[1] + 2) + 200):
        machine["identify"] = float(n > 30)
        machine.sense(gain @ machine.axis_forces())  # one sample late
        machine.sample()
        stages.add(machine["identification_state"])
        if machine["identification_state"] == done:
            break
    assert stages == {NOT_STARTED, *range(SLOT_BEFORE, done + 1)}
    assert machine["identification_error"] == 0.0
    late = np.exp(-1j * machine["Omega"] / 300.0)
    np.testing.assert_allclose(machine.receptance(), gain * late, rtol=1e-6, atol=1e-12)
    assert machine["table_rows"] == 1


@loops
def test_each_bearing_has_a_bit_of_the_contact_state(loop):
    for k, bearing in enumerate(loop.bearings):
        machine = Bench(loop=loop, Omega=OMEGA, contact__source=2, contact_state=2.0**k)
        for _ in range(200):
            machine.sample()
        shares = {name: machine[f"{name}.contact_share"] for name in loop.bearings}
        assert shares.pop(bearing) > 0.9
        assert not any(shares.values())


def test_suspect_sensor_is_numbered_over_all_planes():
    machine = Bench(loop=THREE, Omega=OMEGA)
    for n in range(200):
        signals = 1e-5 * np.cos(machine.theta + np.arange(10.0))
        signals[8] = 3e-6
        machine.sense(signals)
        machine.sample()
        assert n < 45 or machine["suspect_sensor"] == 9


def test_offset_sensor_reads_a_polynomial_of_the_fourth_degree():
    """Five planes interpolate it without error, and four would not."""
    shape = np.polynomial.Polynomial([1e-4, -2e-4, 3e-4, 1e-4, -2e-4])
    reading = Bench(loop=replace(THREE, feedback=("p3", "p1", "p2")), plane2__offset=0.1)
    z = np.array([plane.position for plane in THREE.planes])
    reading.sense(np.repeat(shape(z), 2))
    reading.sample()
    stiffness = reading["mb2.k_b_x"] + reading["mb2.k_s_x"]
    assert reading.axis_forces()[2] == pytest.approx(-stiffness * shape(0.5), rel=1e-12)


def test_sensor_planes_at_one_place_are_refused():
    with raises_naming(Fault, "plane5.z", "0.4 m") as refused:
        Bench(loop=THREE, plane5__z=0.4)
    assert refused.value.code == FAULT_PLANES


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"feedback": ("p3", "p0")}, ("'mb3'", "p0, p1, p2, p3, p4")),
        ({"feedback": ("p3", "p0", "q")}, ("'mb3'", "'q'")),
        ({"feedback": ("p3", "p0", "p0")}, ("'mb3'", "'p0'")),
        ({"bearings": (), "feedback": ()}, ("0 bearings", "1 to 30")),
        ({"planes": (), "feedback": ()}, ("'mb1'", "no sensor planes")),
    ],
)
def test_a_loop_without_sensors_for_each_bearing_is_refused(changes, facts):
    with raises_naming(ValueError, *facts):
        replace(THREE, **changes)
