"""The part of a plan that determines the state at a communication point: runs with the same past share this state.

Everything at the point or later is excluded: events, the end, points of profiles, later stop conditions.
"""

from __future__ import annotations

from typing import Any

from amb_cosim.cosim.system.experiment import Plan, Ramp
from amb_cosim.cosim.system.stopping import Condition
from amb_cosim.cosim.system.system import Signal


def state_fingerprint(plan: Plan, n: int) -> dict[str, Any]:
    """Return the data of a plan and its FMUs that determine the state before communication point n, as JSON data."""
    fmus, interfaces = plan.fmus, plan.interfaces
    return {
        "fmus": {c: fmus[c].folder.name if c in plan.assembly.from_elsewhere else interfaces[c].guid for c in fmus},
        "parameters": plan.all_parameters(),
        **({"texts": plan.all_texts()} if plan.texts else {}),
        "connections": {link.target: link.text for link in plan.system.connections},
        "signals": {signal.name: [*signal.targets, *_laws(signal)] for signal in plan.system.signals},
        "every": {c.name: c.every for c in plan.system.components},
        "coupling": plan.system.coupling,
        **plan_past(plan, n),
    }


def _laws(signal: Signal) -> list[str]:
    return [f"{target}: {factor!r}, {offset!r}" for target, (factor, offset) in signal.laws.items()]


def plan_past(plan: Plan, n: int) -> dict[str, Any]:
    """Return the part of `state_fingerprint` that differs among plans of the same system and parameters."""
    inputs = {name: value for name, value in plan.inputs.items() if value != _start_value(plan, name)}
    return {
        "communication_step": plan.step_size,
        **({} if plan.start_time == 0.0 else {"start_time": plan.start_time}),
        **({} if plan.stop_time is None or n < plan.last else {"end": plan.stop_time}),
        "settling": [plan.settling, plan.first, plan.turn],
        "record": [plan.record_from, plan.record_every],
        "inputs": inputs,
        "events": [list(event) for event in sorted(plan.events, key=lambda event: event[0]) if event[0] < n],
        "profiles": {ramp.variable: [list(point) for point in _begun(ramp, n)] for ramp in plan.ramps},
        "stops": [name_of(condition) for condition in plan.stops if condition.first < n],
    }


def name_of(condition: Condition) -> str:
    """Return a text that identifies a condition: its text, and the point from which it is checked."""
    return f"{condition.text} from point {condition.first}"


def _start_value(plan: Plan, name: str) -> float:
    """Return the value of an input or tunable parameter that nothing sets."""
    component, port = plan.port(name)
    return plan.parameters[component].get(port.name, port.start or 0.0)


def _begun(ramp: Ramp, n: int) -> tuple[tuple[int, float], ...]:
    """Return the points of a profile before point n, and the next one, to which the line before point n leads."""
    before = sum(point < n for point, _ in ramp.points)
    return ramp.points[: before + 1]
