"""Deviation of the orbit over the communication step, by order of the master."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from amb_analysis.studies.coupling_order import CouplingOrders
from amb_cosim.presentation.style import BLUE, GREEN, ORANGE, PURPLE, SKY_BLUE, StyledFigure, write_title

STYLES = ((BLUE, "s"), (ORANGE, "o"), (GREEN, "D"), (PURPLE, "^"), (SKY_BLUE, "v"))
LEAST = 1e-4  # %; smaller deviations are drawn here, labelled "less"


def draw(result: CouplingOrders) -> Figure:
    """Draw the deviation of the orbit from the first run over the step; hollow markers denote a different outcome."""
    figure = StyledFigure(figsize=(6.4, 4.2), layout="constrained")
    axes, first = figure.subplots(), result.rows[0]
    orders = dict.fromkeys(row.order for row in result.rows)
    for order, (colour, marker) in zip(orders, STYLES, strict=False):
        rows = [row for row in result.rows if row.order == order and row is not first]
        steps, errors = [1e6 * row.step for row in rows], [max(100.0 * row.deviation, LEAST) for row in rows]
        axes.plot(steps, errors, color=colour, lw=0.9)
        axes.plot([], [], marker, ls="-", color=colour, lw=0.9, ms=5, label=order)
        for step, error, row in zip(steps, errors, rows, strict=True):
            face = colour if row.outcome == first.outcome else "white"
            axes.plot(step, error, marker, color=colour, mfc=face, ms=5)
    steps = sorted({1e6 * row.step for row in result.rows})
    axes.set(xscale="log", yscale="log", xlabel="communication step (µs)", ylabel="deviation of the orbit (%)")
    axes.set_xticks(steps, [f"{step:.3g}" for step in steps])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}" if value > 1.1 * LEAST else "less"))
    axes.set_ylim(bottom=0.7 * LEAST)
    axes.grid(color="0.9", lw=0.5)
    figure.legend(loc="outside lower center", ncols=3)
    write_title(
        figure,
        f"{result.scenario}: order of the master and communication step; "
        f"filled: {first.outcome}, hollow: another outcome",
    )
    return figure
