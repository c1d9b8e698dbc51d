"""Scenarios that solve for their settled motion have that to which they would settle."""

import math
from dataclasses import replace

import numpy as np
import pytest

from amb_cosim.cosim.run.run_plan import run_plan
from amb_cosim.scenario.plan_run import plan_run
from amb_cosim.scenario.scenario import load_scenario

CLEARANCE = 0.75e-3  # m


def nearest_settling(first, advance, least):
    """Return a point `least` steps or more before 0 from which the angle at 0 is what it is from `first`."""
    candidates = np.arange(least, least + round(30.0 * math.pi / advance))
    off = (candidates + first) * advance
    return -int(candidates[np.argmin(np.abs((off + math.pi) % (2.0 * math.pi) - math.pi))])


@pytest.mark.parametrize(("name", "cycles"), [("fig4_9", 200), ("fig4_5", 80), ("fig4_7", 100)])
def test_the_settled_motion_is_that_of_long_settling(name, cycles):
    planned = plan_run(load_scenario(name), until=0.05)
    plan = replace(planned.plan, settling="solved")
    advance = planned.speed * plan.step_size
    first = nearest_settling(plan.first, advance, round(cycles * 2.0 * math.pi / advance))
    plans = replace(plan, first=first), replace(plan, first=first, settling="simulated")
    solved, settled = (run_plan(planned.assembly, item).recorder.table for item in plans)
    orbits = [name.startswith("rotor_contact.") and name[-2:] in (".x", ".y") for name in plan.recorded]
    assert sum(orbits) > 8
    assert np.abs(solved - settled)[:, orbits].max() < 1e-9 * CLEARANCE
