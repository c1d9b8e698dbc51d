"""Who is timed: each is a function that makes a run and says how long (s) one of its steps took.

Inside a timing are steps, the exchange of values between the models, and recording, from the end of settling to the end
of the run. Outside are start and initialisation, settling, the labelled data set and files.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

from amb_cosim.cosim.fmus import Flavour
from amb_cosim.cosim.master import Loop
from amb_cosim.simulation import Prepared, run_prepared
from benchmarks import cases, peers
from benchmarks.baseline import Floor
from benchmarks.process import Unfinished, call, python_with
from benchmarks.system import plain_system
from benchmarks.timing import Candidate

HERE = files("benchmarks")

Missing = dict[str, str]


def native_possible() -> bool:
    """Whether there is the compiler of native FMUs."""
    return importlib.util.find_spec("ziglang") is not None


def ours(prepared: Prepared, loop: Loop) -> Candidate:
    """This project's master."""

    def step_time() -> float:
        result = run_prepared(prepared, loop=loop)
        if result.outcome.failure is not None:
            raise Unfinished(result.outcome.failure)
        return float(result.dataset.attrs["wall_s"]) / prepared.plan.last

    return step_time


def floor(prepared: Prepared) -> Candidate:
    """The loop without FMI."""
    return lambda: Floor(prepared).run().seconds / prepared.plan.last


def parts_of_floor(prepared: Prepared, parts: dict[str, list[float]]) -> Candidate:
    """The same, which adds to `parts` how long (s) each part of a step took. Looking at the clock costs some."""

    def step_time() -> float:
        found = Floor(prepared).run(profile=True)
        for part, seconds in found.parts.items():
            parts.setdefault(part, []).append(seconds / prepared.plan.last)
        return found.seconds / prepared.plan.last

    return step_time


def on_fig4_9(flavour: Flavour, parts: dict[str, list[float]]) -> dict[str, Candidate]:
    """FIG4_9 with both loops, and for native FMUs the floor, as it is and by `parts`."""
    prepared = cases.fig4_9(flavour)
    found: dict[str, Candidate] = {flavour: ours(prepared, "compiled")}  # what is compared comes one after the other
    if flavour == "native":
        found |= {"floor": floor(prepared), "floor_by_parts": parts_of_floor(prepared, parts)}
    return found | {f"{flavour}_plain": ours(prepared, "plain")}


def on_rub(seconds: float, missing: Missing) -> dict[str, Candidate]:
    """RUB with native FMUs: this master, ecos, libcosim."""
    prepared = cases.rub("native", seconds)
    system = plain_system(prepared, recorded=[])
    found = {"rub_native": ours(prepared, "compiled")}
    for package, function in (("ecospy", "with_ecos"), ("libcosimpy", "with_libcosim")):
        if importlib.util.find_spec(package) is None:
            missing[package] = "not installed (extra: peers)"
        else:
            _add(found, missing, package, sys.executable, peers.__file__, function, system)
    return found


def on_ring(seconds: float, missing: Missing) -> dict[str, Candidate]:
    """RING: the native plant under this master, ROSS, Siconos."""
    prepared = cases.ring("native", seconds)
    found = {"ring_native": ours(prepared, "compiled")}
    steps = prepared.plan.last
    others: list[tuple[str, str, str, Callable[[], dict[str, Any]]]] = [
        ("ross", "ross", "ross_rotor.py", lambda: cases.ring_for_ross() | {"step": cases.STEP, "steps": steps}),
        *(
            (name, "siconos.kernel", "siconos_rotor.py", partial(_for_siconos, reduced, steps))
            for name, reduced in (("siconos", False), ("siconos_reduced", True))
        ),
    ]
    for name, module, file, given in others:
        python = python_with(module)
        if python is None:
            missing[name] = "neither this Python nor a python3 on the PATH has it"
        else:
            _add(found, missing, name, python, str(HERE / file), "seconds_per_step", given())
    return found


def _for_siconos(reduced: bool, steps: int) -> dict[str, Any]:
    return cases.ring_for_siconos(reduced) | {"h": cases.STEP, "steps": steps}


def _add(
    found: dict[str, Candidate],
    missing: Missing,
    name: str,
    python: str,
    file: str,
    function: str,
    given: dict[str, Any],
) -> None:
    """Add one that runs in a process of its own, if it can."""

    def step_time() -> float:
        return float(call(python, file, function, **given)["seconds"])

    try:
        step_time()
    except Unfinished as error:
        missing[name] = str(error)
    else:
        found[name] = step_time
