"""Style and colours of all figures, and figures as PNG."""

from __future__ import annotations

from functools import partial
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from amb_files.atomic import write_atomically

# Colours that colour-blind readers can distinguish (Okabe and Ito).
GREY, ORANGE, BLUE, GREEN, PURPLE = "#999999", "#D55E00", "#0072B2", "#009E73", "#CC79A7"
YELLOW, SKY_BLUE = "#E69F00", "#56B4E9"

DASHED = (0, (4, 2))
TITLE_SIZE = 10.5  # points, of a figure's title
LETTER = 0.085  # inches, width of one in a panel's title
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


def set_orbit_axes(panel: Axes, title: str, limit: float, unit: str) -> None:
    """Give a panel that shows an orbit its title, and axes of equal scale up to `limit` either way, in `unit`."""
    panel.set(title=title, xlabel=f"$x$ ({unit})", aspect="equal", xlim=(-limit, limit), ylim=(-limit, limit))
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(4, symmetric=True))


def fitted(text: str, width: float) -> str:
    """Return a title in lines that fit into a width (inches)."""
    return "\n".join(wrap(text, max(int(width / LETTER), 8))) or text


def spread(places: ArrayLike, gap: float) -> NDArray[np.float64]:
    """Return places at least `gap` apart, in the order of the given ones and as near to them as the whole can be.

        minimise sum_k (p_k - q_k)^2    subject to    p_(k+1) - p_k >= gap

    That is isotonic regression of q_k - k gap: neighbours that come too near are spread about their mean.
    """
    wanted = np.asarray(places, np.float64)
    order = np.argsort(wanted, kind="stable")
    blocks: list[list[float]] = []  # sum and number of what stands together
    for shifted in wanted[order] - gap * np.arange(len(wanted)):
        blocks.append([float(shifted), 1.0])
        while len(blocks) > 1 and blocks[-2][0] / blocks[-2][1] >= blocks[-1][0] / blocks[-1][1]:
            total, count = blocks.pop()
            blocks[-1] = [blocks[-1][0] + total, blocks[-1][1] + count]
    means = np.concatenate([np.full(int(count), total / count) for total, count in blocks] or [np.empty(0)])
    result = np.empty_like(wanted)
    result[order] = means + gap * np.arange(len(wanted))
    return result


def png(figure: Figure) -> bytes:
    """Return a figure as PNG, at the resolution of a screen."""
    picture = BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def write_png(figure: Figure, path: Path) -> None:
    """Write a figure as PNG; the file appears complete or not at all."""
    write_atomically(path, partial(figure.savefig, dpi=RESOLUTION, format="png"))
