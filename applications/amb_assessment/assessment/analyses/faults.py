"""Co-simulations of run-up and run-down through the critical speeds, and of faults at the largest speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.runs import (
    WorstResponse,
    clearance_used,
    simulate,
    steady_vibration,
    times_of,
    worst_response,
)
from amb_assessment.reporting.panels import Curve, Panel, curve
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from array_types import Array

declare("clearance_used_running", "%")
declare("clearance_used_fault", "%", title="Largest displacement over the clearance after a fault")

SLOW = 0.1  # speed at which a run-up begins, over the largest speed
LONGEST = 5.0  # s of a run-up or run-down that is simulated; a slower one passes its critical speeds in steady motion
POINTS = 13  # of the speed over time of a run-down
FAULT = 0.15  # s, duration of a run with a fault
SHOCK = 5.0 * STANDARD_GRAVITY  # m/s^2, a half sine
SHOCK_TIME = 0.011  # s
SHOCK_STEPS = 8


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return how close the rotor comes to contact in each run, under the unbalance of the balancing grade."""
    speed = subject.file.speed
    passed = worst_response(subject, SLOW * speed.highest, speed.tripping)
    running = [_running(subject, name, time, passed) for name, time in _durations(subject).items()]
    faults, rows, after_faults = _faults(subject)
    notes = (
        f"Run-up and run-down between {rpm(SLOW * speed.highest):.0f} rpm and the trip speed, with the unbalance of "
        f"the mode that moves the rotor most in this range: {passed.unbalance.note}. A run that takes more than "
        f"{LONGEST:g} s, or an unknown time, is judged by steady motion at the worst speed, {rpm(passed.Omega):.0f} "
        "rpm: a slow run reaches this motion, but a fast run stays below it. The keys `run_up` and `run_down` state "
        "the "
        "times; "
        "without them, `spin.drag` determines how fast the machine runs down.",
        "Faults occur at the largest speed, one at a time; the worst of each kind is judged. A rotor that touches "
        "its retainers, or has crossed the air gap of a magnet, counts as 100 %. The run ends if the rotor reaches an "
        "energised magnet.",
        *_without_fault(subject),
    )
    title, at = "Displacement over clearance", f"{rpm(speed.highest):.0f} rpm"
    panels = (
        Panel(f"{title} while the speed changes", "time (s)", "%", tuple(line for _, line in running)),
        Panel(f"{title}, the worst fault of each kind at {at}", "time (s)", "%", tuple(after_faults), holds=(100.0,)),
    )
    heads = ("fault", "nearest at", "largest (% of clearance)", "at the end (%)", "outcome")
    table = ResultTable("Faults", heads, tuple(rows))
    return AnalysisResult((*(quantity for quantity, _ in running), *faults), panels, (table,), notes)


def _durations(subject: AssessedMachine) -> dict[str, float]:
    """Return the durations (s) of run-up and run-down between `SLOW` and the trip speed, or infinity if unknown."""
    speed, p = subject.file.speed, subject.parameters[PLANT]
    drag, span = p.get("spin.drag", 0.0), (speed.tripping - SLOW * speed.highest) / speed.highest
    coasting = p["spin.inertia"] / drag * math.log(speed.tripping / (SLOW * speed.highest)) if drag else math.inf
    stated = {"run-up": speed.run_up_time, "run-down": speed.run_down_time}
    return {
        name: span * time if time is not None else coasting if name == "run-down" else math.inf
        for name, time in stated.items()
    }


def _running(subject: AssessedMachine, name: str, time: float, passed: WorstResponse) -> tuple[Quantity, Curve]:
    """Return the largest displacement relative to the clearance during a run-up or run-down, and its curve."""
    if time > LONGEST:
        used = steady_vibration(subject, passed)
        value, note = passed.with_run(passed.site, max(float(shares.max()) for shares in used.values()))
        duration = len(used[passed.site]) * float(subject.prepared.step_size)
        where = f"{name}, {passed.site} at {rpm(passed.Omega):.0f} rpm"
        length = f"takes {time:.4g} s" if math.isfinite(time) else "has an unknown duration"
        line = curve(f"{name}, steady", np.linspace(0.0, duration, len(used[passed.site])), 100.0 * used[passed.site])
        return Quantity("clearance_used_running", where, value, "%", {}, f"{length}: {note}"), line
    speeds = _speeds(subject, name)
    points = [{"time": share * time, "Omega": Omega} for share, Omega in speeds[1:]]
    result = simulate(
        subject, speeds[0][1], passed.unbalance.inputs, to_magnets=True, levitated=True, end_time=time, speed=points
    )
    used = clearance_used(subject, result)
    site = max(used, key=lambda site_name: float(used[site_name].max()))
    line = curve(name, times_of(result), 100.0 * used[site])
    value = 100.0 * float(used[site].max())
    return Quantity("clearance_used_running", f"{name}, {site}", value, "%", {}, f"in {time:.3g} s"), line


def _speeds(subject: AssessedMachine, name: str) -> list[tuple[float, float]]:
    """Return pairs of a time, as a share of the duration, and the speed (rad/s) at this time.

    The speed is linear in time, except in a run-down whose duration is not stated. In such a run-down, drag slows the
    rotor.
    """
    speed = subject.file.speed
    ends = np.array([SLOW * speed.highest, speed.tripping])
    if name == "run-up":
        return list(zip([0.0, 1.0], ends.tolist(), strict=True))
    if speed.run_down_time is not None:
        return list(zip([0.0, 1.0], ends[::-1].tolist(), strict=True))
    shares = np.linspace(0.0, 1.0, POINTS)
    return list(zip(shares.tolist(), (ends[1] * (ends[0] / ends[1]) ** shares).tolist(), strict=True))


def _faults(subject: AssessedMachine) -> tuple[list[Quantity], list[tuple[str, ...]], list[Curve]]:
    """Return the worst case of each kind of fault, a table row for each fault, and a curve for each worst case."""
    highest = subject.file.speed.highest
    unbalance = worst_response(subject, highest, highest).unbalance
    measured: list[Quantity] = []
    rows: list[tuple[str, ...]] = []
    lines: list[Curve] = []
    for kind, cases in _kinds(subject).items():
        outcomes: list[tuple[float, float, str, Curve]] = []
        for name, events in cases.items():
            result = simulate(subject, highest, unbalance.inputs, to_magnets=True, end_time=FAULT, event=events)
            used = clearance_used(subject, result)
            site, largest, end = _nearest(used)
            ending = "the run ends at the magnet" if result.outcome.failure else result.summary.recovery or "no contact"
            rows.append((name, site, f"{largest:.3g}", f"{end:.3g}", ending))
            where = f"{name}, {site}"
            outcomes.append((largest, end, where, curve(where, times_of(result), 100.0 * used[site])))
        largest, end, where, line = max(outcomes, key=lambda item: item[:2])
        lines.append(line)
        count = f"the worst of {len(outcomes)}; " if len(outcomes) > 1 else ""
        note = f"{kind}: {count}at the end {end:.3g} %"
        measured.append(Quantity("clearance_used_fault", where, largest, "%", {}, note))
    return measured, rows, lines


def _nearest(used: Mapping[str, Array]) -> tuple[str, float, float]:
    """Return the site nearest to contact, its largest displacement, and the largest final one (% of clearance)."""
    site = max(used, key=lambda site_name: float(used[site_name].max()))
    end = max(float(shares[-max(1, len(shares) // 10) :].max()) for shares in used.values())
    return site, 100.0 * float(used[site].max()), 100.0 * end


def _kinds(subject: AssessedMachine) -> dict[str, dict[str, list[dict[str, Any]]]]:
    """Return the events of each fault, by kind and name."""
    readings = [name for name in _readings(subject) if _can_fail(subject, name)]
    axes = subject.controlled_axes
    settings: dict[str, dict[str, dict[str, dict[str, Any]]]] = {
        "power of one axis lost": {
            f"power of {b}.{a} lost": {ACTUATOR: {f"{b}.amplifier_off_{a}": True}} for b, a in axes
        },
        "coils of one axis lost": {
            f"{side} coils of {b}.{a} lost": {ACTUATOR: {f"{b}.coil_loss_{side}_{a}": 1.0}}
            for side in ("upper", "lower")
            for b, a in axes
        },
        "one sensor dead": {
            f"sensor {reading} dead": {CONTROLLER: {f"{reading}.fault_dead": True}} for reading in readings
        },
    }
    result = {
        kind: {name: [{"role": "disturbance", "cycle": 1.0, "set": setting}] for name, setting in cases.items()}
        for kind, cases in settings.items()
        if cases
    }
    text = f"base shock of {SHOCK / STANDARD_GRAVITY:g} g and {1e3 * SHOCK_TIME:g} ms"
    directions = [(axis, sign) for axis in subject.directions_of_contact for sign in "+-"]
    return result | {text: {f"{text} along {sign}{axis}": _shock(axis, sign) for axis, sign in directions}}


def _readings(subject: AssessedMachine) -> list[str]:
    """Return the names of the displacements that the controller reads."""
    return list(dict.fromkeys(reading.partition(".")[2] for reading in subject.loop.readings))


def _can_fail(subject: AssessedMachine, reading: str) -> bool:
    return f"{reading}.fault_dead" in subject.prepared.interfaces[CONTROLLER].ports


def _without_fault(subject: AssessedMachine) -> list[str]:
    """Return a note on the readings whose failure was not simulated, because the controller has no input for it."""
    without = [name for name in _readings(subject) if not _can_fail(subject, name)]
    if not without:
        return []
    return [
        f"Dead sensors were not simulated, because the controller has no input for a fault of {', '.join(without)}."
    ]


def _shock(axis: str, sign: str) -> list[dict[str, Any]]:
    """Return the events of a base acceleration that approximates a half sine in steps."""
    shares = (np.arange(SHOCK_STEPS) + 0.5) / SHOCK_STEPS
    pulse = [float(f"{sign}1") * SHOCK * float(a) for a in np.sin(np.pi * shares)]
    events: list[dict[str, Any]] = [
        {"time": SHOCK_TIME * k / SHOCK_STEPS, "set": {PLANT: {f"base.a_{axis}": a}}} for k, a in enumerate(pulse)
    ]
    events[0]["role"] = "disturbance"
    return [*events, {"time": SHOCK_TIME, "set": {PLANT: {f"base.a_{axis}": 0.0}}}]
