"""Style and colours of all figures, and figures as PNG."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from amb_files.atomic import write_atomically

# Colours that colour-blind readers can distinguish (Okabe and Ito).
GREY, ORANGE, BLUE, GREEN, PURPLE = "#999999", "#D55E00", "#0072B2", "#009E73", "#CC79A7"
YELLOW, SKY_BLUE = "#E69F00", "#56B4E9"

DASHED = (0, (4, 2))
TITLE_SIZE = 10.5  # points, of a figure's title
RESOLUTION = 200  # dots per inch of a file

STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
}


class StyledFigure(Figure):
    """A figure in the project's style, which a notebook shows as a picture."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        FigureCanvasAgg(self)

    def draw(self, renderer: RendererBase) -> None:
        """Draw in the project's style: matplotlib creates ticks only now, with the settings of this moment."""
        with mpl.rc_context(STYLE):
            super().draw(renderer)

    def _repr_png_(self) -> bytes:
        return png(self)


def set_orbit_axes(panel: Axes, title: str, limit: float) -> None:
    """Give a panel that shows an orbit its title, and axes of equal scale up to `limit` (mm) either way."""
    panel.set(title=title, xlabel="$x$ (mm)", aspect="equal", xlim=(-limit, limit), ylim=(-limit, limit))
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(5, symmetric=True))


def png(figure: Figure) -> bytes:
    """Return a figure as PNG, at the resolution of a screen."""
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def write_png(figure: Figure, path: Path) -> None:
    """Write a figure as PNG; the file appears complete or not at all."""
    write_atomically(path, partial(figure.savefig, dpi=RESOLUTION, format="png"))
