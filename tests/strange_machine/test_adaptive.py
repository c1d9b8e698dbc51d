"""The worst phase of a landing of the expander, sought among those of a turn."""

from __future__ import annotations

import numpy as np
import pytest
from strange_machine import TOUCHDOWN

from amb_cosim.scenario.scenario import Scenario
from amb_cosim.sweeps.sampling import make_design
from amb_cosim.sweeps.worker import Runner, Task

pytest.importorskip("sklearn")

from amb_cosim.sweeps.adaptive import Goal, Sampler  # after it is known that sklearn is there

PEAK = "peak_contact_force"


@pytest.mark.slow
def test_worst_phase_of_a_landing_takes_a_third_of_the_runs():
    """Of as many phases as the grid has that misses what the search left open."""
    design = make_design({"step.cycle": [2.0 + k / 72.0 for k in range(72)]})
    runner = Runner(Task(Scenario.load(TOUCHDOWN).changed(end_cycle=8), labels=("step",)))
    sampler, ran = Sampler(design, Goal("maximum", PEAK, certainty=0.01)), []
    while not (requested := sampler.next_points(1))[1]:
        results = [runner.run(n, design.settings(n)) for n in requested[0]]
        sampler.learn(results)
        ran += results
    assert sampler.periodic == ["step.cycle"]
    whole = np.array([runner.run(n, design.settings(n)).metrics[PEAK] for n in range(design.size)])
    runner.close()
    assert whole.max() - max(result.metrics[PEAK] for result in ran) <= sampler.promise
    assert 3 * len(ran) <= design.size
