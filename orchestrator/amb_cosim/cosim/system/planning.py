"""Plans an experiment on the time grid of the master."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import cache, lru_cache
from itertools import compress

import numpy as np

from amb_cosim.cosim.choices import Settling
from amb_cosim.cosim.grid.time_grid import ROUNDING, TimeGrid, in_steps, is_on_grid, nearest_point, whole_steps
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.experiment import EVERYTHING, Experiment, InputChange, Plan, Profile, Ramp
from amb_cosim.cosim.system.replacement import notices
from amb_cosim.cosim.system.stopping import Condition, StopCondition
from amb_cosim.cosim.system.system import Component, System
from amb_cosim.cosim.system.values import Raw, plain_value
from amb_files.checks import errors_in
from amb_files.plain_values import plain_values
from amb_files.suggestions import suggest
from amb_files.wildcards import matches, matching_names
from fmi_export.variables import OverStep


def experiment_plan(
    experiment: Experiment,
    assembly: Assembly,
    settings: Mapping[str, Raw] | None = None,
    values: Assignments | None = None,
) -> Plan:
    """Plan an experiment on the time grid of the master; all times except the end are rounded to the nearest point.

    Parameters
    ----------
    experiment, assembly
        The experiment, and the FMUs of its system.
    settings
        Values by `component.variable`, or by a signal's name, that replace those of the experiment.
    values
        Parameters and initial values of inputs; by default, the values of the system. The values of the experiment, and
        inputs that change later, are added.

    Raises
    ------
    ValueError
        For names that do not exist, values that are not allowed, and times that do not fit the steps.
    """
    values = assembly.assignments() if values is None else values
    with errors_in(experiment.source):
        for name, raw in experiment.inputs.items():
            values.set_first(name, raw)
    for name, raw in plain_values(settings, "set").items():
        values.set(name, raw)
    with errors_in(experiment.source):
        return _planned(experiment, assembly, values)


def _planned(experiment: Experiment, assembly: Assembly, values: Assignments) -> Plan:
    """Return the plan of an experiment with these values."""
    h = experiment.step_size
    system, interfaces = values.system, values.interfaces
    values.set_defaults_of_signals()
    components = tuple(_with_rate(c, values, h) for c in system.components)
    system = replace(system, components=components, coupling=experiment.coupling or system.coupling)
    common = math.lcm(*(_start_grid(c, values, h) for c in system.components))
    origin, first = _beginning(experiment, common)
    last, stop_time = _end(experiment, origin, system, values)
    grid = TimeGrid(h, origin) if stop_time is None else TimeGrid(h, origin, last, stop_time)
    beginning = 0 if experiment.settles else first
    linear = [values.port(profile.variable).type == "Real" for profile in experiment.profiles]
    ramps = tuple(_ramp(profile, values, grid, (beginning, last)) for profile in compress(experiment.profiles, linear))
    held = [_held(p, values, grid, last) for p, is_real in zip(experiment.profiles, linear, strict=True) if not is_real]
    ramped = {name for ramp in ramps for name in (ramp.variable, ramp.slope) if name is not None}
    ramped |= {name for name, _ in held}
    due, partial_events = _without_lacking(experiment.events, values)
    events = [(n, name, value) for name, points in held for n, value in points]
    for event in due:
        name, value = values.read_change(event.variable, event.value)
        if name in ramped:
            raise ValueError(f"an event cannot set {name}, because a profile sets it")
        values.inputs.setdefault(name, values.start_value(event.variable))
        events.append((grid.nearest("time of event", event.time), name, value))
    settling, unsolved = _settling(experiment, common)
    dated = (p.file for p in experiment.profiles if p.has_dates)
    counted = (f"the times of profile {file} are dates; they count from its first row" for file in dict.fromkeys(dated))
    signals = [*values.inputs, *values.outputs]
    patterns = tuple(name for name in experiment.recorded if not values.drops(name, "output"))
    recorded = _recorded(replace(experiment, recorded=patterns), system.unrecorded, signals)
    return Plan(
        assembly=assembly,
        system=system,
        step_size=h,
        first=first,
        last=last,
        parameters=values.parameters,
        inputs=values.inputs,
        events=tuple(events),
        ramps=ramps,
        recorded=recorded,
        stops=tuple(_condition(stop, signals, values, grid, beginning) for stop in experiment.stops),
        record_every=experiment.record_every,
        recorded_each=_recorded_each(experiment, recorded, values) if experiment.record_every > 1 else {},
        record_from=first if experiment.record_settling else 0,
        settling=settling,
        period=experiment.period,
        marks={label: grid.nearest("time of event", time) for label, time in experiment.marks.items()},
        notices=(*notices(system, interfaces, values.inputs, values.dropped), *unsolved, *counted, *experiment.notices),
        warnings=(*experiment.warnings, *_uneven_samples(components, values, h)),
        partial_events=partial_events,
        texts=values.texts,
        start_time=origin,
        stop_time=stop_time,
    )


def _beginning(experiment: Experiment, common: int) -> tuple[float, int]:
    """Return the time of communication point 0 (s), and the first point, which is a multiple of `common`."""
    start = experiment.start_time
    nearest_point("start_time", start, experiment.step_size)
    periods = in_steps(start, common * experiment.step_size)
    if experiment.settles or (periods == round(periods) and start <= 0.0 < experiment.stop_time):
        return 0.0, common * math.floor(periods)
    return start, 0


def _end(experiment: Experiment, origin: float, system: System, values: Assignments) -> tuple[int, float | None]:
    """Return the last communication point, and its time (s) if the step to it is shorter than the others.

    Raises
    ------
    ValueError
        If the run would end before it begins, or a component that steps at every point cannot take a shorter step.
    """
    h, stop = experiment.step_size, experiment.stop_time
    earliest = 0.0 if experiment.settles else experiment.start_time
    if not stop > earliest:
        raise ValueError(f"stop_time = {stop:.12g} s is not allowed; it must be > {earliest:.12g} s, the start")
    nearest_point("stop_time", stop, h, origin)
    steps = in_steps(stop, h, origin)
    if steps == round(steps) and steps > 0:
        return round(steps), None
    rigid = [c.name for c in system.components if c.every == 1 and not values.interfaces[c.name].takes_any_step]
    if rigid:
        raise ValueError(
            f"stop_time = {stop:.12g} s is not allowed; it must be a whole number of communication steps of {h:g} s "
            f"after {origin:g} s, because {', '.join(rigid)} cannot take a shorter last step "
            f"(canHandleVariableCommunicationStepSize)"
        )
    return math.ceil(steps), stop


def _settling(experiment: Experiment, common: int) -> tuple[Settling, list[str]]:
    """Return how a run settles, and a notice if this is not the requested way.

    All components start a step at the same time every `common` communication steps.

    Raises
    ------
    ValueError
        If the motion must be solved for but cannot be.
    """
    reason = experiment.unsolvable
    if experiment.record_settling:
        reason = reason or "record.settling requires a simulated motion before cycle 0"
    if common > 1:
        reason = reason or f"a component samples only every {common} communication steps"
    if experiment.start_time == 0.0:
        return "simulated", []
    if experiment.settling == "simulated" or not reason:
        return experiment.settling, []
    if experiment.settling == "solved":
        raise ValueError(cannot_settle(reason))
    return "simulated", [simulated_settling_notice(reason)]


def cannot_settle(reason: str) -> str:
    """Return the error message for a run that must solve for its settled motion but cannot."""
    return f"settling = 'solved' is not allowed here: {reason}; use settling = 'simulated'"


def simulated_settling_notice(reason: str) -> str:
    """Return the notice for a run that simulates its settling because it cannot solve for the settled motion."""
    return f"the motion before cycle 0 was simulated: {reason}"


def _without_lacking(
    changes: Sequence[InputChange], values: Assignments
) -> tuple[list[InputChange], tuple[tuple[float, str], ...]]:
    """Return the changes of existing variables and, for each event that lacks variables, its time (s) and a sentence.

    Raises
    ------
    ValueError
        If none of the variables of an event exists, because a run would otherwise silently ignore a fault.
    """
    events: dict[tuple[str, float], list[InputChange]] = {}
    for change in changes:
        events.setdefault((change.event, change.time), []).append(change)
    partial = []
    for (event, time), of_one in events.items():
        lacking = [change.variable for change in of_one if values.lacks(change.variable)]
        missing = "; ".join(values.missing(name) for name in dict.fromkeys(lacking))
        if len(lacking) == len(of_one):
            raise ValueError(f"{event} at {time:g} s has no effect: {missing}")
        if lacking:
            partial.append((time, f"{event} at {time:g} s is incomplete: {missing}"))
    return [change for change in changes if not values.lacks(change.variable)], tuple(partial)


def _held(profile: Profile, values: Assignments, grid: TimeGrid, last: int) -> tuple[str, list[tuple[int, float]]]:
    """Return the name of an input that is not a Real, and its changes: communication points and values.

    Of several points nearest to a communication point, the last applies. Before the first row of a file, its value
    applies. Points after the point `last` are only checked.
    """
    read = cache(lambda value: values.read(profile.variable, _stated(value, profile.unit), "input"))
    at: dict[int, float] = {}
    for row, (time, raw) in enumerate(profile.points, 2):
        with errors_in(f"row {row} of profile {profile.file}") if profile.file else nullcontext():
            name, value = read(plain_value(raw, profile.variable))
            if not at or time <= grid.time(last):
                at[grid.nearest(f"point of {profile.variable}", time)] = value
    start = values.start_value(profile.variable) if profile.unit is None else next(iter(at.values()))
    values.inputs[name] = values.inputs.get(name, start) if profile.unit is None else start
    before = (values.inputs[name], *at.values())
    return name, [(n, value) for (n, value), earlier in zip(at.items(), before, strict=False) if value != earlier]


def _stated(value: Raw, unit: str | None) -> Raw:
    """Return a value of a profile as a user writes it: a number with the unit of its column, or a name or Boolean."""
    if not isinstance(value, float):
        return value
    number = int(value) if value.is_integer() else value
    return f"{number} {unit}" if unit else number


def _ramp(profile: Profile, values: Assignments, grid: TimeGrid, span: tuple[int, int]) -> Ramp:
    """Return a profile on the grid of a run that begins and ends at the points `span`."""
    for row, (_, value) in enumerate(profile.points if profile.file else (), 2):
        if isinstance(value, str):
            raise ValueError(
                f"row {row} of profile {profile.file} has {profile.variable} = {value!r}, which is not a number"
            )
    name, _ = values.read(profile.variable, _stated(profile.points[0][1], profile.unit), "input")
    slope = None
    if profile.slope is not None:
        slope, _ = values.read(profile.slope, 0.0, "input")
        values.inputs.setdefault(slope, 0.0)
    values.inputs.setdefault(name, values.start_value(profile.variable))
    if profile.unit is not None:
        return Ramp(name, _sampled(profile, values, grid, span[1]), slope)
    points: list[tuple[int, float]] = []
    if grid.nearest(f"point of {name}", profile.points[0][0]) > span[0]:
        points.append((span[0], values.inputs[name]))
    for time, raw in profile.points:
        n = grid.nearest(f"point of {name}", time)
        if points and n <= points[-1][0]:
            raise ValueError(
                f"the profile point of {name} at {time:g} s is not allowed; it must be at least one communication "
                f"step, {grid.step_size:g} s, after the previous point"
            )
        points.append((n, values.read(profile.variable, raw, "input")[1]))
    return Ramp(name, tuple(points), slope)


def _sampled(profile: Profile, values: Assignments, grid: TimeGrid, last: int) -> tuple[tuple[int, float], ...]:
    """Return the points of a profile with a unit, or its means over the steps if points are closer than a step.

    Of the points after the point `last`, where the run ends, only those are kept that the means or the line before it
    depend on.
    """
    times, numbers = np.array(profile.points, dtype=np.float64).T
    zero, one = (values.read(profile.variable, f"{number} {profile.unit}".strip(), "input")[1] for number in (0, 1))
    h, name = grid.step_size, f"point of {profile.variable}"
    needed = int(np.searchsorted(times, grid.time(last) + 2.0 * h)) + 1
    times, numbers = times[:needed], zero + (one - zero) * numbers[:needed]
    if np.all(np.diff(times) >= h * (1.0 - ROUNDING)):
        points = {grid.nearest(name, t): v for t, v in zip(times, numbers, strict=True)}
        return tuple((n, float(value)) for n, value in points.items())
    first, end = (nearest_point(name, t, h, grid.start) for t in (times[0], times[-1]))
    end = max(first, min(end, last + 1))
    edges = grid.start + h * np.arange(first, end + 2)
    both = np.unique(np.concatenate([edges, times[(times > edges[0]) & (times < edges[-1])]]))
    signal = np.interp(both, times, numbers)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(both) * (signal[1:] + signal[:-1]))])
    means = np.diff(np.interp(edges, both, integral)) / h
    return (*enumerate(means.tolist(), first), (end + 1, float(signal[-1])))


def _sample_time(component: Component, values: Assignments) -> float | None:
    """Return a component's parameter `sample_time` if it is a Real, in s or without a unit, with a value above 0.

    In some FMUs, a parameter of this name has another meaning: 0 and -1 often stand for continuous and inherited.
    """
    port = values.interfaces[component.name].ports.get("sample_time")
    if port is None or (port.causality, port.type) != ("parameter", "Real") or port.unit not in (None, "", "s"):
        return None
    sample_time = values.parameters[component.name].get("sample_time", port.start)
    return sample_time if sample_time is None or sample_time > 0.0 else None


def _with_rate(component: Component, values: Assignments, h: float) -> Component:
    """Return a component with one step for each sample, or unchanged if its FMU can take steps of any length."""
    sample_time, name = _sample_time(component, values), f"{component.name}.sample_time"
    if sample_time is None:
        return component
    if not values.interfaces[component.name].takes_any_step:
        return replace(component, every=whole_steps(name, sample_time, h))
    if component.every * h > (1.0 + ROUNDING) * sample_time:
        raise ValueError(
            f"a step of {component.every * h:g} s is not allowed for {component.name}; it must be at most {name} = "
            f"{sample_time:.12g} s"
        )
    return component


def _uneven_samples(components: Sequence[Component], values: Assignments, h: float) -> Iterator[str]:
    """Yield a warning for each component whose samples fall between communication points.

    If the instant of a sample is within a step, the sample is taken at the beginning of this step
    (`signal_chain.sampling`).
    """
    for component in components:
        sample_time, step = _sample_time(component, values), component.every * h
        if sample_time is not None and not is_on_grid(round(in_steps(sample_time, step)), sample_time, step):
            yield (
                f"{component.name} samples unevenly, up to {step:g} s early: sample_time = {sample_time:.12g} s is "
                f"not a whole multiple of its step of {step:g} s; linear models assume even samples"
            )


def _start_grid(component: Component, values: Assignments, h: float) -> int:
    """Return the spacing, in steps, of the start points that let a component take a sample at time 0."""
    sample_time = _sample_time(component, values)
    samples = nearest_point(f"{component.name}.sample_time", sample_time, h) if sample_time is not None else 1
    fits = sample_time is not None and is_on_grid(samples, sample_time, h)
    return math.lcm(component.every, samples) if fits else component.every


def _condition(
    stop: StopCondition, available: Sequence[str], values: Assignments, grid: TimeGrid, beginning: int
) -> Condition:
    if stop.variable not in available:
        raise ValueError(f"stop: there is no signal {stop.variable!r}; {suggest(stop.variable, available)}")
    return stop.on_grid(values.port(stop.variable), grid, beginning)


def _recorded(experiment: Experiment, unrecorded: Sequence[str], available: Sequence[str]) -> tuple[str, ...]:
    """Return the recorded names; `*` excludes the outputs that the system does not record by default."""
    for pattern in experiment.recorded:
        if pattern != EVERYTHING and not matching_names(available, pattern):
            raise ValueError(f"record.variables: nothing matches {pattern!r}; {suggest(pattern, available)}")
    named = (*(pattern for pattern in experiment.recorded if pattern != EVERYTHING), *experiment.essential)
    watched = tuple(stop.variable for stop in experiment.stops)
    everything = EVERYTHING in experiment.recorded
    return _chosen(tuple(available), named, watched, tuple(unrecorded) if everything else None)


def _recorded_each(experiment: Experiment, recorded: tuple[str, ...], values: Assignments) -> dict[str, OverStep]:
    """Return the variables that a decimated record contains at every step, and how each of them summarises several
    steps.
    """
    chosen = {*_chosen(recorded, tuple(experiment.each), (), None)}
    stated = {
        name: next(rule for pattern, rule in experiment.each.items() if matches(name, pattern)) for name in chosen
    }
    declared = {name: values.port(name).over_step for name in recorded}
    return {name: stated.get(name) or rule for name, rule in declared.items() if name in chosen or rule != "end"}


@lru_cache(maxsize=32)  # the runs of a sweep record the same
def _chosen(
    available: tuple[str, ...], named: tuple[str, ...], watched: tuple[str, ...], excluded: tuple[str, ...] | None
) -> tuple[str, ...]:
    """Return names that are watched or match `named`; unless `excluded` is None, also names that do not match it."""

    def is_recorded(name: str) -> bool:
        return name in watched or _matches(name, named) or (excluded is not None and not _matches(name, excluded))

    return tuple(name for name in available if is_recorded(name))


def _matches(name: str, patterns: Sequence[str]) -> bool:
    return any(matches(name, pattern) for pattern in patterns)
