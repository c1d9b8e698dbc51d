"""The end of a run is a number of seconds or a time with its unit, wherever it is given."""

import pytest
from strange_machine import LEVITATION

from amb_cosim.scenario.plan_run import plan_run
from amb_cosim.scenario.scenario import Scenario
from tests.support.messages import raises_naming


@pytest.mark.parametrize("until", ["10 ms", "0.01s", "0.01", "10000 us"])
def test_a_run_ends_at_a_time_given_with_its_unit(until):
    scenario = Scenario.load(LEVITATION)
    assert plan_run(scenario, until=until).plan.last == plan_run(scenario, until=0.01).plan.last


def test_what_is_no_time_does_not_end_a_run():
    with raises_naming(ValueError, "until", "'3 mm'", "unit mm", "s"):
        plan_run(Scenario.load(LEVITATION), until="3 mm")
