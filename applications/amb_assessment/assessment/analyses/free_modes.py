"""Bending modes of the free rotor, and their shapes at sensors and magnets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, hertz
from amb_assessment.reporting.panels import Panel, curve
from rotor_analysis.mode_reach import BearingReach, ModeReach, mode_reaches

declare("mode_reach", "%", ("frequency",))

LEAST, MOST = 3, 6  # listed modes


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the bending modes of the free rotor at rest up to the judged frequency, but at least three modes.

    If all modes are above this frequency, only the first mode is judged.
    """
    modes = mode_reaches(subject.rotor, subject.magnets, MOST)
    within = sum(mode.frequency <= subject.file.highest_frequency for mode in modes)
    modes = modes[: max(within, LEAST)]
    measured = []
    for mode in modes[: max(within, 1)]:
        deciding, hz = mode.deciding, float(hertz(mode.frequency))
        place = f"mode {mode.number}, {hz:.0f} Hz, {deciding.bearing} read at {deciding.sensor}"
        measured.append(Quantity("mode_reach", place, 100.0 * deciding.value, "%", {"frequency": hz}))
    heads = ("mode", "Hz", *(f"{at.bearing}, read at {at.sensor}" for at in modes[0].bearings))
    texts = tuple(
        (str(mode.number), f"{hertz(mode.frequency):.1f}", *(_pair_text(at) for at in mode.bearings)) for mode in modes
    )
    notes = (
        "The numbers are the shape at the magnet and at the sensor, relative to its maximum. If they differ in sign, "
        "a node lies between magnet and sensor, and the magnet acts on this mode with the wrong sign: the mode "
        "requires the opposite phase. The reach is the square root of the magnitude of the product of the two "
        "numbers, with the sign of this product. The reach is taken at the bearing that drives the mode most or, if no "
        "bearing drives the mode, at the bearing that reaches it best. Modes above the judged frequency are listed "
        "without a verdict.",
    )
    title = "Shape at the magnet, and at its sensor"
    return AnalysisResult(tuple(measured), (_panel(subject, modes),), (ResultTable(title, heads, texts),), notes)


def _pair_text(at: BearingReach) -> str:
    return f"{at.at_magnet:+z.2f}, {at.at_sensor:+z.2f}" + (f": {at.kind}" if at.kind else "")


def _panel(subject: AssessedMachine, modes: Sequence[ModeReach]) -> Panel:
    z = 1e3 * subject.z
    curves = [curve(f"{hertz(mode.frequency):.0f} Hz", z, mode.shape) for mode in modes]
    magnets = [b.node for b in subject.rotor.bearings if b.name in subject.magnets]
    curves.append(curve("magnets", z[np.array(magnets) - 1], np.zeros(len(magnets)), "dots"))
    sensors = np.array(list(subject.probes.values())) - 1
    curves.append(curve("sensors", z[sensors], np.zeros(len(sensors)), "dots"))
    return Panel("Shapes of the free rotor", "z (mm)", "largest = 1", tuple(curves))
