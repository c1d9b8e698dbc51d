"""Runs the points of a sweep in a worker process, which loads the FMUs of a scenario once."""

from __future__ import annotations

import pickle
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from amb_cosim.cosim.errors import FmuError, ProcessFailed, StartFailed
from amb_cosim.cosim.master.instances import InstancePool
from amb_cosim.cosim.run.execution import execute_plan
from amb_cosim.cosim.run.options import DEFAULTS, RunOptions
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.places import RotorPlaces, places_of
from amb_cosim.results.result import Result
from amb_cosim.scenario.make_result import bare_signals, make_result
from amb_cosim.scenario.plan import ScenarioPlan, ScenarioStart, late_changes, scenario_plan, start_of
from amb_cosim.scenario.prepare_run import assemble_scenario
from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_cosim.scenario.scenario_tables import Event
from amb_cosim.scenario.stators import reasons_for_stators
from amb_files.suggestions import suggest
from amb_sweeps.axes import is_moment
from amb_sweeps.branching import Branches
from amb_sweeps.metrics import evaluate, needed, outcome_of
from amb_sweeps.variations import Setting

Metric = Callable[[Result], Mapping[str, float]]
FIELDS = (
    *("unbalance_factor", "settle_cycles", "end_cycle", "end_time", "gravity", "gravity_angle", "coupling"),
    *("rotor", "receptances"),
)
OTHER_VARIABLES = ("outcome", "reason", "seconds", "metric_error")  # of the store, beside the metrics
GENERAL = (AttributeError, ImportError, NameError, TypeError)  # errors of a function itself, rather than of one result
_ASSEMBLED_FROM = ("system", "rotor", "receptances", "gradient", "fmu")  # fields of a scenario


@dataclass(frozen=True)
class Task:
    """The task that all points of a sweep share: a run whose settings are overridden by the values of a point.

    Parameters
    ----------
    scenario, settings, until, options
        As for `prepare_run`.
    metrics
        Functions of a result; their numbers are added to the key values.
    keep
        Outcomes whose full records are saved; `all` for every run.
    labels
        Labels of the varied events; points share the run before these events (see `branching`).
    """

    scenario: Scenario
    settings: Mapping[str, Raw] = field(default_factory=dict)
    until: Raw | None = None
    options: RunOptions = DEFAULTS
    metrics: tuple[Metric, ...] = ()
    keep: tuple[str, ...] = ()
    labels: tuple[str, ...] = ()


@dataclass(frozen=True)
class MetricError:
    """Error of a user's metric; `is_general` if it is an error of the function itself, which other runs share."""

    text: str
    is_general: bool


@dataclass(frozen=True)
class PointResult:
    """Result of a point: outcome, reason for a failure, metrics, wall-clock time (s), and its record as NetCDF.

    `metric_error` is the error of a user's metric, whose numbers are then missing. It changes nothing else.
    """

    point: int
    outcome: str
    reason: str = ""
    metrics: Mapping[str, float] = field(default_factory=dict)
    seconds: float = 0.0
    record: bytes | None = None
    metric_error: MetricError | None = None


@dataclass(frozen=True)
class _Machine:
    """The FMUs that points share, with their instances, saved states, rotor places and recorded variables."""

    assembly: Assembly
    instances: InstancePool
    branches: Branches
    places: RotorPlaces
    recorded: tuple[str, ...] | None


class Runner:
    """Runs points in sequence with the same FMU instances."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self._machines: dict[str, _Machine] = {}
        self._first: tuple[tuple[str, str], ScenarioStart | None] = ("", ""), None

    def plan(self, settings: Mapping[str, Setting]) -> ScenarioPlan:
        """Return the plan of a point.

        Raises
        ------
        ValueError
            If a name or a value is invalid.
        """
        return self._prepared(settings)[1]

    def run(self, point: int, settings: Mapping[str, Setting]) -> PointResult:
        """Run a point; if the run fails, the result states the failure."""
        began = time.perf_counter()
        try:
            machine, plan = self._prepared(settings)
            branches = machine.branches
            start = branches.start_of(plan)
            saves = branches.saves_of(plan, start)
            in_process = replace(self.task.options, isolated=False)  # a crash of this process is handled
            options = replace(in_process, instances=machine.instances, start=start, saves=saves)
            recording = execute_plan(plan, options)
        except ValueError as error:
            return PointResult(point, "invalid", str(error), seconds=time.perf_counter() - began)
        except (StartFailed, FmuError, ProcessFailed) as error:
            return PointResult(point, "failed", str(error), seconds=time.perf_counter() - began)
        if recording.outcome.failure is None:
            branches.keep(plan, recording.checkpoints)
        recovery, values = evaluate(bare_signals(plan, recording, machine.places))
        outcome, reason = outcome_of(recording.outcome, recovery)
        metric_error = None
        if outcome == "failed":
            values = {}  # those of an aborted run have no meaning
        elif self.task.metrics:
            numbers, metric_error = self._user_metrics(make_result(plan, recording))
            values |= numbers
        if self.task.labels and values:
            values["shared"] = 0.0 if start is None else (start.point - plan.begin) / (plan.last - plan.begin)
        if values and (late := late_changes(plan.scenario, self.task.until, plan.period)):
            values["late_events"] = float(len(late))
        is_recorded = "all" in self.task.keep or outcome in self.task.keep
        record = _netcdf(make_result(plan, recording)) if is_recorded else None
        return PointResult(point, outcome, reason, values, time.perf_counter() - began, record, metric_error)

    def _user_metrics(self, result: Result) -> tuple[dict[str, float], MetricError | None]:
        """Return the numbers that the user's functions return, and the error of the first function that failed."""
        values: dict[str, float] = {}
        errors = []
        for metric in self.task.metrics:
            try:
                values |= numbers_of(metric(result))
            except (Exception, SystemExit) as error:  # any error of a user's function
                name = getattr(metric, "__name__", type(metric).__name__)
                errors.append(
                    MetricError(f"metric {name}: {type(error).__name__}: {error}", isinstance(error, GENERAL))
                )
        return values, next(iter(errors), None)

    def close(self) -> None:
        """Free the FMUs."""
        for machine in self._machines.values():
            machine.instances.close()
        self._machines.clear()

    def _prepared(self, settings: Mapping[str, Setting]) -> tuple[_Machine, ScenarioPlan]:
        scenario, of_point = varied(self.task.scenario, settings)
        values = {**self.task.settings, **of_point}
        key = repr([reasons_for_stators(scenario, values), *(getattr(scenario, name) for name in _ASSEMBLED_FROM)])
        if key not in self._machines:
            assembly, instances = assemble_scenario(scenario, values, self.task.options), InstancePool()
            branches, places = Branches(assembly, instances, self.task.labels), places_of(assembly)
            recorded = None if self.task.metrics or self.task.keep else needed(places)
            self._machines[key] = _Machine(assembly, instances, branches, places, recorded)
        machine = self._machines[key]
        assembly = machine.assembly
        labels = scenario.labels
        first_key = key, repr({name: raw for name, raw in settings.items() if not event_of(labels, name)})
        if self._first[0] != first_key:
            self._first = first_key, start_of(scenario, assembly, values)
        plan = scenario_plan(scenario, assembly, values, self.task.until, machine.recorded, self._first[1])
        return machine, plan


def varied(scenario: Scenario, values: Mapping[str, Setting]) -> tuple[Scenario, dict[str, Raw]]:
    """Return the scenario that a point runs, and the other settings of the point by `component.variable`.

    Raises
    ------
    ValueError
        If the scenario has no such event or field.
    """
    settings: dict[str, Any] = dict(values)
    if "scenario" in settings:
        scenario = load_scenario(str(settings.pop("scenario")))
    changes: dict[str, Any] = {name: settings.pop(name) for name in FIELDS if name in settings}
    fmus = {name: settings.pop(name) for name in list(settings) if name.startswith("fmu.")}
    if fmus:
        changes["fmu"] = {name.removeprefix("fmu."): str(fmu) for name, fmu in fmus.items()}
    labels = scenario.labels
    of_events = {name: settings.pop(name) for name in list(settings) if event_of(labels, name) or is_moment(name)}
    for name in of_events:
        if not event_of(labels, name):
            named = ", ".join(labels) or "none"
            raise ValueError(f"{name}: scenario {scenario.name} has no such event; its labelled events: {named}")
    if of_events:
        changes["event"] = [_event(event, of_events) for event in scenario.event]
    return (scenario.changed(**changes) if changes else scenario), settings


def event_of(labels: Sequence[str], name: str) -> str:
    """Return the event label with which the name of a variation begins, or "" if there is none."""
    label = name.partition(".")[0]
    return label if label in labels else ""


def _event(event: Event, settings: Mapping[str, Raw]) -> dict[str, Any]:
    """Return an event in TOML form, updated with the time and values that `settings` contain for its label."""
    changes: dict[str, Any] = {}
    values: dict[str, dict[str, Raw]] = {component: {**variables} for component, variables in event.set.items()}
    for name, raw in settings.items():
        label, _, rest = name.partition(".")
        if label != event.name:
            continue
        component, _, variable = rest.partition(".")
        if rest in ("cycle", "time"):
            changes |= {"cycle": None, "time": None, rest: raw}
        elif not variable:
            raise ValueError(
                f"{name} is not part of an event; {suggest(rest, ['cycle', 'time', 'component.variable'])}"
            )
        else:
            values.setdefault(component, {})[variable] = raw
    return {**event.model_dump(mode="json", exclude_none=True), **changes, "set": values}


def numbers_of(returned: object) -> dict[str, float]:
    """Return what a user's metric returned as numbers by name.

    Raises
    ------
    TypeError
        If it is not a mapping of names, which the store allows for a variable, to numbers.
    """
    if not isinstance(returned, Mapping):
        raise TypeError(f"it returned {returned!r:.80}; it must return a dict of numbers by name")
    numbers = {}
    for name, value in returned.items():
        if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z_][\w.]*", name) or name in OTHER_VARIABLES:
            raise TypeError(
                f"{name!r} is not a name for a metric; it must have the form friction_heat or friction_heat.seal"
            )
        try:
            numbers[name] = float(value)
        except (TypeError, ValueError):
            raise TypeError(f"{name} = {value!r:.80} is not a number") from None
    return numbers


def _netcdf(result: Result) -> bytes:
    from amb_cosim.cosim.record.netcdf import netcdf

    return bytes(netcdf(result.dataset))


_runners: dict[str, Runner] = {}  # runners of this process, by the sweep's identifier


def run_batch(sweep: str, task: bytes, points: Sequence[tuple[int, Mapping[str, Raw]]]) -> list[PointResult]:
    """Run points of a sweep with the FMUs that earlier batches loaded in this process; `task` is pickled."""
    if sweep not in _runners:
        for runner in _runners.values():
            runner.close()
        _runners.clear()
        _runners[sweep] = Runner(pickle.loads(task))
    return [_runners[sweep].run(point, settings) for point, settings in points]
