"""One picture of several plots, for a page that runs no scripts."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from itertools import cycle

from amb_cosim.presentation.style import BLUE, DASHED, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, YELLOW, StyledFigure
from amb_cosim.reporting.panels import Panel

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, YELLOW, SKY_BLUE, "#000000")
RESOLUTION = 80  # dots per inch
WIDTH, HEIGHT = 4.2, 2.9  # inches, of a plot


def picture_of(panels: Sequence[Panel]) -> bytes:
    """Return a PNG of the plots, two in a row; nothing without plots."""
    if not panels:
        return b""
    columns = min(2, len(panels))
    rows = -(-len(panels) // columns)
    figure = StyledFigure(figsize=(WIDTH * columns, HEIGHT * rows), layout="constrained")
    for axes, panel in zip(figure.subplots(rows, columns, squeeze=False).ravel(), panels, strict=False):
        colours = cycle(COLOURS)
        for curve in panel.curves:
            marker, line = ("o", "none") if curve.style == "dots" else ("", DASHED if curve.style == "dashed" else "-")
            colour = GREY if curve.style == "dashed" else next(colours)
            axes.plot(curve.x, curve.y, label=curve.name, color=colour, ls=line, marker=marker, ms=3.0, lw=0.8)
        axes.set(title=panel.title, xlabel=panel.x, ylabel=panel.y)
        for axis in panel.log:
            axes.set(**{f"{axis}scale": "log"})
        if panel.is_round:
            axes.set_aspect("equal", "datalim")
        if len(panel.curves) > 1:
            axes.legend(fontsize=7)
    for axes in figure.axes[len(panels) :]:
        axes.remove()
    picture = BytesIO()
    figure.savefig(picture, format="png", dpi=RESOLUTION)
    return picture.getvalue()
