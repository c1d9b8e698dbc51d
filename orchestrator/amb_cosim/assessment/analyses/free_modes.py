"""Bending modes of the free rotor, and their shapes at sensors and magnets."""

from __future__ import annotations

import numpy as np

from amb_cosim.assessment.findings import AnalysisResult, Quantity, ResultTable
from amb_cosim.assessment.subject import Subject, hertz
from amb_cosim.reporting.panels import Panel, curve
from array_types import Array
from rotor_analysis.damping import free_modes

TITLE = "Free-free modes, and positions of sensors and magnets"
LEAST, MOST = 3, 6  # modes that are displayed
SMALL = 0.02  # share of the largest of a shape below which a place is at a node of it


def answer(subject: Subject) -> AnalysisResult:
    """Return the bending modes of the free rotor at rest up to the judged frequency, at least three."""
    frequencies, all_shapes = free_modes(subject.free.M[::2, ::2], subject.free.K[::2, ::2])
    within = int(np.count_nonzero(frequencies <= subject.file.highest_frequency))
    count = min(max(within, LEAST), MOST, len(frequencies))
    rows = [subject.free.translations[node][0] // 2 for node in sorted(subject.free.translations)]
    shapes = all_shapes[rows][:, :count]
    shapes = shapes / shapes[np.abs(shapes).argmax(axis=0), np.arange(count)]
    pairs = _pairs(subject)
    measured = []
    for k in range(count):
        seen = max(abs(shapes[sensor - 1, k]) for _, _, sensor in pairs)
        moved = max(abs(shapes[magnet - 1, k]) for _, magnet, _ in pairs)
        place = f"mode {k + 1}, {hertz(frequencies[k]):.0f} Hz"
        facts = {"frequency": float(hertz(frequencies[k]))}
        measured.append(Quantity("mode_reach", place, 100.0 * min(seen, moved), "%", facts))
    names = {node: name for name, node in subject.probes.items()}
    heads = ("mode", "Hz", *(f"{bearing}, read at {names[sensor]}" for bearing, _, sensor in pairs))
    texts = tuple(
        (str(k + 1), f"{hertz(frequencies[k]):.1f}", *(_pair_text(shapes[:, k], m, s) for _, m, s in pairs))
        for k in range(count)
    )
    notes = (
        "Numbers are the shape at magnet and sensor, relative to its maximum. If they differ in sign, the magnet acts "
        "on this mode with the wrong sign: the mode requires the opposite phase.",
    )
    title = "Shape at the magnet, and at its sensor"
    return AnalysisResult(
        tuple(measured), (_panel(subject, shapes, frequencies),), (ResultTable(title, heads, texts),), notes
    )


def _pairs(subject: Subject) -> list[tuple[str, int, int]]:
    """Return each magnetic bearing with its node and the node of the nearest sensor plane."""
    nodes = {bearing.name: bearing.node for bearing in subject.rotor.bearings}
    z, sensors = subject.z, list(subject.probes.values())
    if not sensors:
        raise ValueError(f"rotor {subject.rotor.name} has no sensors")
    return [
        (name, nodes[name], min(sensors, key=lambda s, at=z[nodes[name] - 1]: abs(z[s - 1] - at)))  # type: ignore[misc]
        for name in subject.magnets
    ]


def _pair_text(shape: Array, magnet: int, sensor: int) -> str:
    at_magnet, at_sensor = shape[magnet - 1], shape[sensor - 1]
    text = f"{at_magnet:+.2f}, {at_sensor:+.2f}"
    if min(abs(at_magnet), abs(at_sensor)) < SMALL:
        return f"{text}: at a node"
    return text if at_magnet * at_sensor > 0.0 else f"{text}: non-collocated"


def _panel(subject: Subject, shapes: Array, frequencies: Array) -> Panel:
    z = 1e3 * subject.z
    curves = [curve(f"{hertz(w):.0f} Hz", z, shapes[:, k]) for k, w in enumerate(frequencies[: shapes.shape[1]])]
    magnets = [b.node for b in subject.rotor.bearings if b.name in subject.magnets]
    curves.append(curve("magnets", z[np.array(magnets) - 1], np.zeros(len(magnets)), "dots"))
    sensors = np.array(list(subject.probes.values())) - 1
    curves.append(curve("sensors", z[sensors], np.zeros(len(sensors)), "dots"))
    return Panel("Shapes of the free rotor", "z (mm)", "largest = 1", tuple(curves))
