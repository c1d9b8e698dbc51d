"""Frequencies and damping over the spin speed, in two plots with a line for each whirl direction of each vibration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, covered_speeds, frozen_at
from amb_analysis.studies.damping_zones import ZONES, damping_ratio
from amb_cosim.presentation.style import BLUE, DASHED, GREEN, GREY, ORANGE, PURPLE, spread
from amb_cosim.presentation.units import speed_unit, spin_label
from array_types import Array

Box = tuple[float, float, float, float]  # left, right, lower and upper end
Vibration = tuple[Sequence[str | None], Array, Array]  # whirl directions, frequencies (rad/s), damping over speed

WHIRL_STYLES: dict[str, tuple[str, Any]] = {
    "backward": (ORANGE, DASHED),
    "forward": (BLUE, "-"),
    "mixed": (PURPLE, ":"),
    "axial": (GREEN, "-."),
}
HATCH: dict[str, Any] = {
    "facecolor": "none",
    "edgecolor": "0.8",
    "hatch": "////",
    "lw": 0.0,
}
UNSTABLE_LOOP: dict[str, Any] = {"facecolor": "none", "edgecolor": "#C9A0B4", "hatch": "..", "lw": 0.0}
SHADES = ("0.86", "0.92", "0.97")  # of the zones of damping
SIZE = (7.4, 6.6)  # inches, of both plots
DECADES = (1e-4, 1e1)  # widest range of an axis of damping
BOX = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6}  # behind a text that lines cross
WHITE: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}  # behind a label beside a curve
LABEL_SIZE = 7.5  # points
STEPS = [sign * 0.75 * k for k in range(1, 12) for sign in (1, -1)]  # heights of a label's middle above its point
IN_A_ROW = 5  # entries of a legend as wide as the plots
NUMBERS = 1.03  # position of the numbers of curves over the axes' width; marks at the end of a curve reach to 1.014
LETTERS = 0.042  # share of the axes' height that a line of text takes


def draw_over_speed(
    figure: FigureBase, speeds: Array, vibrations: Sequence[Vibration], operating: float | None
) -> tuple[Axes, Axes]:
    """Draw vibrations with their numbers, the lines 1x and 2x and, if it is known, the operating speed (rad/s).

    Return the axes of frequency and of damping.
    """
    unit = speed_unit()
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
    return top, bottom


def draw_zones(axes: Axes, damping: Sequence[Array], *, is_decrement: bool, also: Sequence[float] = ()) -> None:
    """Set a logarithmic scale for damping and shade its zones; the scale includes zero if damping is negative.

    The scale also covers the values in `also`, for which no curve is drawn.
    """
    finite = np.concatenate([*map(np.ravel, damping), np.asarray(also, np.float64)])
    finite = finite[np.isfinite(finite)]
    positive = finite[finite > 0.0]
    limits = [decrement if is_decrement else damping_ratio(decrement) for decrement, _ in ZONES]
    low = max(DECADES[0], 10.0 ** math.floor(math.log10(positive.min(initial=limits[-1]))))
    high = min(DECADES[1], 1.6 * positive.max(initial=limits[-1]))
    bottom = low
    if finite.min(initial=0.0) < 0.0:
        axes.set_yscale("symlog", linthresh=low, linscale=0.6)
        bottom = max(1.6 * float(finite.min()), -DECADES[1])
    else:
        axes.set_yscale("log")
    axes.set_ylim(bottom, high)
    below, to_axes = bottom, axes.transAxes.inverted()
    for limit, shade, (_, text) in zip(limits, SHADES, ZONES, strict=True):
        if below < min(limit, high):
            axes.axhspan(below, min(limit, high), color=shade, lw=0.0, zorder=-2)
            ends = axes.transData.transform([(1.0, below), (1.0, min(limit, high))])
            lower, upper = to_axes.transform(ends)[:, 1]
            style: dict[str, Any] = {"ha": "left", "va": "center", "fontsize": 7, "color": "0.35", "bbox": BOX}
            axes.text(0.01, _free_height(axes, text, lower, upper), text, transform=axes.transAxes, **style)
            below = limit
    _number(axes, damping)


def _free_height(axes: Axes, text: str, lower: float, upper: float) -> float:
    """Return a height between two limits, midway if possible, at which a text at the left edge crosses no curve.

    Heights and the text's width are in fractions of the axes.
    """
    to_axes = axes.transData + axes.transAxes.inverted()
    curves = [to_axes.transform(_data(line).T).T for line in axes.lines]
    width = 0.6 * 7.0 / 72.0 * axes.figure.dpi / axes.get_window_extent().width * len(text)
    half = 0.5 * LETTERS
    for share in (0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9):
        height = lower + share * (upper - lower)
        box = (0.01, 0.01 + width, height - half, height + half)
        if not any(_crosses(curve, box) for curve in curves if curve.shape[1] > 1):
            return height
    return 0.5 * (lower + upper)


def add_legend(figure: FigureBase, vibrations: Sequence[Vibration], operating: float | None, *more: Artist) -> None:
    """Add a legend of the whirl directions that occur, the operating speed, and `more`."""
    present = {whirl for directions, _, _ in vibrations for whirl in directions}
    handles: list[Artist] = [
        Line2D([], [], color=c, ls=ls, label=_direction(w)) for w, (c, ls) in WHIRL_STYLES.items() if w in present
    ]
    if operating is not None:
        handles.append(Line2D([], [], color=GREY, lw=1.2, label=f"at {speed_unit().text(operating, 5)}"))
    handles += more
    columns = len(handles) if len(handles) <= IN_A_ROW else math.ceil(len(handles) / 2)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns)


def _direction(whirl: str) -> str:
    return "along the shaft" if whirl == "axial" else f"{whirl} whirl"


def label_points(axes: Axes, places: Sequence[tuple[float, float, str, str]]) -> None:
    """Write coloured labels beside points, away from curves; if there are many, write only every nth label.

    A label is as near to its point as other labels and the curves of the axes allow.
    """
    low, high = axes.get_ylim()
    left, right = axes.get_xlim()
    gap, shift = LETTERS * (high - low), 0.012 * (right - left)
    letter = LABEL_SIZE / 72.0 * 0.62 * axes.figure.dpi / axes.get_window_extent().width * (right - left)
    curves = [curve for curve in map(_data, axes.lines) if curve.shape[1] > 1]
    visible = [place for place in places if place[1] <= high]
    taken: list[Box] = [(x - 0.6 * shift, x + 0.6 * shift, y - 0.3 * gap, y + 0.3 * gap) for x, y, _, _ in places]
    for x, y, text, colour in visible[:: _every(len(visible))]:
        width = letter * len(text)
        begins = {"right": max(x - shift - width, left), "left": min(x + shift, right - width)}
        boxes = [
            (side, (begins[side], begins[side] + width, y + (step - 0.5) * gap, y + (step + 0.5) * gap))
            for step, side in product(STEPS, begins)
        ]
        boxes = [(side, box) for side, box in boxes if low <= box[2] and box[3] <= high] or boxes
        beside = [(side, box) for side, box in boxes if not any(_overlap(box, other) for other in taken)] or boxes
        side, box = next(((s, box) for s, box in beside if not any(_crosses(c, box) for c in curves)), beside[0])
        taken.append(box)
        height = 0.5 * (box[2] + box[3])
        line = {"arrowstyle": "-", "color": colour, "lw": 0.4} if abs(height - y) > 1.2 * gap else None
        style: dict[str, Any] = {"ha": side, "va": "center", "color": colour, "bbox": WHITE, "zorder": 5}
        at = (box[1] if side == "right" else box[0], height)
        axes.annotate(text, (x, y), at, arrowprops=line, fontsize=LABEL_SIZE, **style)


def _data(line: Line2D) -> Array:
    """Return x and y of a line, shape (2, n)."""
    return np.array([np.asarray(values, np.float64) for values in line.get_data()])


def _overlap(box: Box, other: Box) -> bool:
    """Return whether two boxes overlap."""
    return box[0] < other[1] and other[0] < box[1] and box[2] < other[3] and other[2] < box[3]


def _crosses(curve: Array, box: Box) -> bool:
    """Return whether a curve, given by its x and y, shape (2, n), passes through a box."""
    x, y = curve
    heights = np.interp(np.linspace(box[0], box[1], 9), x, y, left=np.nan, right=np.nan)
    return bool(np.any((heights > box[2]) & (heights < box[3])))


def _draw_multiples(axes: Axes) -> None:
    """Draw the lines 1x and 2x and write their labels below them, because labels of critical speeds are above."""
    left, right = axes.get_xlim()
    top = axes.get_ylim()[1]
    for order, line in ((1, ":"), (2, DASHED)):
        axes.plot((0.0, right), (0.0, order * right), color="black", lw=0.7, ls=line)
        x = _free_place(axes, min(0.965 * right, 0.95 * top / order), order)
        if x > left:
            style: dict[str, Any] = {
                "textcoords": "offset points",
                "ha": "left",
                "va": "top",
                "fontsize": 8,
                "bbox": BOX,
            }
            axes.annotate(f"{order}x", (x, order * x), (2, -1), **style)


def _free_place(axes: Axes, last: float, order: int) -> float:
    """Return the x coordinate of the label 1x or 2x: `last` or, if a curve is in the way, a smaller value."""
    low, high = axes.get_ylim()
    left, right = axes.get_xlim()
    curves = [curve for curve in map(_data, axes.lines) if curve.shape[1] > 2]
    height, width = LETTERS * (high - low), 0.03 * (right - left)
    for x in np.linspace(last, 0.3 * last, 36):
        box = (x - 3.0 * width, min(x + 1.5 * width, right), order * x - 2.5 * height, order * x + height)
        if not any(_crosses(curve, box) for curve in curves):
            return float(x)
    return last


def _number(axes: Axes, curves: Sequence[Array]) -> None:
    """Write the numbers of curves at their right ends without overlap, or only every nth if there are many.

    If a number is moved, a line joins it to the end of its curve.
    """
    low, high = axes.get_ylim()
    scale = axes.transData
    ends = {}
    for number, values in enumerate(curves, start=1):
        finite = values[np.isfinite(values)]
        if finite.size and low <= finite[-1] <= high:
            ends[number] = float(axes.transAxes.inverted().transform(scale.transform((0.0, finite[-1])))[1])
    step = _every(len(ends))
    ends = {number: height for number, height in ends.items() if number % step == 0}
    for number, height in zip(ends, spread(list(ends.values()), LETTERS, 0.0, 1.0), strict=True):
        axes.text(NUMBERS, height, str(number), transform=axes.transAxes, va="center", fontsize=7, color="0.3")
        if abs(height - ends[number]) > 0.25 * LETTERS:
            leader = [(1.0, ends[number]), (NUMBERS - 0.003, height)]
            style: dict[str, Any] = {"transform": axes.transAxes, "colors": "0.6", "linewidths": 0.5, "clip_on": False}
            axes.add_artist(LineCollection([leader], **style))


def _every(labels: int) -> int:
    """Return the smallest n for which the height of the axes has room for every nth label."""
    return max(math.ceil(LETTERS * labels), 1)


def hatch_extrapolated(panels: Sequence[Axes], speeds: Array, limits: Limits) -> list[Patch]:
    """Hatch the speeds (rad/s) that a table of coefficients does not cover, and return their legend entry.

    `speeds` must be ascending; the x axes of the panels show the spin speed.
    """
    unit, (lowest, highest) = speed_unit(), covered_speeds(limits)
    first, last = float(speeds[0]), float(speeds[-1])
    spans = [(first, min(lowest, last))] if first < lowest else []
    spans += [(max(highest, first), last)] if last > highest else []
    for panel in panels:
        for ends in spans:
            panel.axvspan(*unit.of(ends), zorder=-1, **HATCH)
    return [Patch(label=f"coefficients {EXTRAPOLATED}", **HATCH)] if spans else []


def shade_unstable(panels: Sequence[Axes], ranges: Sequence[tuple[float, float]]) -> list[Patch]:
    """Shade the speeds (rad/s) at which the loop is not stable, and return their legend entry."""
    for panel in panels:
        for ends in ranges:
            panel.axvspan(*speed_unit().of(ends), zorder=1.5, **UNSTABLE_LOOP)  # above a map, below curves
    return [Patch(label="loop not stable", **UNSTABLE_LOOP)] if ranges else []


def with_frozen(title: str, limits: Limits) -> str:
    """Return a title with a line for each whirl frequency at which frozen coefficients were evaluated."""
    frozen = [item for item in limits if item.whirl_frequency is not None]
    return "\n".join([title, *(f"{', '.join(i.parts)}: {frozen_at(i.whirl_frequency or 0.0)}" for i in frozen)])
