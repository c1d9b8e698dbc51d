"""Style and colours of all figures, and functions that write figures."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from io import BytesIO
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.figure import Figure, FigureBase
from matplotlib.font_manager import FontProperties
from matplotlib.legend_handler import HandlerBase, HandlerTuple
from matplotlib.lines import Line2D
from matplotlib.patches import Annulus, Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from amb_files.atomic import write_atomically
from array_types import Array

# Colours that colour-blind readers can distinguish (Okabe and Ito).
GREY, ORANGE, BLUE, GREEN, PURPLE = "#999999", "#D55E00", "#0072B2", "#009E73", "#CC79A7"
YELLOW, SKY_BLUE, BROWN = "#E69F00", "#56B4E9", "#8A5A00"
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY_BLUE, YELLOW, "#000000", BROWN, "#5B4FA2", "#004D40")  # of many curves

DASHED = (0, (4, 2))
TITLE_SIZE, TITLE_SHARE = 10.5, 0.96  # of a figure's title: points, and its largest width over that of the figure
LETTER = 0.085  # inches, width of one in a panel's title
RESOLUTION = 200  # dots per inch of a file
RING = 0.06  # width of a retainer's ring over its clearance
RETAINER: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "0.45", "lw": 0.5, "zorder": 0.5}
OF_SAMPLES: dict[Any, HandlerBase] = {tuple: HandlerTuple(ndivide=None, pad=0.0)}  # `handler_map` for `samples`

OF_SESSION = ("backend", "interactive", "toolbar", "webagg", "savefig.directory", "date.epoch", "tk.")  # no style
STYLE: dict[Any, Any] = {  # with the defaults of matplotlib: a user's matplotlibrc, such as text.usetex, does not apply
    **{name: value for name, value in mpl.rcParamsDefault.items() if not name.startswith(OF_SESSION)},
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.formatter.useoffset": False,  # 20.5, not 0.5 with +2e1 beside the axis
    "lines.linewidth": 0.9,
    "legend.frameon": False,
}


class StyledFigure(Figure):
    """A figure in the project's style, which notebooks show as a picture."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        FigureCanvasAgg(self)

    def draw(self, renderer: RendererBase) -> None:
        """Draw in the project's style. Matplotlib creates ticks while it draws, with the style set then."""
        with mpl.rc_context(STYLE):
            super().draw(renderer)

    def _repr_png_(self) -> bytes:
        return png(self)


def set_orbit_axes(panel: Axes, title: str, limit: float, label: str) -> None:
    """Prepare a panel for an orbit: title, label below, and equal axes up to `limit` in all directions."""
    panel.set(title=title, xlabel=label, aspect="equal", xlim=(-limit, limit), ylim=(-limit, limit))
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(4, symmetric=True))


def draw_retainer(panel: Axes, clearance: float) -> None:
    """Draw the inner edge of a retainer or bush as a grey ring behind the orbits, which may touch this ring."""
    panel.add_patch(Annulus((0.0, 0.0), (1.0 + RING) * clearance, RING * clearance, **RETAINER))


def retainer_sample() -> Patch:
    """Return the legend entry for the rings that `draw_retainer` draws."""
    return Patch(**{**RETAINER, "label": "beyond the clearance"})


def samples(colours: Iterable[str], **options: Any) -> tuple[Line2D, ...]:
    """Return the legend entry for curves of several colours, with a piece of each curve; see `OF_SAMPLES`."""
    return tuple(Line2D([], [], color=colour, **options) for colour in colours)


def write_in_corner(panel: Axes, text: str, colour: str = "0.3", line: int = 0) -> None:
    """Write a text into the upper right corner of a panel, `line` lines below the top."""
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}
    style: dict[str, Any] = {"ha": "right", "va": "top", "fontsize": 8, "color": colour, "bbox": box}
    panel.annotate(text, (0.99, 0.97), (0, -12 * line), "axes fraction", textcoords="offset points", **style)


def fitted(text: str, width: float) -> str:
    """Return a title broken into lines that fit a width (inches)."""
    return "\n".join(wrap(text, max(int(width / LETTER), 8))) or text


def write_title(figure: FigureBase, text: str, **place: Any) -> None:
    """Write the title of a figure, and break its lines so that they fit the width."""
    renderer, font = RendererAgg(1, 1, 72.0), FontProperties(size=TITLE_SIZE)  # type: ignore[no-untyped-call]
    width = 72.0 * TITLE_SHARE * figure.get_window_extent().width / figure.get_figure(root=True).dpi
    lines: list[str] = []
    for paragraph in text.splitlines():
        lines.append("")
        for word in paragraph.split(" "):
            longer = f"{lines[-1]} {word}".strip()
            wide = renderer.get_text_width_height_descent(longer, font, "$" in longer)[0]  # type: ignore[no-untyped-call]
            if lines[-1] and wide > width:
                lines.append(word)
            else:
                lines[-1] = longer
    figure.suptitle("\n".join(filter(None, lines)), fontsize=TITLE_SIZE, **place)


def spread(places: ArrayLike, gap: float, lowest: float = -np.inf, highest: float = np.inf) -> Array:
    """Return positions at least `gap` apart, in the same order as `places` and as near to these as possible.

        minimise sum_k (p_k - q_k)^2    subject to    p_(k+1) - p_k >= gap,  lowest <= p_k <= highest

    This is an isotonic regression of q_k - k gap: neighbours that are too close are spread about their mean. Without
    bounds, the result is max_(i<=k) min_(j>=k) of the mean from i to j, which can be computed without the slow import
    of SciPy. Bounds clip this result. If they leave too little room, only the upper bound holds.
    """
    requested = np.asarray(places, np.float64)
    order, offsets = np.argsort(requested, kind="stable"), gap * np.arange(len(requested))
    result, sums = np.empty_like(requested), np.cumsum([0.0, *(requested[order] - offsets)])
    first, end = np.ogrid[: len(requested), 1 : len(sums)]
    means = np.where(end > first, (sums[end] - sums[first]) / np.maximum(end - first, 1), -np.inf)
    ascending = np.minimum.accumulate(means[:, ::-1], axis=1).max(axis=0, initial=-np.inf)[::-1]
    result[order] = np.clip(ascending, lowest, highest - offsets[-1:]) + offsets
    return result


def png(figure: Figure) -> bytes:
    """Return a figure as PNG, at the resolution of a screen."""
    picture = BytesIO()
    with mpl.rc_context(STYLE):
        figure.savefig(picture, format="png")
    return picture.getvalue()


def write_png(figure: Figure, path: Path) -> None:
    """Write a figure as PNG atomically."""
    with mpl.rc_context(STYLE):
        write_atomically(path, partial(figure.savefig, dpi=RESOLUTION, format="png"))


def write_figure(figure: Figure, path: Path) -> None:
    """Write a figure in the format of the file's suffix, `.png`, `.pdf` or `.svg`; the file is written atomically."""
    with mpl.rc_context(STYLE):
        write_atomically(path, partial(figure.savefig, dpi=RESOLUTION, format=path.suffix.lower()[1:]))
