"""Sensitivity of every axis (ISO 14839-3), computed over speed, and measured by injected currents in co-simulation."""

from __future__ import annotations

import numpy as np

from amb_cosim.assessment.findings import AnalysisResult, Quantity, ResultTable
from amb_cosim.assessment.stages import co_simulated, note_on_stages, real_coefficients
from amb_cosim.assessment.subject import Subject, rpm
from amb_cosim.linear.loop import Loop, diagonal_response
from amb_cosim.machine.coupled import coupled_loop
from amb_cosim.reporting.panels import Panel, curve
from amb_cosim.studies.stability_margin import StabilityMargin, curve_frequencies, sensitivity
from array_types import Array

TITLE = "Sensitivity, computed and measured"
SPEEDS = 4  # from the least to the largest, at which it is computed


def answer(subject: Subject) -> AnalysisResult:
    """Return the peak of each axis over the operating speeds, and the measured one at the largest speed."""
    speed = subject.file.speed
    loop = coupled_loop(subject, real_coefficients(subject))
    worst: dict[str, tuple[float, float, float]] = {}
    curves: dict[str, tuple[Array, Array]] = {}
    for Omega in np.linspace(speed.lowest, speed.highest, SPEEDS):
        for name, frequencies, values in sensitivities(loop, float(Omega)):
            top = int(values.argmax())
            worst[name] = max(
                worst.get(name, (0.0, 0.0, 0.0)), (float(values[top]), float(frequencies[top]), float(Omega))
            )
            curves[name] = frequencies, values
    measured = [
        Quantity("sensitivity_peak", f"{name}, {hz:.1f} Hz at {rpm(Omega):.0f} 1/min", peak, "1", {"frequency": hz})
        for name, (peak, hz, Omega) in worst.items()
    ]
    study = sensitivity(co_simulated(subject, speed.highest), flavour=subject.flavour)
    for name, axis in study.axes.items():
        top = int(axis.measured.argmax())
        hz = float(axis.measured_frequencies[top])
        where = f"{name}, {hz:.1f} Hz at {rpm(speed.highest):.0f} 1/min"
        note = f"{100.0 * axis.largest_difference:.2g} % largest deviation from the curve of the co-simulated system"
        measured.append(
            Quantity("sensitivity_measured", where, float(axis.measured[top]), "1", {"frequency": hz}, note)
        )
    return AnalysisResult(tuple(measured), (_panel(subject, curves, study),), (_table(study),), _notes(subject, study))


def sensitivities(loop: Loop, Omega: float) -> list[tuple[str, Array, Array]]:
    """Return the name of each axis, frequencies (Hz) and |S| there, at a spin speed (rad/s).

    Raises
    ------
    ValueError
        If the loop is not stable at this speed.
    """
    at_speed = Loop(loop.linear_components.at(Omega))
    system = at_speed.sensitivity()
    frequencies = curve_frequencies(system.poles(), at_speed.sample_time)
    return [
        (name, frequencies, row)
        for name, row in zip(at_speed.axis_names, np.abs(diagonal_response(system, frequencies)), strict=True)
    ]


def _panel(subject: Subject, curves: dict[str, tuple[Array, Array]], study: StabilityMargin) -> Panel:
    drawn = []
    for name, (frequencies, values) in curves.items():
        drawn.append(curve(f"{name} computed", frequencies, values))
    for name, axis in study.axes.items():
        drawn.append(curve(f"{name} measured", axis.measured_frequencies, axis.measured, "dots"))
    ends = next(iter(curves.values()))[0][[0, -1]]
    drawn += [
        curve(f"{zone}: below {limit:g}", ends, [limit, limit], "dashed") for zone, limit in study.zone_limits.items()
    ]
    title = f"|S| at {rpm(subject.file.speed.highest):.0f} 1/min"
    return Panel(title, "Hz", "|S|", tuple(drawn), log="x")


def _table(study: StabilityMargin) -> ResultTable:
    rows = tuple(
        (place, f"{item.least:.3f}", f"{item.frequency:.1f}", f"{item.gain:.2f}", f"{item.phase:.1f}")
        for place, item in study.disk_margins.items()
    )
    heads = ("broken at", "disk margin", "at Hz", "gain factor or divisor", "phase (deg)")
    return ResultTable("Margins of all loops together, changed at once and independently", heads, rows)


def _notes(subject: Subject, study: StabilityMargin) -> tuple[str, ...]:
    first = (
        f"Amplifiers are {study.amplifier}, demands {study.delay:g} samples late. Up to 2 kHz, or half the sample rate."
    )
    return (first, *note_on_stages(subject))
