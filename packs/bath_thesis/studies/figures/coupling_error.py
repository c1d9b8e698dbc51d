"""Convergence of the co-simulation with decreasing communication step."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from amb_cosim.presentation.style import BLUE, GREEN, ORANGE, PURPLE, SKY_BLUE, YELLOW, StyledFigure, write_title
from bath_thesis.studies.coupling_convergence import ComparisonErrors, CouplingConvergence

SCHEME_STYLES = ((ORANGE, "o"), (BLUE, "s"), (PURPLE, "^"), (GREEN, "D"), (SKY_BLUE, "v"), (YELLOW, "x"))
FLOOR = 1e-10  # smallest error that is drawn; smaller ones are on the axis


def draw(result: CouplingConvergence) -> Figure:
    """Draw the error against the communication step for each comparison and scheme, with slopes for integer orders."""
    figure = StyledFigure(figsize=(8.4, 9.4), layout="constrained")
    for axes, comparison in zip(figure.subplots(2, 2, sharey=True).flat, result.comparisons, strict=True):
        _draw_errors(axes, comparison)
    figure.supxlabel("communication step (µs)", fontsize=9)
    figure.supylabel("largest error of the orbits / largest displacement", fontsize=9)
    write_title(
        figure, f"Co-simulation against the monolithic system, {1e3 * result.duration:g} ms from rest (observed order)"
    )
    return figure


def _draw_errors(axes: Axes, comparison: ComparisonErrors) -> None:
    """Draw the errors of a comparison."""
    steps, schemes = 1e6 * np.array(comparison.steps), comparison.schemes
    for (name, scheme), (colour, marker) in zip(schemes.items(), SCHEME_STYLES, strict=False):
        order_text = "exact; errors below the axis are drawn on it" if scheme.order is None else f"{scheme.order:.2f}"
        errors = np.maximum(scheme.errors, FLOOR)
        axes.loglog(steps, errors, color=colour, marker=marker, ms=4, label=f"{name} ({order_text})", clip_on=False)
    rounded = {name: round(scheme.order) for name, scheme in schemes.items() if scheme.order is not None}
    for order in set(rounded.values()):
        largest = max(schemes[name].errors[-1] for name in rounded if rounded[name] == order)
        slope = 2.5 * largest * (steps / steps[-1]) ** order
        axes.loglog(steps, slope, color="black", lw=0.8, ls=":")
        axes.annotate(f"{order}", (steps[0], slope[0]), (4, 0), textcoords="offset points", va="center")
    axes.set_title(comparison.title)
    axes.set_xticks(steps, [f"{step:.3g}" for step in steps])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.minorticks_off()
    axes.set_ylim(FLOOR, 10.0)
    axes.grid(color="0.9", lw=0.5)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1))
