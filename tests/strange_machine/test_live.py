"""The live rig draws magnets where they pull the rotor, and nowhere else."""

from strange_machine import LEVITATION

from amb_cosim.results.places import places_of
from amb_cosim.scenario.plan_run import plan_run
from amb_cosim.scenario.scenario import Scenario


def test_a_passive_bearing_has_no_magnets():
    assert places_of(plan_run(Scenario.load(LEVITATION)).assembly).magnetic == ("north", "south")
