"""Two plots over the spin speed, with a line for each whirl direction of each vibration: frequencies above damping."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from amb_cosim.presentation.style import DASHED, GREY, StyledFigure, spread
from amb_cosim.presentation.units import speed_unit, spin_label
from amb_cosim.studies.figures.whirl import WHIRL_STYLES

Array = NDArray[np.float64]
Vibration = tuple[Sequence[str | None], Array, Array]  # whirl directions, frequencies (rad/s), damping over speed

# Logarithmic decrements at which the zones of damping end, and what the zone below is (API 617: stability of level II;
# a mode with an amplification 1/(2 zeta) below 2.5 is no critical speed).
ZONES = (
    (0.0, "0.86", "unstable"),
    (0.1, "0.92", "less than API 617 asks"),
    (2.0 * math.pi * 0.2 / math.sqrt(1.0 - 0.2**2), "0.97", "amplifies more than 2.5 times"),
)
DECADES = (1e-4, 1e1)  # that an axis of damping may have
BOX = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6}  # behind a text that lines may cross
LETTERS = 0.042  # share of the axes' height that a line of text takes


def draw_over_speed(
    speeds: Array, vibrations: Sequence[Vibration], operating: float | None
) -> tuple[Figure, Axes, Axes]:
    """Draw vibrations with their numbers, the lines 1x and 2x and the operating speed (rad/s), where it is known.

    Return the figure, the axes of frequencies and those of damping.
    """
    unit = speed_unit()
    figure = StyledFigure(figsize=(7.4, 6.6), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    for directions, frequencies, damping in vibrations:
        for whirl, (colour, line) in WHIRL_STYLES.items():
            selected = np.array([direction == whirl for direction in directions])
            for axes, values in ((top, unit.of(frequencies)), (bottom, damping)):
                axes.plot(unit.of(speeds), np.where(selected, values, np.nan), color=colour, ls=line)
    highest = float(np.nanmax([frequencies for _, frequencies, _ in vibrations], initial=1.0)) / unit.size
    top.set(ylabel=f"damped frequency ({unit.label})", ylim=(0.0, 1.08 * highest))
    top.set_xlim(*unit.of(speeds[[0, -1]]))
    bottom.set(xlabel=spin_label())
    _draw_multiples(top)
    if operating is not None:
        for axes in (top, bottom):
            axes.axvline(operating / unit.size, color=GREY, lw=1.2, zorder=0)
    _number(top, [frequencies / unit.size for _, frequencies, _ in vibrations])
    return figure, top, bottom


def draw_zones(axes: Axes, damping: Sequence[Array], *, is_decrement: bool) -> None:
    """Give the axes of damping a logarithmic scale, through zero where something is unstable, and shade its zones."""
    result = np.concatenate([np.ravel(values) for values in damping]) if damping else np.empty(0)
    result = result[np.isfinite(result)]
    positive = result[result > 0.0]
    low = max(DECADES[0], 10.0 ** math.floor(math.log10(positive.min(initial=0.01))))
    high = min(DECADES[1], 1.6 * positive.max(initial=1.0))
    limits = [decrement if is_decrement else damping_ratio(decrement) for decrement, _, _ in ZONES]
    bottom = low
    if result.min(initial=0.0) < 0.0:
        axes.set_yscale("symlog", linthresh=low, linscale=0.6)
        bottom = max(1.6 * float(result.min()), -DECADES[1])
    else:
        axes.set_yscale("log")
    axes.set_ylim(bottom, high)
    below = bottom
    for limit, (_, shade, text) in zip(limits, ZONES, strict=True):
        if below < min(limit, high):
            axes.axhspan(below, min(limit, high), color=shade, lw=0.0, zorder=-2)
            at = axes.get_yaxis_transform()
            axes.text(
                0.995, below, f"{text} ", transform=at, ha="right", va="bottom", fontsize=7, color="0.35", bbox=BOX
            )
            below = limit
    _number(axes, damping)


def damping_ratio(decrement: float) -> float:
    """Return the damping ratio of a logarithmic decrement: zeta = delta / sqrt(4 pi^2 + delta^2)."""
    return decrement / math.hypot(2.0 * math.pi, decrement)


def add_legend(figure: Figure, vibrations: Sequence[Vibration], operating: float | None, *more: Line2D) -> None:
    """Explain the lines of the whirl directions that there are, the operating speed, and more."""
    present = {whirl for directions, _, _ in vibrations for whirl in directions}
    handles = [
        Line2D([], [], color=c, ls=ls, label=f"{w} whirl") for w, (c, ls) in WHIRL_STYLES.items() if w in present
    ]
    if operating is not None:
        handles.append(Line2D([], [], color=GREY, lw=1.2, label=f"at {speed_unit().text(operating, 5)}"))
    figure.legend(handles=[*handles, *more], loc="outside lower center", ncols=len(handles) + len(more))


def label_points(axes: Axes, places: Sequence[tuple[float, float, str, str]]) -> None:
    """Write texts, each in its colour, to the left of points, above each other where points are close."""
    low, high = axes.get_ylim()
    left, right = axes.get_xlim()
    gap = LETTERS * (high - low)
    displayed = [place for place in places if place[1] <= high]
    heights = spread([y for _, y, _, _ in displayed], gap)
    heights += max(low + 0.5 * gap - heights.min(initial=high), 0.0)
    for (x, y, text, colour), height in zip(displayed, heights, strict=True):
        at = max(x - 0.015 * (right - left), left + 0.085 * (right - left))
        line = {"arrowstyle": "-", "color": colour, "lw": 0.4} if abs(height - y) > 0.5 * gap else None
        style: dict[str, Any] = {
            "ha": "right",
            "va": "center",
            "color": colour,
            "fontsize": 7.5,
            "bbox": BOX,
            "zorder": 5,
        }
        axes.annotate(text, (x, y), (at, height + 0.3 * gap), arrowprops=line, **style)


def _draw_multiples(axes: Axes) -> None:
    """Draw the frequencies of one and two periods a turn, and write which is which within the axes."""
    left, right = axes.get_xlim()
    top = axes.get_ylim()[1]
    for order, line in ((1, ":"), (2, DASHED)):
        axes.plot((0.0, right), (0.0, order * right), color="black", lw=0.7, ls=line)
        x = min(0.965 * right, 0.95 * top / order)
        if x > left:
            axes.text(x, order * x, f"{order}x", ha="right", va="bottom", fontsize=8)


def _number(axes: Axes, curves: Sequence[Array]) -> None:
    """Write the number of each curve at the right end of the axes, apart from each other."""
    low, high = axes.get_ylim()
    scale = axes.transData
    ends = {}
    for number, values in enumerate(curves, start=1):
        available = values[np.isfinite(values)]
        if available.size and low <= available[-1] <= high:
            ends[number] = float(axes.transAxes.inverted().transform(scale.transform((0.0, available[-1])))[1])
    for number, height in zip(ends, spread(list(ends.values()), LETTERS), strict=True):
        axes.text(1.008, height, str(number), transform=axes.transAxes, va="center", fontsize=7, color="0.3")
