"""Vibration at speed relative to the clearance (ISO 14839-2), from co-simulation with noise and converters."""

from __future__ import annotations

import numpy as np

from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, declare
from amb_assessment.assessment.physics.assessed_machine import NEARER, AssessedMachine, rpm
from amb_assessment.assessment.physics.runs import CYCLES, has_chain, steady_vibration, worst_response
from amb_assessment.reporting.panels import Panel, curve

declare("clearance_used", "%")

NOISE = (
    "Sensor noise and converter resolution are the controller's defaults, unless the machine defines its signal chain."
)
WITHOUT_NOISE = "The run has no sensor noise and exact converters, because the controller models neither."


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the largest displacement relative to the clearance at retainers and air gaps.

    The unbalance is that of the balancing grade. The machine runs at its lowest and its highest operating speed, and at
    the speed between them with the largest steady response.
    """
    speed = subject.file.speed
    stops = subject.stops
    worst = worst_response(subject, speed.lowest, speed.highest, stops)
    speeds = np.unique([speed.lowest, worst.Omega, speed.highest])
    measured, curves, placed = [], [], []
    for Omega in map(float, speeds):
        response = worst if Omega == worst.Omega else worst_response(subject, Omega, Omega, stops)
        used = steady_vibration(subject, response)
        by_place = {place: response.with_run(place, float(used[place].max())) for place in stops}
        deciding = subject.nearest({place: value for place, (value, _) in by_place.items()})
        for place in deciding:
            value, note = by_place[place]
            where, note = f"{place} at {rpm(Omega):.0f} rpm", f"of {subject.clearance_text(place)}: {note}"
            measured.append(Quantity("clearance_used", where, value, "%", {}, note))
        name = deciding[0]
        cycles = np.linspace(0.0, CYCLES, len(used[name]))
        curves.append(curve(f"{name}, {rpm(Omega):.0f} rpm", cycles, 100.0 * used[name]))
        placed.append(f"{response.unbalance.note} at {rpm(Omega):.0f} rpm")
    notes = (
        f"The unbalance of the balancing grade acts only in the rotor's planes, in the distribution for the worst "
        f"mode: {'; '.join(placed)}. "
        f"The largest steady response between the smallest and the largest speed is at {rpm(worst.Omega):.0f} rpm, "
        f"{100.0 * worst.share:.3g} % of the clearance at {worst.site}.",
        NEARER,
        NOISE if has_chain(subject) else WITHOUT_NOISE,
    )
    return AnalysisResult(
        tuple(measured), (Panel("Displacement over clearance", "cycle", "%", tuple(curves)),), (), notes
    )
