"""How long single steps take: who runs the models in a loop with real hardware needs the longest below a sample."""

from __future__ import annotations

import numpy as np

from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import prepare
from benchmarks.baseline import Baseline

SCENARIOS = ("fig4_9", "fig4_14", "rolling_90")  # impacts and rubbing, sustained contact, rolling


def step_times(rounds: int) -> dict[str, dict[str, float]]:
    """Return median, 99.9th percentile and maximum of the time (us) of a step, and its sample time, by scenario.

    The native models of a scenario run in one loop without FMI. A run does the same in every round, so that a step
    counts with its shortest time: what else the machine did in it is left out.
    """
    return {name: _step_times(name, rounds) for name in SCENARIOS}


def _step_times(name: str, rounds: int) -> dict[str, float]:
    prepared = prepare(load_scenario(name), flavour="native")
    shortest = 1e6 * np.min([Baseline(prepared).run(profile=True).steps for _ in range(rounds)], axis=0)
    return {
        "median": float(np.median(shortest)),
        "percentile_99_9": float(np.percentile(shortest, 99.9)),
        "maximum": float(shortest.max()),
        "sample": 1e6 * prepared.plan.step_size,
    }
