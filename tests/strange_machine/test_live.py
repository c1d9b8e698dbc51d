"""The live rig draws magnets where they pull the rotor, and nowhere else."""

from __future__ import annotations

from strange_machine import LEVITATION

from amb_cosim.live.rig import magnetic_bearings
from amb_cosim.scenario.scenario import Scenario
from amb_cosim.scenario.simulation import prepare


def test_a_passive_bearing_has_no_magnets():
    assert magnetic_bearings(prepare(Scenario.load(LEVITATION))) == ("north", "south")
