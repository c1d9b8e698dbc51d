"""The time by which a landing has begun to whirl, from the swing in the clearance and the spin-up of the races."""

import math

import pytest
from scipy.integrate import quad

from amb_assessment.first_design.whirl_onset import FRICTION, STEP, race_of, whirl_onset

G = 9.80665
MASS, SPEED, CLEARANCE = 40.0, 1885.0, 0.15e-3
RACE = race_of(MASS, 0.08)


def test_whirl_of_a_light_spin_has_begun_after_twenty_swings_of_the_clearance():
    """All of 512 landings of such a machine that whirled had begun after 0.41 s; of those cut at 0.1 s, a sixth had."""
    swing = 2.0 * math.pi * math.sqrt(CLEARANCE / G)
    time = whirl_onset(MASS, SPEED, CLEARANCE, RACE)
    assert 0.0 <= time - (20.0 * swing + math.sqrt(2.0 * CLEARANCE / G)) < STEP
    assert time > 0.41


def test_nothing_whirls_once_the_races_turn_with_the_rotor():
    """The torque mu r W/2 on each race, integrated until the race has the speed of the rotor."""
    slow = 0.1 * SPEED
    torque = FRICTION * RACE.radius * 0.5 * MASS * G
    spun_up = quad(lambda _: RACE.inertia / torque, 0.0, slow)[0]
    time = whirl_onset(MASS, slow, CLEARANCE, RACE)
    assert 0.0 <= time - spun_up - math.sqrt(2.0 * CLEARANCE / G) < STEP
    assert time < whirl_onset(MASS, SPEED, CLEARANCE, RACE)


def test_a_wider_clearance_and_a_steeper_shaft_swing_more_slowly():
    """Periods grow with the root of the clearance over the gravity across; an upright rotor does not swing."""
    fast = 10.0 * SPEED
    times = [whirl_onset(MASS, fast, 4.0 * CLEARANCE, RACE, tilt) for tilt in (0.0, math.pi / 3.0, math.pi / 2.0)]
    assert times[0] == pytest.approx(2.0 * whirl_onset(MASS, fast, CLEARANCE, RACE), abs=2.0 * STEP)
    assert times[1] == pytest.approx(math.sqrt(2.0) * times[0], abs=2.0 * STEP)
    assert times[2] == pytest.approx(RACE.inertia * fast / (FRICTION * RACE.radius * 0.5 * MASS * G), abs=STEP)
