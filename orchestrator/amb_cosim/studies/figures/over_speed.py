"""Two plots over the spin speed, with a line for each whirl direction of each vibration: frequencies above damping."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from amb_cosim.presentation.style import StyledFigure
from amb_cosim.studies.figures.whirl import WHIRL_STYLES

Array = NDArray[np.float64]
Vibration = tuple[Sequence[str | None], Array, Array]  # whirl directions, frequencies (rad/s), damping over speed


def draw_over_speed(speeds: Array, vibrations: Sequence[Vibration]) -> tuple[Figure, Axes, Axes]:
    """Draw vibrations and the synchronous line; return the figure, the axes of frequencies and those of damping."""
    figure = StyledFigure(figsize=(7.0, 6.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    for directions, frequencies, damping in vibrations:
        for whirl, (colour, line) in WHIRL_STYLES.items():
            selected = np.array([direction == whirl for direction in directions])
            for axes, values in ((top, frequencies), (bottom, damping)):
                axes.plot(speeds, np.where(selected, values, np.nan), color=colour, ls=line)
    highest = float(np.nanmax([frequencies for _, frequencies, _ in vibrations], initial=1.0))
    top.plot(speeds, speeds, color="black", lw=0.8, ls=":")
    top.set(ylabel="damped frequency (rad/s)", ylim=(0.0, 1.08 * highest))
    bottom.set(xlabel=r"spin speed $\Omega$ (rad/s)")
    return figure, top, bottom


def shade_unstable(axes: Axes, lowest: float, last_speed: float) -> None:
    """Begin the axes of damping at `lowest` <= 0, and shade what is below zero."""
    axes.set_ylim(lowest, None)
    if lowest < 0.0:
        axes.axhspan(lowest, 0.0, color="0.93")
        axes.text(last_speed, lowest, "unstable ", ha="right", va="bottom", fontsize=8, color="0.3")


def add_legend(figure: Figure, vibrations: Sequence[Vibration], *more: Line2D) -> None:
    """Explain the lines of the whirl directions that there are, the synchronous line, and more."""
    present = {whirl for directions, _, _ in vibrations for whirl in directions}
    handles = [
        Line2D([], [], color=c, ls=ls, label=f"{w} whirl") for w, (c, ls) in WHIRL_STYLES.items() if w in present
    ]
    handles += [Line2D([], [], color="black", lw=0.8, ls=":", label=r"synchronous, $\omega = \Omega$"), *more]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
