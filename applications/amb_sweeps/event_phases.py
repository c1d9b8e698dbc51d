"""Later moments of a disturbance within a turn of the rotor.

A rotor that loses its power falls from any point of its orbit, at any angle of its unbalance, and these decide on
bounces and whirl. All events from the disturbance on are therefore delayed together, by n - 1 parts of a turn:

    t_k = t + k T/n,   T = 2 pi/Omega(t),   k = 1 ... n - 1                                       (1)

The moment of a mere change of unbalance is not varied, because it turns with the rotor.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from amb_cosim.cosim.system.values import Raw
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.scenario import UNBALANCE, Scenario
from amb_cosim.scenario.scenario_tables import Event
from amb_cosim.scenario.stators import switches_amplifiers_off

CONFIDENCE = 0.95


def with_labels(scenario: Scenario) -> Scenario:
    """Return a scenario in which every event has a label or a role, so that settings can delay it."""
    taken = {event.name for event in scenario.event}
    free = iter(name for k in range(2 * len(scenario.event) + 1) if (name := f"event_{k + 1}") not in taken)
    events = [event if event.name else event.model_copy(update={"label": next(free)}) for event in scenario.event]
    return (
        scenario
        if all(event.name for event in scenario.event)
        else scenario.changed(event=[_as_data(event) for event in events])
    )


def _as_data(event: Event) -> dict[str, object]:
    return event.model_dump(mode="json", exclude_none=True)


def disturbance_of(plan: ScenarioPlan) -> Event | None:
    """Return the first event whose moment within a turn decides on the motion; None if there is none.

    It switches amplifiers off, or has the role `disturbance` and changes anything but unbalances.
    """
    assignments, period = plan.assembly.assignments(), plan.scenario.period

    def matters(event: Event) -> bool:
        patterns = [f"{component}.{name}" for component, values in event.set.items() for name in values]
        changed = [name for pattern in patterns for name in assignments.matching(pattern)]
        of_unbalance = all(assignments.port(name).unit == UNBALANCE for name in changed)
        return switches_amplifiers_off(event) or (event.role == "disturbance" and not of_unbalance)

    return min(filter(matters, plan.scenario.event), key=lambda event: event.moment(period), default=None)


def delays(plan: ScenarioPlan, event: Event, phases: int) -> dict[str, Mapping[str, Raw]]:
    """Return the settings that delay an event, and all events after it, by the times (1), by the words of the change.

    Parameters
    ----------
    plan
        The unchanged scenario; its events have labels or roles (`with_labels`).
    event
        The event.
    phases
        The number n of phases.

    Raises
    ------
    ValueError
        If the rotor is at rest at the event.
    """
    period, first = plan.scenario.period, event.moment(plan.scenario.period)
    speed = _speed_at(plan, first)
    if not speed:
        raise ValueError("the rotor is at rest, so the event has no phase")
    moments = {e.name: moment for e in plan.scenario.event if (moment := e.moment(period)) >= first}
    result: dict[str, Mapping[str, Raw]] = {}
    for k in range(1, phases):
        delay = k / phases * 2.0 * math.pi / speed
        name = f"{event.name.replace('_', ' ')} {360.0 * k / phases:g} deg later"
        result[name] = dict[str, Raw]({f"{label}.time": moment + delay for label, moment in moments.items()})
    return result


def _speed_at(plan: ScenarioPlan, time: float) -> float:
    """Return the speed (rad/s) that a scenario prescribes at a time (s)."""
    if not plan.profile:
        return abs(plan.speed)
    points, speeds = zip(*plan.profile, strict=True)
    return float(abs(np.interp(time, [plan.time(n) for n in points], speeds)))


def undetected_share(phases: int) -> float:
    """Return the largest share of phases with another outcome that n phases without one leave possible.

    p = 1 - 0.05^(1/n), with a confidence of 95 % (C. J. Clopper, E. S. Pearson, Biometrika 26 (1934) 404-413), as if
    the phases were drawn at random.
    """
    return float(1.0 - (1.0 - CONFIDENCE) ** (1.0 / phases))
