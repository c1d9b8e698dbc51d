"""A picture of several plots, for a page without scripts."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_assessment.reporting.panels import Panel
from amb_cosim.presentation.style import COLOURS, DASHED, GREY, STYLE, StyledFigure, fitted

RESOLUTION = 80  # dots per inch
WIDTH, HEIGHT = 4.4, 3.3  # inches, of a plot
LEGEND_SIZE = 6.5  # points
LINES: tuple[Any, ...] = ("-", (0, (1, 1)), (0, (5, 1, 1, 1)))  # of curves beyond the number of colours


def picture_of(panels: Sequence[Panel]) -> bytes:
    """Return a PNG picture of the plots, or empty data if there are no plots."""
    picture = BytesIO()
    if panels:
        with mpl.rc_context(STYLE):
            figure_of(panels).savefig(picture, format="png", dpi=RESOLUTION)
    return picture.getvalue()


def figure_of(panels: Sequence[Panel]) -> Figure:
    """Return a figure of the plots in the chosen units, with two plots per row."""
    panels = [panel.in_chosen_units() for panel in panels]
    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    figure = StyledFigure(figsize=(WIDTH * columns, HEIGHT * rows), layout="constrained")
    for axes, panel in zip(figure.subplots(rows, columns, squeeze=False).ravel(), panels, strict=False):
        looks = ((colour, line) for line in LINES for colour in COLOURS)
        for curve in panel.curves:
            colour, line = (GREY, DASHED) if curve.style == "dashed" else next(looks, (GREY, "-"))
            marker, line = ("o", "none") if curve.style == "dots" else ("", line)
            axes.plot(curve.x, curve.y, label=curve.name, color=colour, ls=line, marker=marker, ms=3.0, lw=0.8)
        axes.set(title=fitted(panel.title, WIDTH), xlabel=panel.x, ylabel=panel.y)
        axes.locator_params(axis="x", nbins=6)
        for axis in panel.log:
            axes.set(**{f"{axis}scale": "log"})
        if panel.holds:
            axes.update_datalim([(axes.dataLim.x0, value) for value in panel.holds])
            axes.autoscale_view(scalex=False)
        _draw_zones(axes, panel)
        if panel.is_round:
            axes.set_aspect("equal", "datalim")
        if len(panel.curves) > 1:
            columns = _legend_columns([curve.name for curve in panel.curves])
            axes.legend(
                fontsize=LEGEND_SIZE, ncols=columns, loc="upper center", bbox_to_anchor=(0.5, 0.0), borderaxespad=5.5
            )
    for axes in figure.axes[len(panels) :]:
        axes.remove()
    return figure


def _legend_columns(names: Sequence[str]) -> int:
    """Return the number of legend columns that fit below a plot, at most three."""
    column_width = LEGEND_SIZE * (0.55 * max(len(name) for name in names) + 4.0)  # with handle and gap
    return max(1, min(3, int(72.0 * WIDTH / column_width)))


def _draw_zones(axes: Axes, panel: Panel) -> None:
    """Shade the zones upwards from the lower end of the axis, with the lowest zone darkest, and write their names."""
    below, top = axes.get_ylim()
    for k, (limit, name) in enumerate(panel.zones):
        if below < limit:
            axes.axhspan(
                below, min(limit, top), color=str(0.86 + 0.11 * k / max(len(panel.zones) - 1, 1)), lw=0.0, zorder=-2
            )
            axes.annotate(
                name,
                (0.01, min(limit, top)),
                (0, -8),
                xycoords=axes.get_yaxis_transform(),
                textcoords="offset points",
                fontsize=6,
                color="0.35",
            )
            below = limit
    if panel.zones:
        axes.set_ylim(axes.get_ylim()[0], top)
