"""Run-up and run-down through the critical speeds, and faults at speed, in co-simulation."""

from __future__ import annotations

from typing import Any

import numpy as np

from amb_cosim.assessment.findings import AnalysisResult, Quantity, ResultTable
from amb_cosim.assessment.runs import clearance_used, simulate, unbalance_inputs, worst_case
from amb_cosim.assessment.stages import note_on_stages
from amb_cosim.assessment.subject import Subject, rpm
from amb_cosim.reporting.panels import Panel, curve
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.gravity import STANDARD_GRAVITY

TITLE = "Run-up, run-down and faults in co-simulation"
SLOW = 0.1  # of the largest speed, where a run-up begins
RAMP = 1.0  # s
FAULT = 0.15  # s after a fault
SHOCK = 5.0 * STANDARD_GRAVITY  # m/s^2, a half sine
SHOCK_TIME = 0.011  # s
SHOCK_STEPS = 8


def answer(subject: Subject) -> AnalysisResult:
    """Return the smallest distance of the rotor to contact in each run, with the unbalance of the balancing grade."""
    speed = subject.file.speed.highest
    inputs = unbalance_inputs(subject, worst_case(subject, speed))
    measured, rows, curves = [], [], []
    for name, (quantity, Omega, fields) in _runs(subject).items():
        result = simulate(subject, Omega, inputs, **fields)
        used = clearance_used(subject, result)
        site = max(used, key=lambda site_name: float(used[site_name].max()))  # used at once
        largest = 100.0 * float(used[site].max())
        end = 100.0 * max(float(of[-max(1, len(of) // 10) :].max()) for of in used.values())
        measured.append(Quantity(quantity, f"{name}, {site}", largest, "%", {}, f"at the end {end:.3g} %"))
        rows.append((name, site, f"{largest:.3g}", f"{end:.3g}", result.summary.recovery or "no contact"))
        if quantity == "clearance_used_running":
            curves.append(curve(name, np.linspace(0.0, RAMP, len(used[site])), 100.0 * used[site]))
    heads = ("run", "nearest at", "largest (% of clearance)", "at the end (%)", "contact at the end")
    notes = (
        f"Run-up and run-down between {rpm(SLOW * speed):.0f} and {rpm(speed):.0f} 1/min in {RAMP:g} s: faster than "
        f"real machines, so vibration at critical speeds is smaller. Faults are at the largest speed; a rotor on its "
        f"retainers is at 100 %.",
        *note_on_stages(subject),
    )
    panel = Panel("Largest displacement over clearance", "time (s)", "%", tuple(curves))
    return AnalysisResult(tuple(measured), (panel,), (ResultTable("Runs", heads, tuple(rows)),), notes)


def _runs(subject: Subject) -> dict[str, tuple[str, float, dict[str, Any]]]:
    """Return quantity, first speed (rad/s) and fields of each run, by its name."""
    high, low = subject.file.speed.highest, SLOW * subject.file.speed.highest
    bearing, axis = subject.loop.axes[0]
    reading = subject.loop.readings[0].partition(".")[2]
    faults: dict[str, dict[str, Any]] = {
        f"power of {bearing}.{axis} lost": {ACTUATOR: {f"{bearing}.amplifier_off_{axis}": True}},
        f"upper coils of {bearing}.{axis} lost": {ACTUATOR: {f"{bearing}.coil_loss_upper_{axis}": 1.0}},
        f"sensor {reading} dead": {CONTROLLER: {f"{reading}.fault_dead": True}},
    }
    ramps = {"run-up": (low, high), "run-down": (high, low)}
    result: dict[str, tuple[str, float, dict[str, Any]]] = {
        name: (
            "clearance_used_running",
            begin,
            {"settle_cycles": 3.0, "end_time": RAMP, "speed": [{"time": RAMP, "Omega": end}]},
        )
        for name, (begin, end) in ramps.items()
    }
    for name, setting in faults.items():
        event = [{"role": "disturbance", "cycle": 1.0, "set": setting}]
        result[name] = ("clearance_used_fault", high, {"end_time": FAULT, "event": event})
    shares = (np.arange(SHOCK_STEPS) + 0.5) / SHOCK_STEPS
    pulse = [SHOCK * float(a) for a in np.sin(np.pi * shares)]
    shock: list[dict[str, Any]] = [
        {"time": SHOCK_TIME * k / SHOCK_STEPS, "set": {PLANT: {"base.a_y": a}}} for k, a in enumerate(pulse)
    ]
    shock.append({"time": SHOCK_TIME, "set": {PLANT: {"base.a_y": 0.0}}})
    result[f"base shock of {SHOCK / STANDARD_GRAVITY:g} g and {1e3 * SHOCK_TIME:g} ms"] = (
        "clearance_used_fault",
        high,
        {"end_time": FAULT, "event": shock},
    )
    return result
