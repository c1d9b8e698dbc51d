"""Cross coupling of the stages, from none to the threshold of stability."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from amb_analysis.machine.coupled import coupled_loop
from amb_analysis.studies.loop_vibrations import Vibrations, vibrations
from amb_assessment.assessment.analyses.closed_loop import least_decrement
from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.stages import anticipated
from amb_assessment.reporting.panels import Panel, curve
from array_types import Array
from rotor_analysis.refinement import refined

declare("cross_coupling_ratio", "1", ("Q_a",))
declare("decrement_anticipated", "1", ("frequency", "N"))

MOST = 30.0  # largest searched cross coupling, over the anticipated
POINTS = 25  # of the sweep, before refinement about maxima of the growth rate


def growth_rates(swept: NDArray[np.object_]) -> Array:
    """Return the growth rate (1/s) of each loop of a sweep."""
    return np.array([vibrations.stability.growth_rate for vibrations in swept])


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the decrement with the anticipated coupling, and the coupling at which the loop becomes unstable.

    Both are computed at the largest speed. The coupling at the threshold is stated as a multiple of the anticipated
    one.
    """
    if not subject.file.stages:
        raise ValueError("the machine file has no stages; add their data or their cross coupling")
    speed, limit = subject.file.speed.highest, subject.file.highest_frequency

    def coupled(factor: float) -> Vibrations:
        return vibrations(coupled_loop(subject, anticipated(subject, factor)), speed).up_to(limit)

    def growth(factor: float) -> float:
        return coupled(factor).stability.growth_rate

    def swept_over(more: Array) -> NDArray[np.object_]:
        values = np.empty(len(more), dtype=object)
        values[:] = [coupled(float(factor)) for factor in more]
        return values

    first = np.concatenate([[0.0], np.geomspace(0.1, MOST, POINTS - 1)])
    factors, swept = refined(swept_over, first, growth_rates, resonant=False)
    decrements = np.array([least_decrement("", [(speed, at_factor)]).value for at_factor in swept])
    unstable = np.flatnonzero([not at_factor.stability.is_stable for at_factor in swept])
    note, ratio = "", MOST
    if len(unstable) and unstable[0] > 0:
        ratio = float(brentq(growth, factors[unstable[0] - 1], factors[unstable[0]], xtol=1e-4))
    elif len(unstable):
        ratio, note = 0.0, f"not stable even without cross coupling: {swept[0].stability.motion}"
    else:
        note = f"stable up to {MOST:g} times the anticipated cross coupling, where the sweep ends"
    total = sum(stage.anticipated(speed) for stage in subject.file.stages)
    measured = (
        least_decrement("decrement_anticipated", [(speed, coupled(1.0))]),
        Quantity(
            "cross_coupling_ratio", f"{rpm(speed):.0f} rpm", ratio, "1", {"Q_a": total}, note, needs_stable_loop=True
        ),
    )
    rows = tuple(
        (s.at, s.kind, f"{s.anticipated(speed) * 1e-6:.4g}", f"{s.level_two(speed) * 1e-6:.4g}")
        for s in subject.file.stages
    )
    table = ResultTable("Cross-coupled stiffness", ("stage", "kind", "anticipated (MN/m)", "level II (MN/m)"), rows)
    ends = np.array([0.0, 1e-6 * total * factors[-1]])
    panel = Panel(
        "Smallest logarithmic decrement",
        "cross coupling of all stages (MN/m)",
        "decrement",
        (
            curve("least decrement", 1e-6 * total * factors, decrements),
            curve(
                "anticipated", 1e-6 * np.array([total, total]), [min(0.0, decrements.min()), decrements.max()], "dashed"
            ),
            curve("0.1", ends, [0.1, 0.1], "dashed"),
        ),
    )
    notes = (
        "Each stage acts at its position, with its share of the anticipated coupling. Seals of the rotor file are "
        "omitted: in level I, the anticipated coupling represents all causes of whirl.",
    )
    return AnalysisResult(measured, (panel,), (table,), notes)
