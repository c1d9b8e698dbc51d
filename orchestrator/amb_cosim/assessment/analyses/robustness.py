"""The worst margins of a machine whose constants differ from their nominal values by stated tolerances."""

from __future__ import annotations

from itertools import product

import numpy as np

from amb_cosim.assessment.analyses.closed_loop import least_decrement, vibrations_within
from amb_cosim.assessment.analyses.sensitivity import sensitivities
from amb_cosim.assessment.findings import AnalysisResult, Quantity, ResultTable
from amb_cosim.assessment.machine_file import Tolerances
from amb_cosim.assessment.stages import real_coefficients
from amb_cosim.assessment.subject import Subject, rpm
from amb_cosim.linear.loop import Loop
from amb_cosim.machine.coupled import MachineVariation, coupled_loop

TITLE = "Robustness: worst margins within the tolerances"


def answer(subject: Subject) -> AnalysisResult:
    """Return the smallest decrement and the largest sensitivity peak over all corners of the tolerances."""
    speed, tolerances = subject.file.speed, subject.file.tolerances
    limit, others = subject.file.highest_frequency, real_coefficients(subject)
    rows: list[tuple[str, ...]] = []
    decrements: list[Quantity] = []
    peaks: list[Quantity] = []
    for name, variation in variations(tolerances).items():
        loop = coupled_loop(subject, others, variation)
        speeds = dict.fromkeys((speed.lowest, speed.highest, speed.tripping))
        result = [(Omega, vibrations_within(loop, Omega, limit)) for Omega in speeds]
        least = least_decrement("decrement_varied", result)
        decrements.append(Quantity(least.quantity, f"{name}: {least.where}", least.value, "1", least.facts))
        peak = _largest(loop, speeds) if least.value > 0.0 else None
        if peak is not None:
            peaks.append(Quantity("sensitivity_varied", f"{name}: {peak[1]}", peak[0], "1"))
        rows.append((name, f"{least.value:.3f}", least.where, "not stable" if peak is None else f"{peak[0]:.2f}"))
    measured = [min(decrements, key=lambda item: item.value)]
    measured += [max(peaks, key=lambda item: item.value)] if peaks else []
    shares = (
        f"K_i {tolerances.k_i:.0%}, K_s {tolerances.k_s:.0%}, gap {tolerances.gap:.0%}, modes {tolerances.modes:.0%}"
    )
    notes = (
        f"Tolerances: {shares}, all corners at smallest, largest and trip speed. A gap wider by a fraction d divides "
        "K_i by (1 + d)^2 and K_s by (1 + d)^3. Modes are the free rotor's bending modes, all changed alike.",
    )
    heads = ("changed", "least decrement", "of", "largest |S|")
    return AnalysisResult(tuple(measured), (), (ResultTable("Corners of the tolerances", heads, tuple(rows)),), notes)


def variations(tolerances: Tolerances) -> dict[str, MachineVariation]:
    """Return the nominal machine and all corners of its tolerances, by the changes."""
    result = {"nominal": MachineVariation()}
    gaps = (-tolerances.gap, tolerances.gap) if tolerances.gap else (0.0,)
    for i, s, g, m in product((-1, 1), (-1, 1), gaps, (-1, 1)):
        k_i, k_s = 1.0 + i * tolerances.k_i, 1.0 + s * tolerances.k_s
        modes = 1.0 + m * tolerances.modes
        name = f"K_i {k_i:.3g}, K_s {k_s:.3g}, gap {1.0 + g:.3g}, modes {modes:.3g}"
        result[name] = MachineVariation(k_i / (1.0 + g) ** 2, k_s / (1.0 + g) ** 3, modes)
    return result


def _largest(loop: Loop, speeds: dict[float, None]) -> tuple[float, str] | None:
    worst = (0.0, "")
    for Omega in list(speeds)[:2]:
        try:
            result = sensitivities(loop, Omega)
        except ValueError:
            return None
        for name, frequencies, values in result:
            top = int(np.argmax(values))
            worst = max(worst, (float(values[top]), f"{name}, {frequencies[top]:.1f} Hz at {rpm(Omega):.0f} 1/min"))
    return worst
