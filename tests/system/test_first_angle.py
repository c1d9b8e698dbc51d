"""The rotor angle at cycle 0 is the stated one, for any step in any notation."""

import math

import numpy as np
import pytest

import amb_cosim
from amb_cosim.scenario.scenario import make_scenario

STEPS = {
    2.5e-5: ["25 us", "0.025 ms", "25e-6 s", "2.5e-5", "0.000025 s", "25000 ns", "0.25e2 us", "2.5e-2 ms"],
    5e-5: ["50 us", "0.05 ms", "50e-6 s", "5e-5", "0.00005 s", "50000 ns", "0.5e2 us", "5e-2 ms"],
    1e-4: ["100 us", "0.1 ms", "100e-6 s", "1e-4", "0.0001 s", "100000 ns", "1e2 us", "1e-1 ms"],
    2.5e-4: ["250 us", "0.25 ms", "250e-6 s", "2.5e-4", "0.00025 s", "250000 ns", "2.5e2 us", "25e-2 ms"],
}
WHOLE, ODD = "250 Hz", "1579.3 rad/s"  # a turn of 160, 80, 40 and 16 steps; and one of no whole number


def angle_at_cycle_0(step, speed, cycles=3.0, **parameters):
    """Return theta (rad, from -pi to pi) at cycle 0."""
    scenario = make_scenario(
        {
            "system": "passive",
            "communication_step": step,
            "Omega": speed,
            "settle_cycles": cycles,
            "end_time": 5e-4,
            "parameters": {"rotor_contact": parameters},
            "record": {"variables": ["rotor_contact.theta"]},
        },
        "angle",
    )
    signals = amb_cosim.run(scenario, progress=False).signals
    assert signals["time"].values[0] == 0.0
    return math.remainder(signals["rotor_contact.theta"].values[0], 2.0 * math.pi)


@pytest.mark.parametrize("speed", [WHOLE, ODD])
@pytest.mark.parametrize("step", STEPS)
def test_every_spelling_of_a_step_gives_the_angle_of_whole_turns(step, speed):
    angles = [angle_at_cycle_0(text, speed) for text in STEPS[step]]
    np.testing.assert_allclose(angles, 0.0, atol=1e-9)


@pytest.mark.parametrize("speed", [WHOLE, ODD])
@pytest.mark.parametrize(("cycles", "angle"), [(0.0, 0.0), (0.3, 0.0), (2.3, 1.2), (40.0, -1.0)])
def test_part_of_a_turn_and_the_stated_angle_add_up(speed, cycles, angle):
    found = angle_at_cycle_0("50 us", speed, cycles, **{"initial.angle": angle})
    assert math.remainder(found - angle - 2.0 * math.pi * cycles, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_shorter_step_does_not_turn_the_rotor():
    """With steps of 97 us a turn at 400 Hz is 25.77 steps: the angle was 14 degrees off."""
    assert angle_at_cycle_0("97 us", "400 Hz", 40.0) == pytest.approx(0.0, abs=1e-9)


def test_a_rotor_at_rest_has_the_stated_angle():
    assert angle_at_cycle_0("97 us", "0 Hz", 3.3, **{"initial.angle": 0.5}) == pytest.approx(0.5, abs=1e-12)
