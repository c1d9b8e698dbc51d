"""The stability of a run's loop, from its linear model, which an application computes.

The applications import this package, so their function is looked up by its entry point. It loads the models and their
compiler, which takes longer than a short run. Answers are therefore stored beside the rotor's FMU in the cache.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint
from pathlib import Path

from amb_cosim.cosim.fmu.fmus import MADE_FROM_FILE, model_of
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.scenario.control_loop import exciting_components
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.scenario import SPEED
from amb_files.atomic import write_file
from amb_files.packs import entry_points_of
from amb_files.wildcards import matches

GROUP = "amb_cosim.loop_stability"  # entry point of a function of a plan and a speed (rad/s)
FILE, MOST = "loops.json", 100  # beside an FMU, and the number of its newest answers

# Inputs of controllers and actuators that move the operating point and add forces, but do not change the loop.
OUTSIDE = (
    *("Omega", "rolac_enable", "identify", "shown_harmonic", "*.set_?", "*.setpoint", "*.feedforward"),
    *("*.fault_offset", "*.fault_noise", "*.command_voltage_?"),
)


def loop_at_the_end(plan: ScenarioPlan, end: float, Omega: float, *, stores: bool = True) -> LoopStability | None:
    """Return the stability of a run's loop at its final speed; None if the loop has no linear model, or has changed.

    The result is None if a component of the loop is not a model of this project, or if an input or an event switches
    off, freezes or changes a part of it by the end of the run.

    Parameters
    ----------
    plan
        Plan of the run.
    end, Omega
        Time (s) and spin speed (rad/s) at the end of the run.
    stores
        Whether the answer is stored for the next run; those of a sweep are too many.
    """
    exciting, components = exciting_components(plan.system), plan.system.components
    kinds = {c.name: model_of(c.fmu) for c in components if c.name not in exciting}
    is_ours = {*kinds.values()} <= {PLANT, ACTUATOR, CONTROLLER, *MADE_FROM_FILE.values()}
    entry = _entry_point()
    if entry is None or PLANT not in kinds or not is_ours:
        return None
    if _has_changed(plan, end, [name for name, kind in kinds.items() if kind != PLANT]):
        return None
    if not stores:
        return _computed(entry, plan, Omega)
    key, file = _key(entry, plan, Omega), plan.fmus[PLANT].folder.parent / FILE
    answers = _answers(file)
    if key not in answers:
        computed = _computed(entry, plan, Omega)
        answers[key] = None if computed is None else computed.to_json()
        with suppress(OSError):  # another user's cache
            write_file(file, json.dumps(dict([*answers.items()][-MOST:])))
    text = answers[key]
    return None if text is None else LoopStability(**json.loads(text))


@cache
def _entry_point() -> EntryPoint | None:
    return next(iter(entry_points_of(GROUP)), None)


def _computed(entry: EntryPoint, plan: ScenarioPlan, Omega: float) -> LoopStability | None:
    analysis: Callable[[ScenarioPlan, float], LoopStability | None] = entry.load()
    return analysis(plan, Omega)


def _answers(file: Path) -> dict[str, str | None]:
    with suppress(OSError, ValueError):
        answers: dict[str, str | None] = json.loads(file.read_text(encoding="utf-8"))
        return answers
    return {}


def _key(entry: EntryPoint, plan: ScenarioPlan, Omega: float) -> str:
    """Return an identifier of all that determines a loop: FMUs, connections, parameters, speed, and the analysis."""
    system = plan.system
    folders = {name: fmu.folder.parent.name for name, fmu in plan.fmus.items()}  # their names contain digests
    wiring = repr(system.components), repr(system.connections), repr(system.signals), system.coupling
    speeds = sorted(item for item in plan.inputs.items() if item[0].endswith(f".{SPEED}"))  # of single components
    facts = folders, wiring, plan.all_parameters(), plan.all_texts(), plan.step_size, Omega, speeds
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode() + _code(entry.module)).hexdigest()[:32]


@cache
def _code(module: str) -> bytes:
    """Return a digest of the files beside a module, which is not imported."""
    package, *rooms, _ = module.split(".")
    spec, sha = PathFinder.find_spec(package), hashlib.sha256()
    if spec is not None and spec.origin is not None:
        for file in sorted(Path(spec.origin).parent.joinpath(*rooms).glob("*.py")):
            sha.update(file.read_bytes())
    return sha.digest()


def _has_changed(plan: ScenarioPlan, end: float, controlling: Iterable[str]) -> bool:
    """Return whether inputs or events have changed the loop by a time (s), given its controllers and actuators."""
    inputs = {f"{name}.{port.name}": port for name in plan.interfaces for port in plan.interfaces[name].of("input")}
    done = [(name, value) for n, name, value in plan.events if plan.time(n) <= end]
    if any("." in name and name not in inputs for name, _ in done):  # a parameter
        return True
    varied = {ramp.variable for ramp in plan.ramps}
    for name, value in {**plan.inputs, **dict(done)}.items():
        component, _, variable = name.partition(".")
        if component not in controlling or name not in inputs or any(matches(variable, each) for each in OUTSIDE):
            continue
        if name in varied or value != (inputs[name].start or 0.0):
            return True
    return False
