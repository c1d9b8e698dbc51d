"""Unbalance response for each mode: critical speeds, their amplification and margins, probe limit and clearances."""

from __future__ import annotations

import numpy as np

from amb_analysis.machine.response import refined_response
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import NEARER, AssessedMachine, rpm
from amb_assessment.assessment.physics.stages import real_coefficients, table_notes, with_tables
from amb_assessment.assessment.physics.unbalance_cases import (
    UnbalanceCase,
    base_notes,
    response_speeds,
    unbalance_cases,
)
from amb_assessment.reporting.panels import Panel, curve
from amb_cosim.presentation.digits import significant
from array_types import Array
from rotor_analysis.peaks import Peak, highest_peaks, separation_margin
from rotor_analysis.response import orbit

declare("probe_displacement", "um")
declare("clearance_share", "%", ("S_cc",))
declare("separation_margin", "%", ("AF", "N_c"), "Separation margin of a critical speed")

FACTOR = 2.0  # unbalance over the residual unbalance U_r
LEAST_SCALE, LARGEST_SCALE = 1.0, 6.0  # S_cc


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the response of probes and clearances to twice the residual unbalance, placed to excite each mode."""
    cases = unbalance_cases(subject)
    total = FACTOR * subject.residual_unbalance()
    loads = [case.of(total) for case in cases]
    nodes = tuple({*subject.probes.values(), *(place.node for place in subject.clearances.values())})
    first = with_tables(subject, response_speeds(subject))
    speeds, response = refined_response(subject, first, loads, nodes, real_coefficients(subject))
    amplitudes = orbit(response)[0]
    speed = subject.file.speed
    operating = (speeds >= speed.lowest) & (speeds <= speed.tripping)
    passed = speeds <= speed.tripping
    measured: list[Quantity] = []
    rows: list[tuple[str, ...]] = []
    panels: list[Panel] = []
    for k, case in enumerate(cases):
        at_probes = {name: 2e6 * amplitudes[:, k, node - 1] for name, node in subject.probes.items()}
        for probe, peak in highest_peaks(speeds, at_probes):
            margin, row = _critical(subject, case, probe, peak, total)
            measured.append(margin)
            rows.append(row)
        largest = max(float(values[operating].max()) for values in at_probes.values())
        where = max(at_probes, key=lambda name: float(at_probes[name][operating].max()))
        measured.append(Quantity("probe_displacement", f"{where}, {case.name}", largest, "um"))
        limit = _probe_limit(subject)
        scale = min(max(LEAST_SCALE, limit / largest), LARGEST_SCALE)
        shares = {
            name: 100.0 * (place.offset + scale * float(amplitudes[passed, k, place.node - 1].max())) / place.clearance
            for name, place in subject.clearances.items()
        }
        scaled = f"scaled by {scale:.3g}" + (f", not by {limit / largest:.3g}" if limit < largest else "")
        for name in subject.nearest(shares):
            note = f"of {subject.clearance_text(name)}, {scaled}"
            measured.append(
                Quantity("clearance_share", f"{name}, {case.name}", shares[name], "%", {"S_cc": scale}, note)
            )
        panels.append(_panel(subject, case, speeds, at_probes))
    heads = ("case", "probe", "critical speed (rpm)", "amplification", "margin (%)")
    placed = ResultTable("Unbalance of each mode", ("case", "unbalance, with its sign"), _placed(subject, cases, total))
    notes = (
        f"Unbalance: {FACTOR:g} U_r = {1e6 * total:.4g} g mm in total, U_r = 6350 m/N g mm with the mass m in kg; "
        f"each lobe of a mode's shape receives a share at its antinode, in proportion to mass times shape. Shapes are "
        "computed without damping, seals and stages; the response includes all of these. The speeds extend to 1.5 "
        "times the largest speed of the machine.",
        f"The speed after the number of a mode is its undamped critical speed, for the stiffness that the bearings "
        f"have at {rpm(subject.file.speed.highest):.0f} rpm; it names the shape. The part `critical_map` takes the "
        "stiffness at each critical speed instead.",
        "Critical speeds are peaks of this response, with damping. Unbalance at other places causes peaks at other "
        "speeds; `amb-cosim study unbalance_response`, for example, uses the unbalances of a scenario.",
        "Displacements are peak to peak, along the major axis of the orbit. Shares of clearances are scaled by S_cc = "
        "A_vl/A_max, the ratio of the probe limit to the largest displacement at the probes in operation, limited to "
        "the range from 1 to 6. The published text states only the upper limit of 6; the scale represents vibration "
        "that rises to the limit, so it never reduces a share. The offset of a place is added to the scaled major "
        "axis.",
        NEARER,
        *base_notes(subject),
        *table_notes(subject, float(speeds[-1])),
    )
    return AnalysisResult(
        tuple(measured), tuple(panels), (ResultTable("Critical speeds", heads, tuple(rows)), placed), notes
    )


def _placed(subject: AssessedMachine, cases: list[UnbalanceCase], total: float) -> tuple[tuple[str, ...], ...]:
    """Return, for each mode, the unbalance at each position that excites the mode."""
    return tuple(
        (
            case.name.split(",")[0],
            _amounts(subject, case, total),
        )
        for case in cases
    )


def _amounts(subject: AssessedMachine, case: UnbalanceCase, total: float) -> str:
    """Return the unbalance of a case at each position, for a total unbalance (kg m)."""
    placed = (
        f"{1e6 * share * total:+.3g} g mm at z = {significant(1e3 * subject.z[node - 1])} mm"
        for node, share in case.shares.items()
    )
    return ", ".join(placed)


def _critical(
    subject: AssessedMachine, case: UnbalanceCase, probe: str, peak: Peak, total: float
) -> tuple[Quantity, tuple[str, ...]]:
    """Return the separation margin of a response peak under a total unbalance (kg m), and its table row."""
    speed, Omega, AF = subject.file.speed, rpm(peak.Omega), peak.amplification
    margin = separation_margin(peak.Omega, speed.lowest, speed.highest)
    note = f"amplification {AF:.3g}" + (", from one side of the peak" if peak.from_single_side else "")
    if AF < 2.5:
        note += ": critically damped, no margin required"
    note += f"; with {_amounts(subject, case, total)}"
    where, facts = f"{Omega:.0f} rpm, {case.name}, {probe}", {"AF": AF, "N_c": float(Omega)}
    row = (case.name, probe, f"{Omega:.0f}", f"{AF:.3g}", f"{margin:.1f}")
    return Quantity("separation_margin", where, margin, "%", facts, note), row


def _probe_limit(subject: AssessedMachine) -> float:
    """Return the allowed displacement A_vl at the probes (um peak to peak)."""
    return min(25.4, 25.4 * float(np.sqrt(12000.0 / rpm(subject.file.speed.highest))))


def _panel(subject: AssessedMachine, case: UnbalanceCase, speeds: Array, at_probes: dict[str, Array]) -> Panel:
    curves = [curve(name, rpm(speeds), values) for name, values in at_probes.items()]
    speed = subject.file.speed
    top = max(float(values.max()) for values in at_probes.values())
    limit = _probe_limit(subject)
    curves.append(curve("probe limit", rpm(np.array([speed.lowest, speed.tripping])), [limit, limit], "dashed"))
    for at in (speed.lowest, speed.highest):
        curves.append(curve(f"{rpm(at):.0f} rpm", rpm(np.array([at, at])), [0.0, max(top, limit)], "dashed"))
    return Panel(f"Unbalance for {case.name.split(',')[0]}", "speed (rpm)", "peak to peak (um)", tuple(curves))
