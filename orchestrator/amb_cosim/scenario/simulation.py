"""Runs scenarios: finds the FMUs, plans, simulates, and labels the record in cycles of the rotor."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.basics.choices import Flavour, Loop
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.fmu.fmus import Fmu
from amb_cosim.cosim.record.recorder import Recorder
from amb_cosim.cosim.record.signals import AT_STEPS, EACH_STEP, Samples, SignalTable
from amb_cosim.cosim.record.warnings import ATTRIBUTE as WARNINGS
from amb_cosim.cosim.record.warnings import WarningRecord, to_json, warnings_of
from amb_cosim.cosim.run.checkpoint import Checkpoint, as_checkpoint
from amb_cosim.cosim.run.dataset import step_times, steps_of, to_signals
from amb_cosim.cosim.run.options import DEFAULTS, Progress, RunOptions
from amb_cosim.cosim.run.recording import Recording
from amb_cosim.cosim.run.run_plan import run_plan
from amb_cosim.cosim.run.saving import AUTOSAVE_TIME, Saves
from amb_cosim.cosim.system.assembly import Assembly, assemble
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.system import System
from amb_cosim.cosim.system.system_file import load_system
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.progress import progress_bar
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.results.places import ATTRIBUTE as PLACES
from amb_cosim.results.places import places_of
from amb_cosim.results.result import Result
from amb_cosim.results.stability import LAST_CHANGE
from amb_cosim.scenario.coupling import PREDICTION, SAMPLE_TIME, coupling_warning
from amb_cosim.scenario.inner_loop import controllers
from amb_cosim.scenario.plan import SPEED, plan_scenario
from amb_cosim.scenario.power import with_power
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_cosim.scenario.stators import bearings_with_stators, touchable_stators
from array_types import Array


def run(
    scenario: str | Path | Scenario,
    *,
    set: Mapping[str, Raw] | None = None,
    until: Raw | None = None,
    rotor: RotorSource = None,
    receptances: str | Path | None = None,
    fmu: Mapping[str, str | PathLike[str]] | None = None,
    flavour: Flavour = "native",
    loop: Loop = "compiled",
    progress: bool | Progress | None = None,
    isolated: bool | None = None,
    save_at: Sequence[Raw] = (),
    start: Checkpoint | str | Path | None = None,
    autosave: str | Path | None = None,
    autosave_every: float = AUTOSAVE_TIME,
) -> Result:
    """Run a scenario and return its result.

    Parameters
    ----------
    scenario
        A `Scenario`, the name of a packaged scenario, or the path of a TOML file.
    set
        Values by `component.variable` that replace the scenario's: `{"rotor_contact.seal.clearance": "0.6 mm"}`. A
        number is in the unit of the variable.
    until
        End of the run from the beginning of cycle 0, in s or as a text with a unit.
    rotor, receptances
        A `Rotor`, the name of a packaged rotor or a rotor file, and a table of receptances for the controller's H, in
        place of the scenario's.
    fmu
        Replacements of components by name: FMU, model, or controller of `amb_cosim.linear_controller`.
    flavour
        `native` FMUs, which are compiled and need no Python, or those run by PythonFMU.
    loop
        `compiled`, or `plain` Python for reference; the results are the same to the last bit.
    progress
        Whether a bar is shown (default in a terminal and a notebook), or a function called with the steps done and
        their number.
    isolated
        Whether the FMUs run in a separate process, so that a crash is an exception here; by default only if one of them
        is an FMU file.
    save_at
        Times, `cycle 5` or `0.3 s`, whose state `result.checkpoint` returns; changes at these times are still to come.
    start
        A checkpoint with the same past, or its file, from which the run continues. The result is that of the whole run,
        to the last bit.
    autosave, autosave_every
        File of automatic checkpoints, and seconds of computing between them. The same run, started again, continues
        from it.

    Raises
    ------
    ValueError
        If the scenario, a value or a file is invalid; the message names the place and what is allowed.
    StartFailed, FmuError
        If an FMU cannot be loaded or refuses to start. A failure during the run raises no exception: `result.outcome`
        states component, time and reason.
    ProcessFailed
        If the FMUs' own process crashed or had to be ended.
    """
    request = RunRequest(as_scenario(scenario, rotor, receptances, fmu), set or {}, until, flavour)
    file = None if autosave is None else Path(autosave)
    with progress_bar(progress) as report:
        options = RunOptions(
            flavour=flavour,
            loop=loop,
            isolated=isolated,
            start=as_checkpoint(start),
            saves=Saves(file=file, every=autosave_every, moments=save_at),
            progress=report,
        )
        return run_prepared(request.prepared(options.start), options)


def check(scenario: str | Path | Scenario) -> None:
    """Raise ValueError if a scenario does not fit the components that it runs; builds their FMUs if need be.

    It is a `Scenario`, the name of a packaged scenario, or the path of a TOML file.

    Examples
    --------
    >>> check("compressor_levitated")  # raises nothing: it can run
    """
    prepare(as_scenario(scenario))


@dataclass(frozen=True)
class RunRequest:
    """A scenario with values that replace its own, another end, and the flavour of its FMUs; see `run`."""

    scenario: Scenario
    settings: Mapping[str, Raw] = field(default_factory=dict)
    until: Raw | None = None
    flavour: Flavour = "native"

    def prepared(self, start: Checkpoint | None = None) -> PlannedRun:
        """Return the run with all that it needs; see `prepare`."""
        return prepare(self.scenario, self.settings, self.until, self.flavour, start)


@dataclass(frozen=True)
class PlannedRun:
    """A scenario with everything that it needs to run, checked."""

    scenario: Scenario
    plan: Plan
    assembly: Assembly

    @property
    def name(self) -> str:
        """Name of the scenario."""
        return self.scenario.name

    @property
    def fmus(self) -> Mapping[str, Fmu]:
        """FMU of each component."""
        return self.assembly.fmus

    @property
    def interfaces(self) -> Mapping[str, FmuInterface]:
        """Interface of each component."""
        return self.assembly.interfaces

    @property
    def speed(self) -> float:
        """Initial speed in rad/s."""
        return self.plan.inputs[SPEED]

    @property
    def profile(self) -> tuple[tuple[int, float], ...]:
        """Points (communication point, rad/s) that the speed is linear between; empty where it is constant."""
        return next((ramp.points for ramp in self.plan.ramps if ramp.variable == SPEED), ())


def prepare(
    scenario: Scenario,
    settings: Mapping[str, Raw] | None = None,
    until: Raw | None = None,
    flavour: Flavour = "native",
    start: Checkpoint | None = None,
) -> PlannedRun:
    """Find the FMUs of a scenario, check its system and plan it; see `plan_scenario` for the arguments.

    A run that continues from `start` has the stators of its past, with a warning if others lose their power.

    Raises
    ------
    ValueError
        If anything in it does not fit.
    """
    if start is None:
        assembly = assemble_scenario(scenario, flavour, settings)
        return PlannedRun(scenario, plan_scenario(scenario, assembly, settings, until), assembly)
    system = system_of(scenario)
    stators = bearings_with_stators(scenario, system, start.past)
    assembly = assemble_scenario(scenario, flavour, stators=stators)
    plan = plan_scenario(scenario, assembly, settings, until)
    missing = [name for name in touchable_stators(scenario, system, settings or {}) if name not in stators]
    if missing:
        warning = (
            f"the run before t = {start.time:.9g} s had no stators at {', '.join(missing)}, whose amplifiers are "
            "switched off; a rotor that crosses the air gap there ends this run"
        )
        plan = replace(plan, warnings=(*plan.warnings, warning))
    return PlannedRun(scenario, plan, assembly)


def system_of(scenario: Scenario) -> System:
    """Return the system of a scenario, with its replacing FMUs."""
    system = load_system(scenario.system, {"gradient": scenario.gradient})
    for component, fmu in scenario.fmu.items():
        system = system.with_fmu(component, fmu)
    return system


def model_options(
    scenario: Scenario,
    system: System,
    settings: Mapping[str, Raw] | None = None,
    stators: Sequence[str] | None = None,
) -> dict[str, Any]:
    """Return the options that the models of a scenario are made with: rotor, receptances, touchable stators."""
    if stators is None:
        stators = touchable_stators(scenario, system, settings or {})
    return {"rotor": scenario.rotor, "receptances": _table(scenario), "stators": stators}


def assemble_scenario(
    scenario: Scenario,
    flavour: Flavour = "native",
    settings: Mapping[str, Raw] | None = None,
    stators: Sequence[str] | None = None,
) -> Assembly:
    """Find the FMUs of a scenario and check its system, for any values of the scenario.

    The rotor can touch the stators of the bearings `stators`; by default those of `touchable_stators`, for which
    alone `settings` matter.

    Raises
    ------
    ValueError
        If an FMU cannot be had, or the system does not fit.
    """
    system = system_of(scenario)
    if scenario.receptances is not None and not controllers(system):
        raise ValueError(
            f"receptances {scenario.receptances} have no use: no component of the run is the model {CONTROLLER}"
        )
    assembly = assemble(system, flavour, **model_options(scenario, system, settings, stators))
    _check_sensors(assembly)
    return assembly


def _table(scenario: Scenario) -> Path | None:
    return None if scenario.receptances is None else Path(scenario.receptances)


def _check_sensors(assembly: Assembly) -> None:
    """Raise ValueError if a sensor of a controller is connected to nothing: it would show zero all along."""
    sensors = [f"{name}.{sensor}" for name, fmu in assembly.fmus.items() for sensor in _sensors(fmu.layout or {})]
    unfed = [sensor for sensor in sensors if assembly.system.source_of(sensor) is None]
    if unfed:
        raise ValueError(
            "\n".join(
                f"{sensor}, a sensor, must be connected, and is not; no component has an output of that name"
                for sensor in unfed
            )
        )


def _sensors(layout: Mapping[str, Any]) -> list[str]:
    """Return the inputs that are sensors of a model of this project with such a layout."""
    return [*(plane[axis] for plane in layout.get("planes", ()) for axis in ("x", "y")), *layout.get("signals", ())]


def run_prepared(prepared: PlannedRun, options: RunOptions = DEFAULTS) -> Result:
    """Run a prepared scenario; see `run_plan` for the errors."""
    return to_result(prepared, run_plan(prepared.assembly, prepared.plan, options))


def bare_signals(prepared: PlannedRun, recording: Recording) -> SignalTable:
    """Return the record of a run over time and cycle, with the rotor's positions and the cycles of events.

    This suffices for key values; units, parameters and warnings would cost more than these.
    """
    plan, recorder = prepared.plan, recording.recorder
    variables = {name: Samples(column, {}) for name, column in zip(plan.recorded, recorder.table.T, strict=True)}
    steps = {f"{name}{AT_STEPS}": Samples(column, {}, EACH_STEP) for name, column in steps_of(recording).items()}
    time = np.asarray(recorder.points * plan.step_size, np.float64)
    coordinates = _coordinates(plan, time) | step_times(recording)
    return SignalTable(variables | steps, coordinates, _landmarks(prepared, recorder))


def _coupling_warning(prepared: PlannedRun) -> str | None:
    """Return why the coupling of a loop is in doubt, or None; there is a loop if connections lead both ways."""
    system = prepared.plan.system
    links = {(system.split(link.source)[0], system.split(link.target)[0]) for link in system.connections}
    if not any((target, source) in links for source, target in links):
        return None
    parameters = prepared.plan.all_parameters(prepared.interfaces)
    predicted = max(values.get(PREDICTION) or 0.0 for values in parameters.values())
    sampled = min(filter(None, (values.get(SAMPLE_TIME) for values in parameters.values())), default=None)
    return coupling_warning(system.coupling, prepared.plan.step_size, predicted, sampled)


def to_result(prepared: PlannedRun, recording: Recording) -> Result:
    """Return the record of a run with all labels and the data of the scenario."""
    scenario, plan = prepared.scenario, prepared.plan
    signals = to_signals(recording)
    sentence = _coupling_warning(prepared)
    planned = [WarningRecord("parameters", "", message, message) for message in plan.warnings]
    warned = [
        *planned,
        *warnings_of(signals),
        *([WarningRecord("coupling", "", sentence, sentence)] if sentence else []),
    ]
    attributes: dict[str, Any] = {
        "scenario": scenario.name,
        "description": scenario.description,
        "source": scenario.source,
        "speed_rad_s": prepared.speed,
        **_landmarks(prepared, recording.recorder),
        "scenario_data": scenario.model_dump_json(exclude_defaults=True, exclude={"name"}),
    }
    if prepared.profile:
        attributes["speed_profile"] = json.dumps([(n * plan.step_size, Omega) for n, Omega in prepared.profile])
    if scenario.plot.cycles is not None:
        attributes["plot_cycles"] = list(scenario.plot.cycles)
    if scenario.plot.figures is not None:
        attributes["plot_figures"] = json.dumps(scenario.plot.figures)
    coordinates = {**signals.coordinates, **_coordinates(plan, signals["time"].values)}
    table = SignalTable(signals.variables, coordinates, {**signals.attrs, **attributes})
    message = {**table.attrs, WARNINGS: to_json(with_power(warned, table))}
    return Result(SignalTable(table.variables, table.coordinates, message), recording.outcome, recording.checkpoints)


def _coordinates(plan: Plan, time: Array) -> dict[str, Samples]:
    """Return time, and the turns of the initial speed."""
    return {
        "time": Samples(time, {"units": "s", "description": "Time from the beginning of cycle 0"}),
        "cycle": Samples(time / plan.period, {"units": "1", "description": "Turns of the initial speed"}),
    }


def _landmarks(prepared: PlannedRun, recorder: Recorder) -> dict[str, Any]:
    """Return the places of the rotor, labels and cycles of events with a role, and the last change, as attributes."""
    plan, cycle = prepared.plan, prepared.plan.step_size / prepared.plan.period
    roles = {event.role: event.name for event in prepared.scenario.event if event.role}
    events = {role: label for role, label in roles.items() if plan.marks[label] <= recorder.reached}
    cycles = {f"{role}_cycle": plan.marks[label] * cycle for role, label in events.items()}
    labels = {f"{role}_label": label for role, label in events.items()}
    changes = (*(n for n, _, _ in plan.events), *(n for n, _ in prepared.profile))
    last = max((n for n in changes if n <= recorder.reached), default=0)
    message = {PLACES: places_of(prepared.assembly).to_json(), "period_s": plan.period}
    return {**message, **cycles, **labels, LAST_CHANGE: last * cycle}
