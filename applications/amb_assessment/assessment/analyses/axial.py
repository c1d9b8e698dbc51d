"""The axial axis: static capacity against thrust and weight, and the sampled loop of the rigid rotor along its axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from amb_analysis.linear.stability import LARGEST, stability_of
from amb_analysis.studies.damping_zones import damping_ratio
from amb_analysis.studies.sensitivity_curves import curve_frequencies
from amb_assessment.assessment.analyses.robustness import variations
from amb_assessment.assessment.analyses.sensitivity import zone_limits
from amb_assessment.assessment.findings import AnalysisResult, Quantity, ResultTable
from amb_assessment.assessment.subject import Subject, hertz, rpm
from amb_assessment.assessment.thrust_bearing import ThrustBearing
from amb_assessment.reporting.panels import Panel, curve
from array_types import Array
from rotor_analysis.refinement import refined
from thrust_bearings.axial_loop import AxialLoop
from thrust_bearings.disc import OperatingPoint
from thrust_bearings.rational_lag import TOLERANCE

NAME = "thrust.z"
HEADS = ("bearing force (N)", "control current (A)", "K_s (MN/m)", "Hz", "damping ratio", "decrement", "peak of |S|")


@dataclass(frozen=True)
class LoadCase:
    """The loop under a static force of the bearing (N): its operating point, and |S| over frequency if it is stable."""

    load: float
    point: OperatingPoint
    loop: AxialLoop
    frequencies: Array
    S: Array

    @property
    def name(self) -> str:
        """The force as text."""
        return f"{self.load:.4g} N"

    @property
    def peak(self) -> tuple[float, float]:
        """Largest |S| and its frequency (Hz); nothing for an unstable loop."""
        top = int(self.S.argmax())
        return float(self.S[top]), float(self.frequencies[top])

    @property
    def least(self) -> tuple[float, float]:
        """Smallest logarithmic decrement of its vibrations and their frequency (Hz)."""
        return least_decrement(self.loop)


def answer(subject: Subject) -> AnalysisResult:
    """Return the used share of the capacity, and frequency, decrement and sensitivity of the axial loop.

    Raises
    ------
    ValueError
        If the machine has no thrust bearing.
    """
    bearing = subject.file.thrust_bearing
    if bearing is None:
        raise ValueError(f"machine {subject.file.name} has no [thrust_bearing]")
    weight = subject.file.axial_gravity * subject.rotor.mass
    loads, capacity = bearing.loads(weight), bearing.bearing.capacity
    largest = max(loads, key=abs)
    where = f"{NAME}, {abs(largest):.4g} N of {capacity:.4g} N"
    measured = [Quantity("axial_load", where, 100.0 * abs(largest) / capacity, "%", {"capacity": capacity})]
    cases = [_case(subject, bearing, load) for load in loads if abs(load) <= capacity]
    measured += _measured(subject, cases)
    beyond = [f"{load:.4g} N" for load in loads if abs(load) > capacity]
    notes = [f"The bearing cannot carry {' and '.join(beyond)}, so there is no loop."] if beyond else []
    rows = tuple(_row(case) for case in cases)
    tables = (ResultTable("The axial loop under the static forces that it carries", HEADS, rows),) if rows else ()
    return AnalysisResult(tuple(measured), _panels(cases), tables, (*notes, *_notes(subject, bearing, weight)))


def _case(subject: Subject, bearing: ThrustBearing, load: float, factors: tuple[float, float] = (1.0, 1.0)) -> LoadCase:
    point = bearing.bearing.operating_point(load)
    loop = bearing.loop(subject.rotor.mass, point, factors)
    if not loop.is_stable:
        return LoadCase(load, point, loop, np.zeros(0), np.zeros(0))
    first = curve_frequencies(loop.poles, loop.sample_time)
    frequencies, S = refined(lambda more: np.abs(loop.sensitivity(more)), first, lambda of: of)
    return LoadCase(load, point, loop, frequencies, S)


def least_decrement(loop: AxialLoop) -> tuple[float, float]:
    """Return the smallest logarithmic decrement of a loop and its frequency (Hz), 0 for growth without vibration."""
    s = loop.vibrations
    found = [(float(-2.0 * np.pi * one.real / one.imag), float(hertz(one.imag))) for one in s]
    growing = np.abs(loop.poles).max() >= 1.0 and not any(decrement <= 0.0 for decrement, _ in found)
    if growing:  # along the real axis: a bearing without enough stiffness lets the rotor go
        found.append((-LARGEST, 0.0))
    return min(found, default=(LARGEST, 0.0))


def _measured(subject: Subject, cases: Sequence[LoadCase]) -> list[Quantity]:
    """Return the worst of all static forces, and with the tolerances of the constants."""
    if not cases:
        return []
    N = float(rpm(subject.file.speed.highest))
    worst = min(cases, key=lambda case: case.least)
    decrement, hz = worst.least
    facts = {"frequency": hz, "N": N}
    place = f"{NAME}, {hz:.1f} Hz under {worst.name}"
    result = [_spectral_radius("spectral_radius", {f"{NAME} under {case.name}": case.loop for case in cases})]
    result += [Quantity("decrement_anywhere", place, decrement, "1", facts, "axial loop, at every speed")]
    if hz > 0.0:
        result.append(Quantity("axial_frequency", f"{NAME} under {worst.name}", hz, "Hz", facts))
    stable = [case for case in cases if len(case.S)]
    if len(stable) == len(cases):
        case = max(stable, key=lambda case: case.peak)
        peak, at = case.peak
        place = f"{NAME}, {at:.1f} Hz under {case.name}"
        result.append(Quantity("sensitivity_peak", place, peak, "1", {"frequency": at}))
    return result + _varied(subject, cases, N)


def _varied(subject: Subject, cases: Sequence[LoadCase], N: float) -> list[Quantity]:
    """Return the smallest decrement and the largest |S| in the corners of the tolerances of K_i, K_s and gap."""
    bearing = subject.file.thrust_bearing
    assert bearing is not None
    decrements, peaks, loops = [], [], {}
    factors = {(v.k_i, v.k_s): None for v in variations(subject.file.tolerances).values()}
    for case in cases:
        for k_i, k_s in factors:
            varied = _case(subject, bearing, case.load, (k_i, k_s))
            name = f"{NAME} under {case.name}, K_i {k_i:.3g}, K_s {k_s:.3g}"
            loops[name] = varied.loop
            decrement, hz = varied.least
            decrements.append(Quantity("decrement_varied", name, decrement, "1", {"frequency": hz, "N": N}))
            if len(varied.S):
                peaks.append(Quantity("sensitivity_varied", name, varied.peak[0], "1"))
    least = min(decrements, key=lambda item: item.value)
    radius = _spectral_radius("spectral_radius_varied", loops)
    return [radius, least, *([max(peaks, key=lambda item: item.value)] if len(peaks) == len(decrements) else [])]


def _spectral_radius(quantity: str, loops: Mapping[str, AxialLoop]) -> Quantity:
    """Return the largest spectral radius of loops by name; the axial loop does not depend on the speed."""
    name, worst = max(
        ((name, stability_of(loop.step_matrix, loop.sample_time)) for name, loop in loops.items()),
        key=lambda pair: pair[1].radius,
    )
    facts = {"growth_rate": worst.growth_rate, "frequency": float(hertz(worst.frequency))}
    return Quantity(quantity, f"{name}: {worst.motion}", worst.radius, "1", facts, worst.note)


def _row(case: LoadCase) -> tuple[str, ...]:
    decrement, hz = case.least
    state = (f"{case.load:.4g}", f"{case.point.current:.3g}", f"{1e-6 * case.point.k_s:.4g}")
    if not len(case.S):
        return (*state, f"{hz:.1f}", "", "", "not stable")
    peak, at = case.peak
    return (*state, f"{hz:.1f}", f"{damping_ratio(decrement):.3f}", f"{decrement:.3f}", f"{peak:.3f} at {at:.1f} Hz")


def _panels(cases: Sequence[LoadCase]) -> tuple[Panel, ...]:
    stable = [case for case in cases if len(case.S)]
    if not stable:
        return ()
    drawn = [curve(f"under {case.name}", case.frequencies, case.S) for case in stable]
    drawn += zone_limits(stable[0].frequencies[[0, -1]])
    return (Panel("|S| of the axial axis", "Hz", "|S|", tuple(drawn), log="x"),)


def _notes(subject: Subject, bearing: ThrustBearing, weight: float) -> tuple[str, ...]:
    _, sample_time, delay = bearing.law
    low, high = bearing.thrusts
    thrust = f"{low:.4g} N" if low == high else f"{low:.4g} to {high:.4g} N"
    lag = bearing.lag(sample_time)
    first = (
        f"The rotor is rigid along its axis, {subject.rotor.mass:.4g} kg. Thrust {thrust} along z, weight along z "
        f"{weight:.4g} N. Sampled every {sample_time:g} s, demands {delay:g} samples late."
    )
    if bearing.corner is None:
        iron = "The iron is taken as laminated: without eddy currents, which a solid disc always has."
    else:
        iron = (
            f"Eddy currents: half-order lag with corner {hertz(bearing.corner):.4g} Hz as {len(lag.poles)} first-order "
            f"lags, {100.0 * lag.error:.2g} % error from 0.1 Hz to the sample rate (at most {100.0 * TOLERANCE:g} %)."
        )
        if bearing.is_corner_computed:
            iron += (
                " The corner follows from the material by a formula derived here. With a relative permeability of 500 "
                "or more, the lag is that of the field within 13 % up to 1 kHz; with 200, within 30 %. Prefer a "
                "measured corner."
            )
    tilt = (
        f"Tilted, the disc has a moment stiffness of {-bearing.moment_stiffness():.4g} N m/rad, negative as it tilts "
        "further. The lateral analyses do not contain it."
    )
    return (first, iron, tilt, "The axial axis does not act in the co-simulation: no landing on axial retainers.")
