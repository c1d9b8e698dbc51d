"""Write a prepared run as plain data, for other masters to run the same FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from amb_cosim.scenario.plan import ScenarioPlan

_KINDS: dict[str, type] = {"Real": float, "Integer": int, "Boolean": bool}


def plain_system(plan: ScenarioPlan, recorded: Sequence[str]) -> dict[str, Any]:
    """Return the arguments of the functions in `peers`, for a run from point 0 without events."""
    system = plan.system
    start: dict[str, dict[str, Any]] = {
        component: {v: _KINDS[plan.interfaces[component].ports[v].type](value) for v, value in values.items()}
        for component, values in plan.start_values().items()
    }
    return {
        "fmus": {c.name: str(plan.fmus[c.name].path) for c in system.components},
        "start": start,
        "connections": [[link.source, link.target] for link in system.connections],
        "recorded": list(recorded),
        "step_size": plan.step_size,
        "steps": plan.last,
        "every": {c.name: c.every for c in system.components},
    }
