"""Makes a scenario's result from its record: signals over time and cycle, with the data of the scenario."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from amb_cosim.cosim.record.recorder import Recorder
from amb_cosim.cosim.record.signals import AT_STEPS, EACH_STEP, Samples, Signals, SignalTable
from amb_cosim.cosim.record.warnings import ATTRIBUTE as WARNINGS
from amb_cosim.cosim.record.warnings import WarningRecord, to_json, warnings_of
from amb_cosim.cosim.run.dataset import parameters_of, step_times, steps_of, to_signals
from amb_cosim.cosim.run.recording import Recording
from amb_cosim.cosim.system.experiment import Plan, Ramp
from amb_cosim.results.contact_history import is_supported
from amb_cosim.results.loop_stability import ATTRIBUTE as LOOP
from amb_cosim.results.places import ATTRIBUTE as PLACES
from amb_cosim.results.places import RotorPlaces, places_of
from amb_cosim.results.power import with_power
from amb_cosim.results.result import Result
from amb_cosim.results.signal_arrays import speed
from amb_cosim.results.stability import EXCITATIONS, LAST_CHANGE, SOURCES
from amb_cosim.results.thinned import judged
from amb_cosim.scenario.control_loop import excitations, exciting_components
from amb_cosim.scenario.coupling import PREDICTION, SAMPLE_TIME, coupling_warning
from amb_cosim.scenario.final_loop import loop_at_the_end
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.scenario import SPEED
from array_types import Array


def bare_signals(plan: ScenarioPlan, recording: Recording, places: RotorPlaces) -> SignalTable:
    """Return the record of a run over time and cycle, with the rotor's places and the cycles of events.

    This record has the same key values as a complete result. Units and warnings are left out, because collecting them
    would take longer than computing the key values.
    """
    recorder = recording.recorder
    variables = {name: Samples(column, {}) for name, column in zip(plan.recorded, recorder.table.T, strict=True)}
    steps = {f"{name}{AT_STEPS}": Samples(column, {}, EACH_STEP) for name, column in steps_of(recording).items()}
    time = np.asarray(recorder.points * plan.step_size, np.float64)
    coordinates = _coordinates(plan, time) | step_times(recording)
    of_run = {"communication_step_s": plan.step_size, "parameters": parameters_of(recording), PLACES: places}
    table = SignalTable(variables | steps, coordinates, of_run | _landmarks(plan, recorder))
    return replace(table, attrs={**table.attrs, **_loop(plan, table, stores=False)})


def _coupling_warnings(plan: ScenarioPlan) -> list[WarningRecord]:
    """Return a warning if the coupling makes results of a loop doubtful; connections in both directions form a loop."""
    system = plan.system
    links = system.links
    if not any((target, source) in links for source, target in links):
        return []
    parameters = plan.all_parameters()
    predicted = max(values.get(PREDICTION) or 0.0 for values in parameters.values())
    sampled = min(filter(None, (values.get(SAMPLE_TIME) for values in parameters.values())), default=None)
    sentence = coupling_warning(system.coupling, plan.step_size, predicted, sampled)
    return [WarningRecord("coupling", "", sentence, sentence)] if sentence else []


def make_result(plan: ScenarioPlan, recording: Recording) -> Result:
    """Return the record of a run with all labels and the data of the scenario."""
    scenario, recorder = plan.scenario, recording.recorder
    coordinates = _coordinates(plan, plan.grid.times(recorder.points))
    attributes: dict[str, Any] = {
        "scenario": scenario.name,
        "description": scenario.description,
        "source": scenario.source,
        PLACES: places_of(plan.assembly).to_json(),
        **_landmarks(plan, recorder),
        "scenario_data": scenario.model_dump_json(exclude_defaults=True, exclude={"name"}),
    }
    if scenario.plot.cycles is not None:
        attributes["plot_cycles"] = list(scenario.plot.cycles)
    if scenario.plot.figures is not None:
        attributes["plot_figures"] = json.dumps(scenario.plot.figures)
    coupling = _coupling_warnings(plan)
    signals = to_signals(recording)
    table = SignalTable(signals.variables, {**signals.coordinates, **coordinates}, {**signals.attrs, **attributes})
    warned = to_json(with_power([*warnings_of(signals), *coupling], table))
    table = replace(table, attrs={**table.attrs, WARNINGS: warned, **_loop(plan, table)})
    return Result(table, recording.outcome, recording.checkpoints)


def _loop(plan: ScenarioPlan, table: Signals, *, stores: bool = True) -> dict[str, str]:
    """Return the attribute with the stability of the loop at the end of a run; empty if it decides nothing."""
    table = judged(table)
    if not is_supported(table):
        return {}
    end = float(table["time"].values[-1])
    stability = loop_at_the_end(plan, end, float(speed(table)[-1]), stores=stores)
    return {} if stability is None else {LOOP: stability.to_json()}


def _coordinates(plan: Plan, time: Array) -> dict[str, Samples]:
    """Return the time, and the number of turns at the initial speed."""
    return {
        "time": Samples(time, {"units": "s", "description": "Time from the beginning of cycle 0"}),
        "cycle": Samples(time / plan.period, {"units": "1", "description": "Revolutions at the initial speed"}),
    }


def _landmarks(plan: ScenarioPlan, recorder: Recorder) -> dict[str, Any]:
    """Return attributes: the speed of the rotor, the labels and cycles of events with a role, and the last change."""
    cycle = plan.step_size / plan.period
    roles = {change.role: change.name for change in plan.scenario.named_changes if change.role}
    events = {role: label for role, label in roles.items() if plan.marks[label] <= recorder.reached}
    cycles = {f"{role}_cycle": plan.marks[label] * cycle for role, label in events.items()}
    labels = {f"{role}_label": label for role, label in events.items()}
    changes = (*(n for n, _, _ in plan.events), *(n for n, _ in plan.profile))
    within = [n for n in changes if n <= recorder.reached]
    inputs = [ramp for ramp in plan.ramps if ramp.variable != SPEED]
    last = max([*within, *(_changes_until(ramp, recorder.reached) for ramp in inputs)], default=0)
    common: dict[str, Any] = {"period_s": plan.period, "speed_rad_s": plan.speed}
    if plan.profile:
        common["speed_profile"] = json.dumps([(n * plan.step_size, Omega) for n, Omega in plan.profile])
    system = plan.system
    if sources := exciting_components(system):
        common[SOURCES] = json.dumps(sources)
        common[EXCITATIONS] = json.dumps(excitations(system))
    return {**common, **cycles, **labels, LAST_CHANGE: last * cycle}


def _changes_until(ramp: Ramp, reached: int) -> int:
    """Return the last communication point, up to `reached`, at which a change of an input ends; 0 if there is none."""
    lines = pairwise(ramp.points)
    return max((min(n, reached) for (m, a), (n, b) in lines if m < reached and a != b), default=0)
