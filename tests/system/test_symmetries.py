"""The whole loop, with nonlinear magnets and a landing: turned by 90 degrees, and with the rotor's ends exchanged."""

from pathlib import Path

import numpy as np
import pytest
from machine_variants import mirrored, read, toml_text

import amb_cosim
from amb_cosim.scenario.scenario import load_scenario

LEVITATION = Path(__file__).parents[1] / "amb_assessment" / "assessment" / "blower" / "levitation.toml"
CLEARANCE = 0.2e-3
WEIGHT = 66.180 * 9.81  # N
PLACES = ("td_a", "td_b", "amb_a", "amb_b")
POWER_LOST = {"label": "power_lost", "time": 0.0, "set": {"amb_actuator": {"*.amplifier_off_?": True}}}
IDEAL = {"chain.noise": False, "chain.adc": False}  # noise differs from axis to axis


def landing(gravity_angle=225.0, phase=0.0, end_time="12 ms", mu=0.12, **changes):
    """Signals of the blower, which loses its power at cycle 0 and touches its retainers 6.4 ms later."""
    fields = {
        "gravity_angle": f"{gravity_angle} deg",
        "settle_cycles": 5,
        "end_time": end_time,
        "parameters": {"rolac_controller": IDEAL, "rotor_contact": {"*.mu": mu}},
        "inputs": {"rotor_contact": {"motor.phi": phase}},
        "event": [POWER_LOST],
    }
    return amb_cosim.run(load_scenario(str(LEVITATION)).changed(**fields | changes), progress=False).signals


def signal(signals, name):
    return np.asarray(signals[f"rotor_contact.{name}"].values)


def orbit(signals, place):
    """Motion x + j y (m) of a place of the rotor."""
    return signal(signals, f"{place}.x") + 1j * signal(signals, f"{place}.y")


@pytest.fixture(scope="module")
def plain():
    return landing()


def assert_alike(signals, plain, turn=1.0):
    """Assert that a landing equals another one rotated: orbits, contact, forces and heat."""
    assert signal(plain, "td_a.f_n_peak").max() > WEIGHT
    for place in PLACES:
        np.testing.assert_allclose(orbit(signals, place), turn * orbit(plain, place), atol=1e-5 * CLEARANCE)
    for name in ("td_a.mode", "td_b.mode"):
        np.testing.assert_array_equal(signal(signals, name), signal(plain, name))
    for name in ("td_a.f_n_mean", "td_b.f_n_mean", "energy.dissipated"):
        largest = np.abs(signal(plain, name)).max()
        np.testing.assert_allclose(signal(signals, name), signal(plain, name), atol=1e-4 * largest)


def test_a_loop_rotated_by_90_degrees_rotates_its_motion(plain):
    """Gravity and unbalance turn; then the other coils carry the weight."""
    turned = landing(315.0, 0.5 * np.pi)
    assert_alike(turned, plain, 1j)


def test_a_rotor_with_exchanged_ends_moves_alike(plain, tmp_path):
    rotor = tmp_path / "rotor.toml"
    rotor.write_text(toml_text(mirrored(read(LEVITATION.parent / "rotor.toml"))), encoding="utf-8")
    assert_alike(landing(rotor=str(rotor)), plain)
