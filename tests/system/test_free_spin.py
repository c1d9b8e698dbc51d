"""The levitated rotor with a free spin: its controller receives the actual speed, not the demanded one."""

import numpy as np
import pytest

import amb_cosim
from amb_cosim.scenario.scenario import make_scenario
from rolac_controller.enumerations import TOO_SLOW

MIN_SPEED = 2.0 * np.pi * 5.0  # rad/s, rolac.min_speed


@pytest.fixture(scope="module")
def coasting():
    """A rotor that coasts down from 45 rad/s against viscous drag, with ROLAC on."""
    scenario = make_scenario(
        {
            "system": "levitated_free_spin",
            "Omega": "45 rad/s",
            "settle_cycles": 0,
            "end_time": "0.5 s",
            "parameters": {"rotor_contact": {"spin.inertia": 0.5, "spin.drag": 0.5}},
            "inputs": {"rolac_controller": {"rolac_enable": True}},
        },
        "coasting",
    )
    return amb_cosim.run(scenario, progress=False).dataset


def test_coasting_rotor_slows_down_exponentially(coasting):
    """Omega(t) = Omega_0 exp(-c t/J)."""
    expected = 45.0 * np.exp(-coasting["time"].values)
    np.testing.assert_allclose(coasting["rotor_contact.speed"].values, expected, rtol=1e-6)


def test_controller_receives_the_actual_speed_and_not_the_demand(coasting):
    """ROLAC stops in the first sample after the speed has fallen below its minimum."""
    speed, status = coasting["rotor_contact.speed"].values, coasting["rolac_controller.rolac_status"].values
    assert speed[0] > MIN_SPEED > speed[-1]
    np.testing.assert_array_equal(status[1:] == TOO_SLOW, speed[:-1] < MIN_SPEED)


def free_spin(**fields):
    """A free spin whose drive, of 5 N m, cannot hold the speed against 22.5 N m of drag."""
    base = {
        "system": "levitated_free_spin",
        "Omega": "45 rad/s",
        "settle_cycles": 2.3,
        "end_time": "0.2 s",
        "parameters": {"rotor_contact": {"spin.inertia": 0.5, "spin.drag": 0.5, "drive.gain": 2.0}},
        "inputs": {"rotor_contact": {"drive.torque_limit": 5.0}},
    }
    return make_scenario(base | fields, "free")


def trip(time):
    return [{"label": "trip", "time": time, "set": {"rotor_contact": {"drive.torque_limit": 0.0}}}]


@pytest.mark.parametrize("time", [0.0, 0.05])
def test_the_speed_is_held_until_the_first_event(time):
    signals = amb_cosim.run(free_spin(event=trip(time)), progress=False).signals
    t, speed = signals["time"].values, signals["rotor_contact.speed"].values
    np.testing.assert_array_equal(speed[t <= time + 1e-9], 45.0)
    np.testing.assert_allclose(speed[t > time], 45.0 * np.exp(-(t[t > time] - time)), rtol=1e-6)
    angle = signals["rotor_contact.theta"].values[0]
    assert angle == pytest.approx(0.3 * 2.0 * np.pi, abs=1e-9)


def test_a_drive_at_its_limit_is_a_warning():
    held, after = (amb_cosim.run(free_spin(event=event), progress=False) for event in (trip(0.0), ()))
    for result in (held, after):
        assert any("drive.torque_limit = 5 N.m" in sentence for sentence in result.summary.warnings)
    assert after.signals["rotor_contact.speed"].values[0] == 45.0
    assert after.signals["rotor_contact.speed"].values[-1] < 40.0


def test_a_drive_set_by_the_scenario_is_unchanged():
    inputs = {"rotor_contact": {"drive.torque_limit": 5.0, "drive.ideal": False}}
    signals = amb_cosim.run(free_spin(inputs=inputs), progress=False).signals
    assert signals["rotor_contact.speed"].values[0] < 40.0


def test_lost_spin_energy_becomes_heat():
    """Spin energy against heat: of drag, and of the damping of the small lateral motion."""
    signals = amb_cosim.run(free_spin(event=trip(0.0), settle_cycles=0), progress=False).signals
    speed, heat = signals["rotor_contact.speed"].values, signals["rotor_contact.energy.damping"].values
    lost = 0.25 * (speed[0] ** 2 - speed[-1] ** 2)
    assert heat[-1] - heat[0] == pytest.approx(lost, rel=1e-6)
    assert signals["rotor_contact.energy.kinetic"].values[0] == pytest.approx(0.25 * 45.0**2, rel=1e-9)
