"""Worst phase of a landing, sought and by grids: `python -m benchmarks.worst_phase`; it takes minutes.

Peak force of `drop` over the phase at which the power goes, 720 phases, run once. A grid is as sure as the search if it
finds as much wherever its first phase lies, or if the search's own measure says so of it in the mean.
"""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.system.values import Raw
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.sweeps.adaptive import Goal, Sampler
from amb_cosim.sweeps.sampling import SamplePlan, make_design
from amb_cosim.sweeps.worker import PointResult, Runner, Task

METRIC = "peak_contact_force"
PHASES, SEARCHES = 720, 24
CERTAINTIES = (0.01, 0.005, 0.002)
UNBALANCE: dict[str, Raw] = {"rotor_contact.d?.u": "2.3 g.m"}


def results() -> list[PointResult]:
    """Return what each phase leads to."""
    runner = Runner(Task(load_scenario("drop"), UNBALANCE, until=0.1, labels=("step",)))
    result = [runner.run(n, {"step.cycle": n / PHASES}) for n in range(PHASES)]
    runner.close()
    return result


def sampler(design: SamplePlan, certainty: float) -> Sampler:
    """Return one that knows nothing."""
    return Sampler(design, Goal("maximum", METRIC, certainty=certainty))


def searched(design: SamplePlan, values: np.ndarray, certainty: float) -> tuple[int, float, float]:
    """Return runs, what is missed, and what the search says that may be missed (N)."""
    search, ran = sampler(design, certainty), list[int]()
    while not (requested := search.next_points(1))[1]:
        search.learn(PointResult(n, "completed", "", {METRIC: values[n]}) for n in requested[0])
        ran += requested[0]
    return len(ran), float(values.max() - values[ran].max()), search.promise


def measure() -> None:
    """Print runs of searches and of grids that are as sure."""
    design = make_design({"step.cycle": [n / PHASES for n in range(PHASES)]})
    values = np.array([result.metrics[METRIC] for result in results()])
    counts = [n for n in range(6, PHASES // 2) if PHASES % n == 0]
    misses = {n: max(values.max() - values[k :: PHASES // n].max() for k in range(PHASES // n)) for n in counts}
    print(f"{PHASES} phases: {values.min():.1f} to {values.max():.1f} N")
    for n, missed in misses.items():
        print(f"grid of {n}: misses {missed:.2f} N at worst")
    for certainty in CERTAINTIES:
        shifts = range(0, PHASES, PHASES // SEARCHES)
        runs, missed, promise = np.array([searched(design, np.roll(values, k), certainty) for k in shifts]).T
        as_good = min(n for n in counts if misses[n] <= missed.max())
        message = f"misses {missed.max():.2f} N at worst, says up to {promise.max():.2f} N"
        print(
            f"certainty {certainty:g}: {runs.min():.0f} to {runs.max():.0f} runs, {message}; like a grid of {as_good}"
        )


if __name__ == "__main__":
    measure()
