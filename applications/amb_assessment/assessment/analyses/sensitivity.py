"""Sensitivity of every axis (ISO 14839-3), computed at operating speeds, and measured in co-simulation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amb_analysis.linear.loop import Loop
from amb_analysis.machine.coupled import coupled_loop
from amb_analysis.studies.sensitivity_curves import peaks_of, sensitivity_bands
from amb_analysis.studies.stability_margin import CASING_TITLE, ZONES, CasingDamping, StabilityMargin, sensitivity
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.stages import co_simulated, real_coefficients, with_tables
from amb_assessment.reporting.panels import Curve, Panel, curve
from array_types import Array
from rotor_analysis.refinement import refined

declare("sensitivity_peak", "1", ("frequency",))
declare("sensitivity_peak_beyond", "1", ("frequency",))
declare("sensitivity_measured", "1", ("frequency",))

PEAKS = "sensitivity_peak", "sensitivity_peak_beyond"  # quantities: up to the 2 kHz of the standard, and above
ALONG_THE_SHAFT = (
    "Here, the axis along the shaft carries only the weight. The part `axial_margins` covers all static forces."
)
CASING_NOTE = (
    "the modal mass is that for a displacement of 1 at the magnets. The estimate is of first order in the forces over "
    "the modal mass."
)
SPEEDS = 4  # from the smallest to the largest, before refinement about maxima


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the largest |S| of each axis over the operating speeds, and the measured peak at the largest speed."""
    speed = subject.file.speed
    loop = coupled_loop(subject, real_coefficients(subject))
    by_speed = sensitivities_over(subject, loop)
    measured = []
    for band, quantity in enumerate(PEAKS):
        for k, name in enumerate(loop.axis_names):
            peaks = [(axes[k].peaks[band], Omega) for Omega, axes in by_speed.items() if band < len(axes[k].peaks)]
            if peaks:
                (peak, hz), Omega = max(peaks)
                where = f"{name}, {hz:.1f} Hz at {rpm(Omega):.0f} rpm"
                measured.append(Quantity(quantity, where, peak, "1", {"frequency": hz}))
    curves = {
        name: (axis.frequencies, axis.values)
        for name, axis in zip(loop.axis_names, by_speed[speed.highest], strict=True)
    }
    study = sensitivity(co_simulated(subject, speed.highest, levitated=True), flavour=subject.flavour)
    for name, axis in study.axes.items():
        hz = axis.peak_frequency
        where = f"{name}, {hz:.1f} Hz at {rpm(speed.highest):.0f} rpm"
        note = f"at most {100.0 * axis.largest_difference:.2g} % from the computed curve of the co-simulated system"
        measured.append(Quantity("sensitivity_measured", where, axis.measured_peak, "1", {"frequency": hz}, note))
    note = (
        f"Amplifiers are {study.amplifier}. The delay of the demands is {study.delay:g} times the sample time. Zones "
        "are judged up to 2 kHz or half the sample rate, whichever is lower; a criterion of this package judges the "
        "peak above 2 kHz."
    )
    has_axial = len(loop.axes) > len(loop.lateral_axes)
    notes = (note, ALONG_THE_SHAFT) if has_axial else (note,)
    tables: tuple[ResultTable, ...] = ()
    if study.casing is not None:
        sentence = study.casing.conclusion
        notes = (*notes, f"{sentence[0].upper()}{sentence[1:]}; {CASING_NOTE}")
        tables = (_casing(study.casing),)
    return AnalysisResult(tuple(measured), (_panel(subject, curves, study),), (_table(study), *tables), notes)


@dataclass(frozen=True, eq=False)
class AxisPeaks:
    """Curve of |S| of an axis over frequency (Hz), with its peak up to 2 kHz and, if the sample rate allows, its peak
    above 2 kHz.
    """

    frequencies: Array
    values: Array
    peaks: tuple[tuple[float, float], ...]


def sensitivities(loop: Loop, Omega: float) -> list[AxisPeaks]:
    """Return |S| of each axis up to 2 kHz, and the peaks of |S|, at a spin speed (rad/s).

    Raises
    ------
    ValueError
        If the loop is not stable at this speed.
    """
    system = Loop(loop.linear_components.at(Omega)).sensitivity()
    bands = sensitivity_bands(system)
    (frequencies, curves), *_ = bands
    peaks = zip(*(peaks_of(*band) for band in bands), strict=True)
    return [AxisPeaks(frequencies, S, of_axis) for S, of_axis in zip(np.abs(curves), peaks, strict=True)]


def sensitivities_over(subject: AssessedMachine, loop: Loop) -> dict[float, list[AxisPeaks]]:
    """Return the `sensitivities` of a loop by operating speed (rad/s); near the highest peaks the speeds are more
    closely spaced.
    """
    speed = subject.file.speed
    by_speed: dict[float, list[AxisPeaks]] = {}

    def peaks(speeds: Array) -> Array:
        by_speed.update({Omega: sensitivities(loop, Omega) for Omega in map(float, speeds)})
        return np.array([[peak for axis in by_speed[Omega] for peak, _ in axis.peaks] for Omega in map(float, speeds)])

    speeds = with_tables(subject, np.unique(np.linspace(speed.lowest, speed.highest, SPEEDS)))
    refined(peaks, speeds, lambda values: values, resonant=False)
    return by_speed


def _panel(subject: AssessedMachine, curves: dict[str, tuple[Array, Array]], study: StabilityMargin) -> Panel:
    drawn = []
    for name, (frequencies, values) in curves.items():
        drawn.append(curve(f"{name} computed", frequencies, values))
    for name, axis in study.axes.items():
        drawn.append(curve(f"{name} measured", axis.measured_frequencies, axis.measured, "dots"))
    ends = next(iter(curves.values()))[0][[0, -1]]
    drawn += zone_limits(ends)
    title = f"|S| at {rpm(subject.file.speed.highest):.0f} rpm"
    return Panel(title, "Hz", "|S|", tuple(drawn), log="x")


def zone_limits(ends: Array) -> list[Curve]:
    """Return the upper limits of the |S| zones as horizontal lines between two frequencies (Hz)."""
    return [curve(f"{zone}: below {limit:g}", ends, [limit, limit], "dashed") for zone, limit in ZONES.items()]


def _casing(casing: CasingDamping) -> ResultTable:
    heads = ("Hz", *casing.needed)
    return ResultTable(CASING_TITLE, heads, tuple(casing.rows))


def _table(study: StabilityMargin) -> ResultTable:
    rows = tuple(
        (place, f"{item.least:.3f}", f"{item.frequency:.1f}", f"{item.gain:.2f}", f"{item.phase:.1f}")
        for place, item in study.disk_margins.items()
    )
    heads = ("broken at", "disk margin", "at Hz", "gain factor or divisor", "phase (deg)")
    title = "Margins of all loops under simultaneous, independent changes, up to half the sample rate"
    return ResultTable(title, heads, rows)
