"""The worst margins of a machine whose constants differ from their nominal values by stated tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from amb_analysis.linear.loop import Loop
from amb_analysis.machine.coupled import MachineVariation, coupled_loop
from amb_analysis.studies.loop_vibrations import Vibrations, vibrations
from amb_assessment.assessment.analyses.closed_loop import least_decrement_over
from amb_assessment.assessment.analyses.sensitivity import AxisPeaks, sensitivities, sensitivities_over
from amb_assessment.assessment.format.machine_file import Tolerances
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.stability import (
    least_stable,
    motion_and_speed,
    spectral_radius,
    speeds_of_run_up,
)
from amb_assessment.assessment.physics.stages import real_coefficients

declare("spectral_radius_varied", "1", ("growth_rate", "frequency", "N"))
declare("decrement_varied", "1", ("frequency", "N"), "Smallest logarithmic decrement within the tolerances")
declare("sensitivity_varied", "1")

SPEEDS = 9  # of a corner from zero to the trip speed, before refinement about the least stable one and least decrement
NO_SENSITIVITY = 1e3  # peak that stands for an unstable loop
UNSTABLE_CORNER = (
    f"the loop is not stable, so its sensitivity is unbounded; the data contain {NO_SENSITIVITY:g} instead"
)
NO_BOUND = "without bound"


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the largest spectral radius, the smallest decrement and the largest sensitivity within the tolerances.

    The spectral radius includes all corners of the tolerances and all poles, at speeds from zero to the trip speed. An
    unstable corner has no sensitivity, so the value `NO_SENSITIVITY` is used instead.
    """
    speed, tolerances = subject.file.speed, subject.file.tolerances
    limit, others = subject.file.highest_frequency, real_coefficients(subject)
    rows: list[tuple[str, ...]] = []
    radii: list[Quantity] = []
    decrements: list[Quantity] = []
    peaks: list[Quantity] = []
    for name, variation in variations(tolerances).items():
        loop, speeds = coupled_loop(subject, others, variation), speeds_of_run_up(subject, SPEEDS)

        def vibrating(Omega: float, loop: Loop = loop) -> Vibrations:
            return vibrations(loop, Omega).up_to(limit)

        least = least_decrement_over("decrement_varied", vibrating, speeds[speeds >= speed.lowest])
        decrements.append(Quantity(least.quantity, f"{name}: {least.where}", least.value, "1", least.facts))
        stability = least_stable(subject, variation, SPEEDS)
        radii.append(spectral_radius("spectral_radius_varied", stability, f"{name}: "))
        peak, where = (
            largest_over(loop, {Omega: sensitivities(loop, Omega) for Omega in (speed.lowest, speed.highest)})
            if stability.is_stable
            else (NO_SENSITIVITY, motion_and_speed(stability))
        )
        peaks.append(sensitivity_varied(f"{name}: {where}", peak, stability.is_stable))
        peak_text = f"{peak:.2f}" if stability.is_stable else "not stable"
        rows.append((name, f"{stability.radius:.7f}", motion_and_speed(stability), f"{least.value:.3g}", peak_text))
    worst = int(np.argmax([item.value for item in peaks]))
    if peaks[worst].value < NO_SENSITIVITY:
        name, variation = list(variations(tolerances).items())[worst]
        loop = coupled_loop(subject, others, variation)
        peak, where = largest_over(loop, sensitivities_over(subject, loop))
        peaks[worst] = sensitivity_varied(f"{name}: {where}", peak, is_stable=True)
        rows[worst] = (*rows[worst][:-1], f"{peak:.2f}")
    measured = [
        max(radii, key=lambda item: item.value),
        min(decrements, key=lambda item: item.value),
        max(peaks, key=lambda item: item.value),
    ]
    shares = (
        f"K_i {tolerances.k_i:.0%}, K_s {tolerances.k_s:.0%}, gap {tolerances.gap:.0%}, modes {tolerances.modes:.0%}"
    )
    notes = (
        f"Tolerances: {shares}; all corners are analysed. Stability is judged from zero to the trip speed, and "
        "decrements are judged from the smallest speed to the trip speed. Sensitivities are judged up to half the "
        "sample rate, at the smallest and the largest speed and, for the corner with the largest sensitivity, also "
        "between them. A gap wider by a fraction d divides K_i by (1 + d)^2 and K_s by (1 + d)^3. The modes are the "
        "free rotor's bending modes, which all change by the same factor.",
    )
    heads = ("changed", "largest |z|", "of", "least decrement", "largest |S|")
    return AnalysisResult(tuple(measured), (), (ResultTable("Corners of the tolerances", heads, tuple(rows)),), notes)


def sensitivity_varied(where: str, peak: float, is_stable: bool) -> Quantity:
    """Return the sensitivity at a corner of the tolerances; for an unstable loop, `peak` is `NO_SENSITIVITY`."""
    note, shown = ("", "") if is_stable else (UNSTABLE_CORNER, NO_BOUND)
    return Quantity("sensitivity_varied", where, peak, "1", {}, note, shown=shown)


def variations(tolerances: Tolerances) -> dict[str, MachineVariation]:
    """Return the nominal machine and all corners of its tolerances; the name of each corner states its changes."""
    result = {"nominal": MachineVariation()}
    gaps = (-tolerances.gap, tolerances.gap) if tolerances.gap else (0.0,)
    for i, s, g, m in product((-1, 1), (-1, 1), gaps, (-1, 1)):
        k_i, k_s = 1.0 + i * tolerances.k_i, 1.0 + s * tolerances.k_s
        modes = 1.0 + m * tolerances.modes
        name = f"K_i {k_i:.3g}, K_s {k_s:.3g}, gap {1.0 + g:.3g}, modes {modes:.3g}"
        result[name] = MachineVariation(k_i / (1.0 + g) ** 2, k_s / (1.0 + g) ** 3, modes)
    return result


def largest_over(loop: Loop, by_speed: Mapping[float, Sequence[AxisPeaks]]) -> tuple[float, str]:
    """Return the largest peak in `by_speed` (keys in rad/s), up to half the sample rate, and where it occurs."""
    peaks = (
        (*max(axis.peaks), name, Omega)
        for Omega, axes in by_speed.items()
        for name, axis in zip(loop.axis_names, axes, strict=True)
    )
    peak, hz, name, Omega = max(peaks)
    return peak, f"{name}, {hz:.1f} Hz at {rpm(Omega):.0f} rpm"
