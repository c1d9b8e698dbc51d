"""Checks the variations of a sweep, value by value, before any run."""

from __future__ import annotations

from contextlib import suppress

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.scenario.plan import SPEED
from amb_cosim.scenario.plan_run import PlannedRun
from amb_files.wildcards import matches
from amb_sweeps.panels import common_words, first_words
from amb_sweeps.sampling import SamplePlan
from amb_sweeps.worker import Runner, Task, event_of

FAR = 100.0  # times the scenario's value


def check_points(task: Task, design: SamplePlan) -> tuple[dict[str, str], dict[str, str], dict[str, str]]:
    """Check the values of a sweep one by one; return GUIDs of its FMUs, and units and descriptions of its variations.

    FMUs are built if necessary.

    Raises
    ------
    ValueError
        If a name or a value is invalid, or a number without a unit is far from the scenario's.
    """
    runner = Runner(task)
    guids: dict[str, str] = {}
    units: dict[str, str] = {}
    described: dict[str, str] = {}
    sampled = design.sampling != "grid" and len(design.axes) == 1
    for point in (0, design.size - 1) if sampled else design.corners():
        settings = design.settings(point)
        planned = runner.plan(settings)
        if not set(guids) >= {fmu.path.stem for fmu in planned.fmus.values()}:
            guids |= {planned.fmus[c].path.stem: interface.guid for c, interface in planned.interfaces.items()}
        for name in settings:
            label, ports = event_of(task.scenario, name), _ports_of(planned, _without_event(task, name))
            if ports and ports[0].unit:
                units.setdefault(name, ports[0].unit)
                _refuse_far(task, planned, name, settings[name])
            if words := common_words([port.description for port in ports]):
                since = f", from the {label.replace('_', ' ')} on" if label else ""
                described.setdefault(name, first_words(words) + since if label else words)
    return guids, units, described


def _without_event(task: Task, name: str) -> str:
    """Return the name of the varied variable, without the event that sets it."""
    return name.removeprefix(f"{event_of(task.scenario, name)}.")


def unit_of(planned: PlannedRun, name: str) -> str:
    """Return the unit of a variation; empty if it has none or is not a variable."""
    ports = _ports_of(planned, name)
    return (ports[0].unit or "") if ports else ""


def _ports_of(planned: PlannedRun, name: str) -> list[Port]:
    """Return the variables that are varied under a name; empty if it is not a variable."""
    values = planned.assembly.assignments()
    try:
        return [values.port(result) for result in values.matching(name)]
    except ValueError:
        return []


def _refuse_far(task: Task, planned: PlannedRun, name: str, value: Raw) -> None:
    """Refuse a number without a unit that is more than `FAR` times the scenario's: it may be meant in another unit.

    If that is 0, the largest value of this unit that the component has is in its place.
    """
    local, unit = _value_of(task, planned, name), unit_of(planned, _without_event(task, name))
    whose = "the scenario's"
    if local == 0.0:
        local, whose = _largest_alike(task, planned, name), "the largest of its kind,"
    if isinstance(value, int | float) and unit != "1" and 0.0 < FAR * local < abs(value):
        raise ValueError(
            f"{name} = {value:g} {unit} is {abs(value) / local:.3g} times {whose} {local:.4g} {unit}; add the "
            f"intended unit, such as {name}='{value:g} {unit}'"
        )


def _largest_alike(task: Task, planned: PlannedRun, name: str) -> float:
    """Return the largest magnitude among the component's inputs or parameters of the same unit in the scenario."""
    component, port = _without_event(task, name).partition(".")[0], _ports_of(planned, _without_event(task, name))[0]
    interface = planned.interfaces.get(component)
    alike = [] if interface is None else [p for p in interface.of(port.causality) if p.unit == port.unit]
    changed = [event.set.get(component, {}) for event in task.scenario.event]
    sizes = [_value_of(task, planned, f"{component}.{other.name}") for other in alike]
    for values in changed:
        for pattern, raw in values.items():
            with suppress(ValueError):
                if any(matches(other.name, pattern) or other.name == pattern for other in alike):
                    sizes.append(abs(quantity(raw, port.unit or "1", pattern)))
    return max(sizes, default=0.0)


def _value_of(task: Task, planned: PlannedRun, name: str) -> float:
    """Return the largest magnitude of a variation in the scenario itself, or its start value; 0 if there is none."""
    label, variable = event_of(task.scenario, name), _without_event(task, name)
    scenario, values = task.scenario, planned.assembly.assignments()
    of_event = [event.set for event in scenario.event if label and event.name == label]
    tables = of_event or [scenario.parameters, scenario.inputs]
    settings = {
        f"{component}.{variable}": raw
        for table in tables
        for component, of in table.items()
        for variable, raw in of.items()
    }
    if not label:
        settings |= {SPEED: scenario.Omega, **task.settings}
    varied, result = {*values.matching(variable)}, []
    for available, raw in settings.items():
        with suppress(ValueError):  # the name is not part of this machine
            if varied & {*values.matching(available)}:
                result.append(abs(quantity(raw, unit_of(planned, variable), available)))
    return max(result) if result else max(abs(port.start or 0.0) for port in _ports_of(planned, variable))
