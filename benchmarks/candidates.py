"""The candidates: functions that make a run and return its time per step (s).

The time includes the steps, the exchange of values between the models, and recording, from the end of settling to the
end of the run. It excludes start and initialisation, settling, the labelled data set and files.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

from amb_cosim.cosim.choices import Flavour, Loop
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.simulation import execute
from benchmarks import cases, peers
from benchmarks.baseline import Baseline
from benchmarks.process import CandidateFailed, find_python_with, run_function
from benchmarks.system import plain_system
from benchmarks.timing import Candidate

HERE = files("benchmarks")

Missing = dict[str, str]


def native_possible() -> bool:
    """Return whether native FMUs can be built here."""
    return importlib.util.find_spec("ziglang") is not None


def master_candidate(prepared: ScenarioPlan, loop: Loop) -> Candidate:
    """Run with this project's master."""

    def step_time() -> float:
        result = execute(prepared, RunOptions(loop=loop))
        if result.outcome.failure is not None:
            raise CandidateFailed(result.outcome.failure)
        return float(result.dataset.attrs["wall_s"]) / prepared.last

    return step_time


def baseline_candidate(prepared: ScenarioPlan) -> Candidate:
    """Run in one loop without FMI."""
    return lambda: Baseline(prepared).run().seconds / prepared.last


def profiled_baseline_candidate(prepared: ScenarioPlan, parts: dict[str, list[float]]) -> Candidate:
    """Run in one loop without FMI and append the time (s) of each part of a step to `parts`.

    Reading the clock takes time too, so this run is slower than that of `baseline_candidate`.
    """

    def step_time() -> float:
        result = Baseline(prepared).run(profile=True)
        for part, seconds in result.parts.items():
            parts.setdefault(part, []).append(seconds / prepared.last)
        return result.seconds / prepared.last

    return step_time


def fig4_9_candidates(flavour: Flavour, parts: dict[str, list[float]]) -> dict[str, Candidate]:
    """Return candidates for `fig4_9`: both loops and, for native FMUs, the baseline with and without `parts`.

    Candidates that are compared with each other run one after the other.
    """
    prepared = cases.fig4_9(RunOptions(flavour=flavour))
    result: dict[str, Candidate] = {flavour: master_candidate(prepared, "compiled")}
    if flavour == "native":
        result |= {
            "floor": baseline_candidate(prepared),
            "floor_by_parts": profiled_baseline_candidate(prepared, parts),
        }
    return result | {f"{flavour}_plain": master_candidate(prepared, "plain")}


def rubbing_candidates(seconds: float, missing: Missing) -> dict[str, Candidate]:
    """Return candidates for the rubbing case with native FMUs: this master, ecos, libcosim."""
    prepared = cases.rubbing_case(seconds)
    system = plain_system(prepared, recorded=[])
    result = {"rub_native": master_candidate(prepared, "compiled")}
    for package, function in (("ecospy", "with_ecos"), ("libcosimpy", "with_libcosim")):
        if importlib.util.find_spec(package) is None:
            missing[package] = "not installed (extra: peers)"
        else:
            _add_process(result, missing, package, sys.executable, peers.__file__, function, system)
    return result


def retainer_candidates(seconds: float, missing: Missing) -> dict[str, Candidate]:
    """Return candidates for the retainer case: the native plant under this master, ROSS, Siconos."""
    prepared = cases.retainer_case(seconds)
    result = {"ring_native": master_candidate(prepared, "compiled")}
    steps = prepared.last
    others: list[tuple[str, str, str, Callable[[], dict[str, Any]]]] = [
        (
            "ross",
            "ross",
            "ross_rotor.py",
            lambda: cases.retainer_case_for_ross() | {"step": cases.STEP, "steps": steps},
        ),
        *(
            (name, "siconos.kernel", "siconos_rotor.py", partial(_for_siconos, reduced, steps))
            for name, reduced in (("siconos", False), ("siconos_reduced", True))
        ),
    ]
    for name, module, file, arguments in others:
        python = find_python_with(module)
        if python is None:
            missing[name] = "not installed for this Python, nor for a python3 on the PATH"
        else:
            _add_process(result, missing, name, python, str(HERE / file), "seconds_per_step", arguments())
    return result


def _for_siconos(reduced: bool, steps: int) -> dict[str, Any]:
    return cases.retainer_case_for_siconos(reduced) | {"h": cases.STEP, "steps": steps}


def _add_process(
    candidates: dict[str, Candidate],
    missing: Missing,
    name: str,
    python: str,
    file: str,
    function: str,
    arguments: dict[str, Any],
) -> None:
    """Add a candidate that runs in a process of its own; if it fails, note in `missing` why."""

    def step_time() -> float:
        return float(run_function(python, file, function, **arguments)["seconds"])

    try:
        step_time()
    except CandidateFailed as error:
        missing[name] = str(error)
    else:
        candidates[name] = step_time
