"""Magnets, amplifiers and delay from closed-loop responses, which state-space arithmetic of a rigid rotor made."""

import tomllib

import numpy as np
import pytest

from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement
from amb_analysis.studies.fitted_machine import FittedMachine
from amb_cosim import studies
from tests.support.messages import raises_naming

ROTOR = """
name = "spindle"

[shaft]
youngs_modulus = {modulus}
density = 7800.0
poissons_ratio = 0.3

[[shaft.sections]]
length = 0.4
diameter = 0.05

[[bodies]]
name = "wheel"
z = 0.2
mass = 5.0
radius = 0.05
width = 0.02

[[bearings]]
name = "left"
z = 0.05

[[bearings]]
name = "right"
z = 0.35

[[sensors]]
name = "probe_left"
z = 0.08

[[sensors]]
name = "probe_right"
z = 0.33

[[sites]]
name = "catch"
z = 0.2
clearance = 2e-4

[damping]
modal = 0.05
"""
SCENARIO = """
rotor = "spindle.toml"
Omega = "10 rpm"
gravity = 0
communication_step = "50 us"
settle_cycles = 0
end_time = "0.1 s"
fmu.rolac_controller = "law.npz"

[parameters.amb_actuator]
force_law = "measured"
amplifier = "dynamic"
"*.k_s_measured_?" = "5e5 N/m"
"*.k_i_measured_?" = "100 N/A"
"*.bandwidth_?" = "1.2 kHz"

[parameters.rolac_controller]
delay = 1.0
"""
SAMPLE, KP, KD = 50e-6, 1.4e4, 28.0  # s, A/m, A s/m
TRUE = {
    "amb_actuator.*.k_s_measured_?": 6.1e5,
    "amb_actuator.*.k_i_measured_?": 108.0,
    "amb_actuator.*.bandwidth_?": 1000.0,
    "rolac_controller.delay": 1.35,
}
FREE = [
    "amb_actuator.*.k_s_measured_?=3e5:9e5",
    "amb_actuator.*.k_i_measured_?=70 N/A:150 N/A",
    "amb_actuator.*.bandwidth_?=0.5 kHz:3 kHz",
    "rolac_controller.delay=0.5:2.5",
]
MAGNETS, PROBES, WHEEL = np.array([-0.15, 0.15]), np.array([-0.12, 0.13]), 0.0  # m from the centre of mass
F = np.geomspace(5.0, 600.0, 120)


def exact_responses(k_s, k_i, bandwidth, delay):
    """Return displacements of the wheel and of the left magnet over a force at the wheel and a current of the left one.

    The states are those of a rigid rotor, v' = f/m and w' = sum z f/J, and of the amplifiers, i' = 2 pi b (demand - i).
    The demand is the law at z = exp(j omega T), held over a sample and late by the delay.
    """
    shaft = 7800.0 * np.pi * 0.025**2 * 0.4
    m = shaft + 5.0
    J = shaft * (0.4**2 / 12 + 0.025**2 / 4) + 5.0 * (0.05**2 / 4 + 0.02**2 / 12)
    omega_b = 2 * np.pi * bandwidth
    A, B = np.zeros((6, 6)), np.zeros((6, 3))  # x, tilt, v, w, currents; demands and a force at the wheel
    A[:2, 2:4] = np.eye(2)
    at = np.stack([np.ones(2), MAGNETS])  # motion by the displacements, and force by the magnets
    inertia = np.diag([1 / m, 1 / J])
    A[2:4, :2], A[2:4, 4:] = inertia @ at @ (k_s * at.T), inertia @ at * k_i
    A[4:, 4:], B[4:, :2] = -omega_b * np.eye(2), omega_b * np.eye(2)
    B[2:4, 2] = inertia @ [1.0, WHEEL]
    read = np.zeros((4, 6))
    read[:2, :2], read[2, 0], read[3, :2] = np.stack([np.ones(2), PROBES], axis=1), 1.0, [1.0, MAGNETS[0]]
    result = []
    for omega in 2 * np.pi * F:
        z = np.exp(1j * omega * SAMPLE)
        G = read @ np.linalg.solve(1j * omega * np.eye(6) - A, B)
        law = -(KP + KD / SAMPLE * (1 - 1 / z)) * np.eye(2)
        held = (1 - 1 / z) / (1j * omega * SAMPLE) * np.exp(-1j * omega * delay * SAMPLE)
        probes = np.linalg.solve(np.eye(2) - G[:2, :2] @ law * held, G[:2])
        motion = G[2:] + G[2:, :2] @ law * held @ probes
        result.append(motion[:, [2, 0]])
    return np.array(result)


def measured(noise=0.01, seed=1, **true):
    values = list((TRUE | true).values())
    H, rng = exact_responses(*values), np.random.default_rng(seed)
    H = H * np.exp(noise * (rng.standard_normal(H.shape) + 1j * rng.standard_normal(H.shape)))
    places, drives = ("wheel.x", "left.x"), (("wheel.f_x", "N"), ("left.i_x", "A"))
    return Measurement(
        tuple(
            FrequencyResponse(Channel(place, "m"), Channel(*drive), F, H[:, k, j])
            for k, place in enumerate(places)
            for j, drive in enumerate(drives)
        )
    )


@pytest.fixture
def spindle(tmp_path):
    (tmp_path / "spindle.toml").write_text(ROTOR.format(modulus=2e13))
    (tmp_path / "levitation.toml").write_text(SCENARIO)
    names = [f"probe_{side}.{axis}" for side in ("left", "right") for axis in "xy"]
    law = {
        "A": np.zeros((4, 4)),
        "B": np.eye(4),
        "C": KD / SAMPLE * np.eye(4),
        "D": -(KP + KD / SAMPLE) * np.eye(4),
        "Ts": SAMPLE,
        "inputs": np.array(names),
        "outputs": np.array([f"{side}.i_{axis}" for side in ("left", "right") for axis in "xy"]),
    }
    np.savez(tmp_path / "law.npz", **law)
    return tmp_path / "levitation.toml"


def test_a_closed_loop_has_the_response_of_the_state_space(spindle):
    start = {"amb_actuator.*.k_s_measured_?": 5e5, "amb_actuator.*.k_i_measured_?": 100.0}
    true = start | {"amb_actuator.*.bandwidth_?": 1200.0, "rolac_controller.delay": 1.0}
    result = studies.response(spindle, measured=measured(noise=0.0, **true))
    for curve in result.responses.values():
        np.testing.assert_allclose(curve.computed, curve.measured, rtol=3e-3)


def test_magnets_amplifiers_and_delay_are_found_in_closed_loop_data(spindle, tmp_path):
    data = measured()
    result = studies.fit(scenario=spindle, measured=data, free=FREE)
    for (name, fitted), true in zip(result.fit.parameters.items(), TRUE.values(), strict=True):
        assert fitted.lower < true < fitted.upper, name
        assert fitted.upper - fitted.lower < 0.1 * true, name
    assert result.fit.rms_after == pytest.approx(0.01, rel=0.1)
    assert result.fit.rms_before > 3.0 * result.fit.rms_after
    studies.save(result, tmp_path / "out")
    again = studies.response(tmp_path / "out/scenario.toml", measured=data)
    for name, curve in again.responses.items():
        np.testing.assert_allclose(curve.computed, result.after.responses[name].computed, rtol=1e-9)


@pytest.mark.slow
def test_a_mass_of_the_rotor_file_is_fitted_beside_the_magnets(spindle, tmp_path):
    """The controller keeps its gains; the scenario that is written has the fitted rotor."""
    true = {"amb_actuator.*.bandwidth_?": 1200.0, "rolac_controller.delay": 1.0}
    data = measured(**true)
    result = studies.fit(scenario=spindle, measured=data, free=[*FREE[:2], "bodies.wheel.mass=3:8"])
    mass = result.fit.parameters["bodies.wheel.mass"]
    assert mass.lower < 5.0 < mass.upper < 5.1
    studies.save(result, tmp_path / "out")
    again = studies.response(tmp_path / "out/scenario.toml", measured=data)
    for name, curve in again.responses.items():
        np.testing.assert_allclose(curve.computed, result.after.responses[name].computed, rtol=1e-9)


def test_the_gains_of_a_controller_do_not_follow_the_fitted_magnets(spindle):
    """`rolac_controller` takes its K_i and K_s from the scenario's magnets: the measured one has those of before."""
    pid = '[parameters.rolac_controller]\nsample_time = "50 us"\n"*.k_b_?" = 8e5\n"*.c_b_?" = 2000\n"*.i_max_?" = 5\n'
    text = spindle.read_text().replace('fmu.rolac_controller = "law.npz"\n', "")
    spindle.write_text(text.partition("[parameters.rolac_controller]")[0] + pid)
    bounds = {"amb_actuator.*.k_i_measured_?": (70, 150), "amb_actuator.*.k_s_measured_?": ("3e5 N/m", 9e5)}
    machine = FittedMachine.load((spindle, None, None), "closed", None, bounds, {}, "native")
    assert machine.start == (100.0, 5e5)
    assert machine.structure_with((108.0, 6.1e5)).machine.parameters["rolac_controller"]["left.k_i_x"] == 100.0
    written = tomllib.loads(machine.files_with((108.0, 6.1e5))["scenario.toml"])["parameters"]
    assert written["amb_actuator"]["right.k_i_measured_y"] == 108.0
    assert written["rolac_controller"]["right.k_i_y"] == 100.0
    assert written["rolac_controller"]["left.k_s_x"] == 5e5


@pytest.mark.parametrize(
    ("free", "settings", "facts"),
    [
        ("amb_actuator.left.k_i_measured_z=90:110", {}, ("amb_actuator.left.k_i_measured_z", "left.k_i_measured_x")),
        ("amb_actuator.left.gap_x=0.3 mm:2 mm", {}, ("amb_actuator.left.gap_x", "leave it out")),
        ("amb_actuator.force_law=0:2", {}, ("amb_actuator.force_law", "parameter", "Enumeration")),
        ("amb_actuator.left.bandwidth_x=1 kg:2 kg", {}, ("amb_actuator.left.bandwidth_x", "1 kg", "Hz")),
        ("amb_actuator.left.bandwidth_x=-5:2000", {}, ("amb_actuator.left.bandwidth_x", "-5", "Hz")),
        ("amb_actuator.*.k_i_measured_?=9:200", {"amb_actuator.left.k_i_measured_x": 90.0}, ("90 N/A", "100 N/A")),
        ("amb_actuator.left.k_i_measured_y=70:150", {}, ("amb_actuator.left.k_i_measured_y", "leave it out")),
        ("amb_actor.left.k_i_measured_x=70:150", {}, ("amb_actor",)),
        ("bodies.wheel.mass=3 kg:8 kg", {}, ("bodies.wheel.mass", "3 kg", "unit of the file")),
    ],
)
def test_parameters_that_the_data_do_not_contain_are_refused(spindle, free, settings, facts):
    with raises_naming(ValueError, *facts):
        studies.fit(scenario=spindle, measured=measured(), free=[free], set=settings)


def test_a_free_rotor_of_a_scenario_is_that_of_the_scenario(spindle):
    """The responses were those of the packs' default rotor."""
    result = studies.response(spindle, loop="free", inputs=["wheel.f_x"], outputs=["wheel.x"], up_to="100 Hz")
    assert result.rotor == "spindle"
