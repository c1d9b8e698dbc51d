"""Undamped critical speeds as functions of the support stiffness, and at the bearings' dynamic stiffness."""

from __future__ import annotations

import numpy as np

from amb_analysis.machine.feedback import directional_stiffness, springs
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.unbalance_cases import base_notes
from amb_assessment.reporting.panels import Curve, Panel, curve
from array_types import Array, Complex
from rotor_analysis.critical_speeds import critical_speeds
from rotor_analysis.damping import free_modes

declare("undamped_critical_speed", "rpm", title="Undamped critical speed")

COUNT = 5  # critical speeds
POINTS = 41  # stiffnesses, and speeds
LEAST = 1e-3  # of the largest dynamic stiffness of a magnet: replaces smaller and negative values
DECADES = (-3.0, 1.5)  # of stiffness, about m omega^2/2 with the rotor's mass and first free bending frequency


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the critical speed map, and the critical speeds at the bearings' dynamic stiffness."""
    bending = free_modes(subject.free.M[::2, ::2], subject.free.K[::2, ::2])[0][0]
    scale = 0.5 * subject.rotor.mass * bending**2
    stiffnesses = scale * np.logspace(*DECADES, POINTS)
    highest = 1.5 * subject.file.speed.tripping
    swept = np.linspace(0.02, 1.0, POINTS) * highest
    directions = directional_stiffness(subject, swept)
    supports = next(iter(directions.values()))
    lines = np.full((COUNT, POINTS), np.nan)
    for k, stiffness in enumerate(stiffnesses):
        equal = springs(subject, dict.fromkeys(supports, float(stiffness)), 0.0)
        speeds, _ = critical_speeds(subject.free, equal, COUNT)
        lines[: len(speeds), k] = speeds
    dynamic = {f"{name}{direction}": k for direction, at in directions.items() for name, k in at.items()}
    measured = tuple(
        Quantity("undamped_critical_speed", f"number {number}{direction}", float(rpm(Omega)), "rpm")
        for direction, bearings in directions.items()
        for number, Omega in bearing_critical_speeds(subject, swept, {name: k.real for name, k in bearings.items()})
    )
    rows = tuple(
        (
            name,
            *(
                f"{np.interp(at, swept, k.real) * 1e-6:.3g} and {np.interp(at, swept, k.imag / swept) * 1e-3:.3g}"
                for at in (subject.file.speed.lowest, subject.file.speed.highest)
            ),
        )
        for name, k in dynamic.items()
    )
    heads = ("bearing", *(f"{rpm(at):.0f} rpm" for at in (subject.file.speed.lowest, subject.file.speed.highest)))
    table = ResultTable(
        "Dynamic stiffness (N/µm) and damping (kN s/m) of the bearings at synchronous frequency", heads, rows
    )
    notes = (
        "The rotor is undamped and on equal, isotropic supports, without seals and stages; whirl is forward and "
        "synchronous. The stiffness of a bearing is the real part of force over displacement for parallel motion of "
        "the rotor; it includes controller, hold, delay, amplifier, magnet and passive coefficients. If the axes of a "
        "bearing differ, each is shown; negative values are not shown.",
        "Damping is left out, so these speeds differ from the damped frequencies of the same modes in the part "
        "`closed_loop` and from the peaks in the part `unbalance`, the more so the more a mode is damped.",
        *base_notes(subject),
    )
    return AnalysisResult(measured, (_panel(subject, stiffnesses, lines, swept, dynamic),), (table,), notes)


def bearing_critical_speeds(
    subject: AssessedMachine, speeds: Array, stiffness: dict[str, Array]
) -> list[tuple[int, float]]:
    """Return the number and the value (rad/s) of each undamped critical speed at the bearings' stiffness.

    The k-th critical speed is where Omega_k(K(Omega)) crosses Omega. Crossings between `speeds` are interpolated
    linearly.

    Parameters
    ----------
    subject
        The machine.
    speeds
        Ascending speeds (rad/s), shape (n,).
    stiffness
        Real part of the dynamic stiffness (N/m) of each bearing at these speeds. Values below `LEAST` times the largest
        stiffness of a magnet are raised to this limit.
    """
    floor = LEAST * max(float(np.max(np.abs(stiffness[name]))) for name in subject.magnets)
    excess = np.full((COUNT, len(speeds)), np.nan)
    for n, Omega in enumerate(speeds):
        supports = springs(subject, {name: float(k[n]) for name, k in stiffness.items()}, floor)
        result, _ = critical_speeds(subject.free, supports, COUNT)
        excess[: len(result), n] = result - Omega
    crossings = []
    for k in range(COUNT):
        for n in range(len(speeds) - 1):
            a, b = excess[k, n], excess[k, n + 1]
            if (a < 0.0 <= b) or (b < 0.0 <= a):
                crossings.append((k + 1, float(speeds[n] + a / (a - b) * (speeds[n + 1] - speeds[n]))))
    return sorted(crossings, key=lambda item: item[1])


def _panel(
    subject: AssessedMachine, stiffnesses: Array, lines: Array, swept: Array, dynamic: dict[str, Complex]
) -> Panel:
    curves: list[Curve] = []
    for number, line in enumerate(lines, start=1):
        in_range = np.isfinite(line) & (rpm(line) < 20.0 * rpm(subject.file.speed.tripping))
        if in_range.any():
            curves.append(curve(f"critical speed {number}", stiffnesses[in_range], rpm(line[in_range])))
    for name, k in dynamic.items():
        positive = k.real > stiffnesses[0]
        curves.append(curve(f"bearing {name}", k.real[positive], rpm(swept[positive]), "dots"))
    for what, speed in (("minimum", subject.file.speed.lowest), ("maximum", subject.file.speed.highest)):
        curves.append(curve(f"{what} speed", stiffnesses[[0, -1]], rpm(np.array([speed, speed])), "dashed"))
    return Panel("Undamped critical speed map", "support stiffness (N/m)", "speed (rpm)", tuple(curves), log="xy")
