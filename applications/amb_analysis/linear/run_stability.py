"""Whether the loop of a run is stable at the end of the run, from the linear models of its components."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from amb_analysis.linear.linear_source import LINEAR, LinearSource, source_of_run
from amb_analysis.linear.loop import Loop
from amb_cosim.cosim.processes.blas import one_blas_thread
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.scenario.plan import ScenarioPlan
from amb_files.wildcards import matches

# Inputs of controllers and actuators that move the operating point and add forces, but do not change the loop.
OUTSIDE = (
    *("Omega", "rolac_enable", "identify", "shown_harmonic", "*.set_?", "*.setpoint", "*.feedforward"),
    *("*.fault_offset", "*.fault_noise", "*.command_voltage_?"),
)


_kept: list[LinearSource] = []  # of the last assembly: the runs of a sweep share the constants of its models


@one_blas_thread()
def stability_at_the_end(plan: ScenarioPlan, end: float, Omega: float) -> LoopStability | None:
    """Return the stability of a run's loop at its final speed; None if the loop has no linear model, or has changed.

    The result is None if a component of the loop is not a model of this project, or if an input or an event switches
    off, freezes or changes a part of the loop by the end of the run.

    Parameters
    ----------
    plan
        Plan of the run.
    end, Omega
        Time (s) and spin speed (rad/s) at the end of the run.
    """
    source = _source(plan)
    try:
        loop = Loop(source)
        kinds = {name: source.kind(name) for name in loop.components}
        is_ours = {*kinds.values()} <= {PLANT, ACTUATOR, CONTROLLER, LINEAR}
        if not is_ours or _has_changed(plan, end, [name for name, kind in kinds.items() if kind != PLANT]):
            return None
        return loop.poles(Omega).stability
    except (ValueError, np.linalg.LinAlgError):  # no magnets, several sample times, a loop without delay
        return None


def _source(plan: ScenarioPlan) -> LinearSource:
    if _kept and _kept[0].plan.assembly is plan.assembly:
        return _kept[0].with_plan(plan)
    _kept[:] = [source_of_run(plan)]
    return _kept[0]


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
