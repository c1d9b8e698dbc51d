"""How many runs one process does in several threads: the loop and native FMUs never need Python's lock."""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from statistics import median

from amb_cosim.scenario.simulation import PlannedRun, run_prepared
from benchmarks import cases

RUNS_PER_THREAD = 2
RECORDED = {"variables": ["rotor_contact.rb1.f_n"]}  # to label the results of a run is Python's work, under its lock


def runs_per_second(seconds: float, rounds: int) -> dict[str, dict[int, float]]:
    """Return the runs of the rubbing case of `seconds` (s) in a second of real time, by the number of threads.

    `runs` are the runs, `simulated_s` the seconds that they simulate. Every thread has its own FMU instances. There are
    as many threads as this process has processors, and fewer.
    """
    prepared = cases.rubbing_case("native", seconds, record=RECORDED)
    run_prepared(prepared)
    counts = range(1, len(os.sched_getaffinity(0)) + 1) if hasattr(os, "sched_getaffinity") else range(1, 3)
    times: dict[int, list[float]] = {count: [] for count in counts}
    for _ in range(rounds):
        for count in counts:
            times[count].append(_time_of_a_run(prepared, count))
    rates = {count: 1.0 / median(each) for count, each in times.items()}
    return {"runs": rates, "simulated_s": {count: seconds * rate for count, rate in rates.items()}}


def _time_of_a_run(prepared: PlannedRun, n_threads: int) -> float:
    """Return the time (s) of so many threads' runs, by their number."""
    n_runs = RUNS_PER_THREAD * n_threads
    begin = time.perf_counter()
    with ThreadPoolExecutor(n_threads) as pool:
        failed = [r.outcome.failure for r in pool.map(lambda _: run_prepared(prepared), range(n_runs))]
    if any(failed):
        raise RuntimeError(f"a run in {n_threads} threads failed: {next(f for f in failed if f)}")
    return (time.perf_counter() - begin) / n_runs
