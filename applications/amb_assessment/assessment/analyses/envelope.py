"""Forces, currents, voltages and slew rates under unbalance, compared with the limits of amplifiers and magnets."""

from __future__ import annotations

import numpy as np

from amb_analysis.machine.axis_capability import force_slew_rate, voltage_at_rest
from amb_analysis.machine.demand_limits import control_amplitude
from amb_analysis.machine.feedback import bearing_forces, demanded_currents
from amb_analysis.machine.machine import AXES
from amb_analysis.machine.response import stiffness_of, synchronous_response
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, hertz, rpm
from amb_assessment.assessment.physics.stages import real_coefficients, with_tables
from amb_assessment.assessment.physics.unbalance_cases import response_speeds, unbalance_cases
from amb_assessment.reporting.panels import Curve, Panel, curve
from array_types import Array, Complex
from rotor_analysis.refinement import about_resonances, refined
from rotor_analysis.resonances import resonances

declare("current_demand", "%")
declare("slew_demand", "%")

POINTS = 90  # speeds, before refinement about critical speeds and maxima


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the worst-case demands on each axis up to the trip speed under the unbalance of the balancing grade."""
    total, others = subject.unbalance_of_grade(), real_coefficients(subject)
    loads = [case.of(total) for case in unbalance_cases(subject)]

    def requirements(speeds: Array) -> Array:
        q = synchronous_response(subject, speeds, loads, others)
        forces, currents = largest_needed(subject, speeds, q)
        voltages_and_shares = (_voltages(subject, speeds, currents), *_shares(subject, speeds, forces, currents))
        return np.stack([forces, currents, *voltages_and_shares], axis=1)

    speeds = with_tables(subject, response_speeds(subject, POINTS))
    speeds = speeds[speeds <= subject.file.speed.tripping]
    critical = about_resonances(speeds, resonances(stiffness_of(subject, others), speeds))
    speeds, needed = refined(requirements, critical, lambda values: values.reshape(len(values), -1))
    forces, currents, voltages, shares, slews = np.moveaxis(needed, 1, 0)
    measured: list[Quantity] = []
    rows: list[tuple[str, ...]] = []
    force_curves, current_curves = [], []
    for k, (bearing, axis) in enumerate(subject.loop.lateral_axes):
        p, name = subject.axis(bearing, axis), f"{bearing}.{axis}"
        force, current = forces[:, k], currents[:, k]
        allowed = control_amplitude(subject, bearing, axis, hertz(speeds))
        for what, share in (("current_demand", shares[:, k]), ("slew_demand", slews[:, k])):
            at = int(share.argmax())
            measured.append(Quantity(what, f"{name} at {rpm(speeds[at]):.0f} rpm", float(share[at]), "%"))
        top, most_used, available = int(force.argmax()), int(shares[:, k].argmax()), _slew_limit(p)
        rows.append(
            (
                name,
                f"{force[top]:.4g}",
                f"{rpm(speeds[top]):.0f}",
                f"{current[most_used]:.3g} of {allowed[most_used]:.3g}",
                f"{voltages[:, k].max():.4g} of {p.voltage_limit:.4g}",
                f"{(speeds * force).max():.4g} of {available:.4g}",
            )
        )
        force_curves.append(curve(name, rpm(speeds), force))
        current_curves.append(curve(f"{name} needs", rpm(speeds), current))
        current_curves += _limit(subject, bearing, axis, speeds)
    heads = ("axis", "force (N)", "at (rpm)", "current (A)", "voltage (V)", "slew rate (N/s)")
    panels = (
        Panel("Amplitude of the bearing forces", "speed (rpm)", "N", tuple(force_curves)),
        Panel("Amplitude of the control currents", "speed (rpm)", "A", tuple(current_curves)),
    )
    grade = 1e3 * subject.file.balancing.speed
    notes = (
        f"Unbalance: {1e6 * total:.4g} g mm, of balancing grade G {grade:g} at the largest speed (ISO 21940-11), "
        "placed for each mode as in the unbalance response; at each speed, the values are those of the worst mode. The "
        "current is the controller's demand, within the controller's limits and the range of its DAC; coils follow "
        "it within the voltage limit R I_0 + I |R + j Omega L| <= V.",
    )
    return AnalysisResult(tuple(measured), panels, (ResultTable("Largest demands", heads, tuple(rows)),), notes)


def _limit(subject: AssessedMachine, bearing: str, axis: str, speeds: Array) -> list[Curve]:
    """Return the curve of the current that an axis can give; empty if the bearing's first axis has the same curve."""
    axes = [of for name, of in subject.loop.lateral_axes if name == bearing]
    limits = [control_amplitude(subject, bearing, of, hertz(speeds)) for of in axes]
    are_alike = all(np.allclose(limit, limits[0], rtol=1e-3) for limit in limits)
    if are_alike and axis != axes[0]:
        return []
    name = bearing if are_alike else f"{bearing}.{axis}"
    return [curve(f"{name} can give", rpm(speeds), limits[axes.index(axis)], "dashed")]


def _voltages(subject: AssessedMachine, speeds: Array, currents: Array) -> Array:
    """Return the largest voltage R I_0 + I |R + j Omega L| (V) of each axis at each speed, shape (speeds, axes)."""
    axes = [subject.axis(bearing, axis) for bearing, axis in subject.loop.lateral_axes]
    impedances = np.stack([np.hypot(p.resistance, speeds * p.inductance) for p in axes], axis=1)
    return currents * impedances + [voltage_at_rest(p) for p in axes]


def _shares(subject: AssessedMachine, speeds: Array, forces: Array, currents: Array) -> tuple[Array, Array]:
    """Return the currents and the slew rates as percentages of their limits, each of shape (speeds, axes)."""
    axes = subject.loop.lateral_axes
    allowed = np.stack([control_amplitude(subject, *axis, hertz(speeds)) for axis in axes], axis=1)
    slew = speeds[:, None] * forces / [_slew_limit(subject.axis(*axis)) for axis in axes]
    return 100.0 * currents / np.maximum(allowed, 1e-12), 100.0 * slew


def _slew_limit(p: np.record) -> float:
    return min(abs(float(rate)) for rate in force_slew_rate(p))


def largest_needed(subject: AssessedMachine, speeds: Array, q: Complex) -> tuple[Array, Array]:
    """Return the worst-case amplitudes of force (N) and current (A) of each axis, both of shape (speeds, axes)."""
    n_axes = len(subject.loop.lateral_axes)
    forces, currents = np.zeros((len(speeds), n_axes)), np.zeros((len(speeds), n_axes))
    rows = [2 * (subject.bearings[bearing] - 1) + AXES.index(axis) for bearing, axis in subject.loop.lateral_axes]
    for k, Omega in enumerate(speeds):
        motion = q[k].reshape(q.shape[1], -1).T  # x and y of each node in turn, by case
        forces[k] = np.abs(bearing_forces(subject, float(Omega), float(Omega)) @ motion)[rows].max(axis=1)
        currents[k] = np.abs(demanded_currents(subject, float(Omega), float(Omega)) @ motion).max(axis=1)
    return forces, currents
