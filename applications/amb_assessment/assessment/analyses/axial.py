"""Axial axis: the static load compared with the capacity, and the sampled loop of the rigid rotor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from amb_actuator.eddy_currents import LAG
from amb_analysis.studies.damping_zones import damping_ratio
from amb_assessment.assessment.analyses.robustness import NO_SENSITIVITY, sensitivity_varied, variations
from amb_assessment.assessment.analyses.sensitivity import PEAKS, zone_limits
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.format.thrust_bearing import ThrustBearing
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, hertz, rpm
from amb_assessment.assessment.physics.axial_cases import (
    NAME,
    LoadCase,
    least_stable_case,
    load_case,
    load_cases,
    static_forces,
    thrust_bearing_of,
    weight_along_z,
)
from amb_assessment.reporting.panels import Panel, curve

declare("axial_load", "%", ("capacity",))
declare("axial_frequency", "Hz", ("frequency", "N"), "Natural frequency of the axial axis")

HEADS = ("bearing force (N)", "control current (A)", "K_s (MN/m)", "Hz", "damping ratio", "decrement", "peak of |S|")


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the share of the capacity that is used, and the stability, frequency and decrement of the axial loop.

    Raises
    ------
    ValueError
        If the machine has no thrust bearing.
    """
    bearing, weight = thrust_bearing_of(subject), weight_along_z(subject)
    largest, capacity = max(bearing.loads(weight), key=abs), bearing.bearing.capacity
    where = f"{NAME}, {abs(largest):.4g} N of {capacity:.4g} N"
    measured = [Quantity("axial_load", where, 100.0 * abs(largest) / capacity, "%", {"capacity": capacity})]
    cases = load_cases(subject)
    measured += _measured(subject, cases)
    beyond = [f"{load:.4g} N" for load in static_forces(subject)[1]]
    notes = [f"The bearing cannot carry {' and '.join(beyond)}, so no loop was computed there."] if beyond else []
    rows = tuple(_row(case) for case in cases)
    tables = (ResultTable("The axial loop under the static forces that it carries", HEADS, rows),) if rows else ()
    return AnalysisResult(tuple(measured), (), tables, (*notes, *_notes(subject, bearing, weight)))


def _measured(subject: AssessedMachine, cases: Sequence[LoadCase]) -> list[Quantity]:
    """Return the stability, decrement and frequency of the axial loop under the worst of all static forces."""
    if not cases:
        return []
    worst = min(cases, key=lambda case: case.least)
    decrement, hz = worst.least
    facts = {"frequency": hz, "N": float(rpm(subject.file.speed.highest))}
    place = f"{NAME}, {hz:.1f} Hz under {worst.name}"
    result = [_spectral_radius("spectral_radius", {f"{NAME} under {case.name}": case for case in cases})]
    note = "axial loop, at every speed"
    result += [Quantity("decrement_anywhere", place, decrement, "1", facts, note, needs_stable_loop=True)]
    if hz > 0.0:
        result.append(
            Quantity("axial_frequency", f"{NAME} under {worst.name}", hz, "Hz", facts, needs_stable_loop=True)
        )
    return result


def margins(subject: AssessedMachine) -> AnalysisResult:
    """Return the largest |S| of the axial loop, and its worst margins within the tolerances of K_i, K_s and gap.

    Raises
    ------
    ValueError
        If the machine has no thrust bearing.
    """
    cases = load_cases(subject)
    measured = [*_peaks(cases), *_varied(subject, cases)]
    drawn = [curve(f"under {case.name}", *case.sensitivity) for case in cases]
    drawn += zone_limits(cases[0].sensitivity[0][[0, -1]])
    return AnalysisResult(tuple(measured), (Panel("|S| of the axial axis", "Hz", "|S|", tuple(drawn), log="x"),))


def _peaks(cases: Sequence[LoadCase]) -> list[Quantity]:
    """Return the largest |S| over all cases, up to 2 kHz and, if the sample rate allows, above 2 kHz."""
    result = []
    for band, quantity in zip(zip(*(case.peaks for case in cases), strict=True), PEAKS, strict=False):
        (peak, hz), case = max(zip(band, (case.name for case in cases), strict=True))
        result.append(Quantity(quantity, f"{NAME}, {hz:.1f} Hz under {case}", peak, "1", {"frequency": hz}))
    return result


def _varied(subject: AssessedMachine, cases: Sequence[LoadCase]) -> list[Quantity]:
    """Return the stability, smallest decrement and largest |S| at the tolerance corners of K_i, K_s and gap."""
    factors = {(v.k_i, v.k_s): None for v in variations(subject.file.tolerances).values()}
    varied = {
        f"{NAME} under {case.name}, K_i {k_i:.3g}, K_s {k_s:.3g}": load_case(subject, case.load, (k_i, k_s))
        for case in cases
        for k_i, k_s in factors
    }
    name = min(varied, key=lambda key: varied[key].least)
    decrement, hz = varied[name].least
    facts = {"frequency": hz, "N": float(rpm(subject.file.speed.highest))}
    peaks = {key: max(case.peaks)[0] if case.stability.is_stable else NO_SENSITIVITY for key, case in varied.items()}
    worst = max(peaks, key=lambda key: peaks[key])
    return [
        _spectral_radius("spectral_radius_varied", varied),
        Quantity("decrement_varied", name, decrement, "1", facts),
        sensitivity_varied(worst, peaks[worst], varied[worst].stability.is_stable),
    ]


def _spectral_radius(quantity: str, cases: Mapping[str, LoadCase]) -> Quantity:
    """Return the largest spectral radius of the named axial loops, which do not depend on the spin speed."""
    name, worst = least_stable_case(cases)
    facts = {"growth_rate": worst.growth_rate, "frequency": float(hertz(worst.frequency))}
    return Quantity(quantity, f"{name}: {worst.motion}", worst.radius, "1", facts, worst.note)


def _row(case: LoadCase) -> tuple[str, ...]:
    decrement, hz = case.least
    state = (f"{case.load:.4g}", f"{case.point.current:.3g}", f"{1e-6 * case.point.k_s:.4g}")
    if not case.stability.is_stable:
        return (*state, f"{hz:.1f}", "", "", "not stable")
    peak, at = max(case.peaks)
    return (*state, f"{hz:.1f}", f"{damping_ratio(decrement):.3f}", f"{decrement:.3f}", f"{peak:.3f} at {at:.1f} Hz")


def _notes(subject: AssessedMachine, bearing: ThrustBearing, weight: float) -> tuple[str, ...]:
    control = subject.axial_control
    low, high = bearing.thrusts
    thrust = f"{low:.4g} N" if low == high else f"{low:.4g} to {high:.4g} N"
    first = (
        f"The rotor is rigid along its axis; its mass is {subject.rotor.mass:.4g} kg. The thrust along z is {thrust}; "
        f"the weight along z is {weight:.4g} N. The loop is sampled every {control.sample_time:g} s; the delay "
        f"of the demands is {control.reacts_after:g} sample times."
    )
    if bearing.corner is None:
        iron = "The iron is assumed to be laminated, without eddy currents. A solid disc always has them."
    else:
        iron = (
            f"Eddy currents cause a half-order lag with a corner at {hertz(bearing.corner):.4g} Hz. It is modelled by "
            f"the sum of {len(LAG.poles)} first-order lags, as in co-simulation."
        )
        if bearing.is_corner_computed:
            iron += (
                " The corner is computed from the material by a formula of this project. Up to 1 kHz, this lag agrees "
                "with the lag of the magnetic field within 13 % for a relative permeability of 500 or more, and within "
                "30 % for 200. Prefer a measured corner."
            )
    tilt = (
        f"The disc has a moment stiffness of {-bearing.moment_stiffness():.4g} N m/rad against tilt; a negative "
        "stiffness tilts the disc further. The lateral analyses of the levitated rotor include it, at the static force "
        "that makes it most negative."
    )
    return (first, iron, tilt)
