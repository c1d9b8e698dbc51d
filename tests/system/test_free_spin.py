"""The levitated rotor with a free spin: its controller sees the speed that the plant has, not the one demanded."""

from __future__ import annotations

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


def test_controller_notices_the_speed_of_the_rotor_not_the_demanded_one(coasting):
    """ROLAC gives up in the first sample after the speed has fallen below its least one."""
    speed, status = coasting["rotor_contact.speed"].values, coasting["rolac_controller.rolac_status"].values
    assert speed[0] > MIN_SPEED > speed[-1]
    np.testing.assert_array_equal(status[1:] == TOO_SLOW, speed[:-1] < MIN_SPEED)
