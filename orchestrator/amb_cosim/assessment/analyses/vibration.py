"""Vibration at speed against the clearance (ISO 14839-2), in co-simulation with noise and converters."""

from __future__ import annotations

import numpy as np

from amb_cosim.assessment.findings import AnalysisResult, Quantity
from amb_cosim.assessment.runs import clearance_used, simulate, unbalance_inputs, worst_case
from amb_cosim.assessment.stages import note_on_stages
from amb_cosim.assessment.subject import Subject, rpm
from amb_cosim.reporting.panels import Panel, curve

TITLE = "Vibration at speed in co-simulation"
CYCLES = 60.0  # of each run
SPEEDS = 3  # from the least to the largest


def answer(subject: Subject) -> AnalysisResult:
    """Return the largest displacement over the clearance at the retainers, with unbalance of the balancing grade."""
    speed = subject.file.speed
    retainers = [site.name for site in subject.rotor.sites if site.bearing and site.name in subject.clearances]
    measured, curves = [], []
    for Omega in np.unique(np.linspace(speed.lowest, speed.highest, SPEEDS)):
        inputs = unbalance_inputs(subject, worst_case(subject, float(Omega)))
        used = clearance_used(subject, simulate(subject, float(Omega), inputs, real=True, end_cycle=CYCLES))
        for site in retainers or list(used):
            largest = 100.0 * float(used[site].max())
            measured.append(Quantity("clearance_used", f"{site} at {rpm(float(Omega)):.0f} 1/min", largest, "%"))
        name = (retainers or list(used))[0]
        cycles = np.linspace(0.0, CYCLES, len(used[name]))
        curves.append(curve(f"{name}, {rpm(float(Omega)):.0f} 1/min", cycles, 100.0 * used[name]))
    notes = (
        "Unbalance of the balancing grade at the rotor's planes, distributed as for the worst mode. Sensor noise and "
        "converter resolution are the start values of the controller, unless the machine defines its signal chain.",
        *note_on_stages(subject),
    )
    return AnalysisResult(
        tuple(measured), (Panel("Displacement over clearance", "cycle", "%", tuple(curves)),), (), notes
    )
