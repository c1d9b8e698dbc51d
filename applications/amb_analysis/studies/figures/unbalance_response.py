"""Bode and polar plots of a rotor or a levitated machine under unbalance."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator, MultipleLocator

from amb_analysis.studies.figures.over_speed import BOX, hatch_extrapolated, shade_unstable, with_frozen
from amb_analysis.studies.unbalance_records import UnbalanceResponse, amplification_text
from amb_cosim.presentation.style import COLOURS, DASHED, GREY, StyledFigure, write_title
from amb_cosim.presentation.units import ShownUnit, length_unit, speed_unit, spin_label

BODE, POLAR = 7.0, 4.8  # inches, widths
BACKWARD = "#DCE9F5"
BEYOND = 1.12  # highest speed of the axis over the last one at which the loop is stable
HEADROOM = 8.0  # upper end of a logarithmic axis over the largest value, with room for labels of critical speeds
FLOOR = 1e-3  # lower end of a logarithmic axis, over the largest amplitude


def draw(result: UnbalanceResponse) -> Figure:
    """Draw amplitude (with clearances, critical speeds, margins and backward whirl), phase, and a polar plot."""
    whole = StyledFigure(figsize=(BODE + POLAR, 5.4), layout="constrained")
    figure, right = np.ravel(np.asarray(whole.subfigures(1, 2, width_ratios=(BODE, POLAR))))
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    speeds = speed_unit().of(result.speeds)
    largest = max((float(p.amplitude.max(initial=0.0)) for p in result.places.values()), default=0.0)
    unit = length_unit(largest)
    for (label, place), colour in zip(result.places.items(), cycle(COLOURS), strict=False):
        top.plot(speeds, unit.of(place.amplitude), color=colour, label=label)
        bottom.plot(speeds, np.degrees(place.phase), color=colour)
    top.grid(axis="y", color="0.9", lw=0.6)
    top.set(ylabel=f"amplitude ({unit.label})", xlim=(0.0, BEYOND * speeds[-1] if result.stable_up_to else speeds[-1]))
    clearances = _clearances(result)
    highest = max([largest, *clearances])
    if result.scenario and largest > 0.0:
        top.set_yscale("log")
        top.set_ylim(FLOOR * largest / unit.size, HEADROOM * highest / unit.size)
    else:
        top.set_ylim(0.0, 1.35 * highest / unit.size)
    if clearances:
        _mark_clearances(top, clearances, unit)
    _mark_speeds(top, bottom, result, unit)
    bottom.set(ylabel="phase (deg)", xlabel=spin_label())
    bottom.yaxis.set_major_locator(MultipleLocator(90.0))
    bottom.grid(axis="y", color="0.9", lw=0.6)
    curves = top.get_legend_handles_labels()[0]
    hatched = hatch_extrapolated((top, bottom), result.speeds, result.limits)
    shaded = _shade_backward((top, bottom), result)
    if result.stable_up_to is not None:
        shaded += shade_unstable((top, bottom), [(result.stable_up_to, BEYOND * result.speeds[-1])])
    operating = _operating(result, unit)
    figure.legend(handles=[*curves, *operating, *hatched, *shaded], loc="outside lower center", ncols=3)
    _draw_polar(right.add_subplot(projection="polar"), result, unit)
    title = f"{result.scenario or result.rotor}: steady response to {result.load}"
    write_title(whole, with_frozen(title, result.limits))
    return whole


def _mark_clearances(axes: Axes, clearances: dict[float, list[str]], unit: ShownUnit) -> None:
    """Draw the clearances, and name them in one box below the lowest clearance, where no line passes."""
    for clearance in clearances:
        axes.axhline(clearance / unit.size, color="black", lw=0.9, ls=DASHED)
    ascending = sorted(clearances.items())
    text = "\n".join(f"clearance {unit.text(gap, 3)}: {', '.join(names)}" for gap, names in reversed(ascending))
    style: dict[str, Any] = {"textcoords": "offset points", "fontsize": 7.5, "va": "top", "bbox": BOX}
    axes.annotate(text, (0.005, ascending[0][0] / unit.size), (0, -2), xycoords=("axes fraction", "data"), **style)


def _shade_backward(panels: Sequence[Axes], result: UnbalanceResponse) -> list[Patch]:
    """Shade the speeds at which any part of the rotor whirls backward under unbalance, and return the legend entry."""
    size = speed_unit().size
    ranges = {ends for place in result.places.values() for ends in place.backward(result.speeds)}
    for axes in panels:
        for low, high in ranges:
            axes.axvspan(low / size, high / size, color=BACKWARD, lw=0.0, zorder=-1)
    return [Patch(color=BACKWARD, label="backward whirl")] if ranges else []


def _mark_speeds(top: Axes, bottom: Axes, result: UnbalanceResponse, unit: ShownUnit) -> None:
    """Mark the operating speed and the critical speeds, with amplification and margin."""
    speed = speed_unit()
    if result.operating_speed is not None:
        for axes in (top, bottom):
            axes.axvline(result.operating_speed / speed.size, color=GREY, lw=1.2, zorder=0)
    for k, item in enumerate(result.critical_speeds):
        at = item.speed / speed.size
        for axes in (top, bottom):
            axes.axvline(at, color="0.6", lw=0.7, ls=":", zorder=0)
        top.plot(at, item.amplitude / unit.size, "o", ms=3.5, color="0.2", zorder=4)
        text = f"{speed.text(item.speed)}, AF {amplification_text(item)}"
        if item.margin is not None:
            required = item.required_margin(result.operating_speed or 0.0)
            text += f", margin {item.margin:.0f} %" + ("" if required is None else f" ({required:.0f} % required)")
        style: dict[str, Any] = {"fontsize": 7.0, "color": "0.2", "bbox": BOX, "zorder": 5}
        side = "left" if at < 0.6 * top.get_xlim()[1] else "right"
        shift = (4 if side == "left" else -4, -9 * (k % 3))
        place = (at, 0.985)
        top.annotate(
            text,
            place,
            shift,
            textcoords="offset points",
            xycoords=top.get_xaxis_transform(),
            ha=side,
            va="top",
            **style,
        )


def _operating(result: UnbalanceResponse, unit: ShownUnit) -> list[Line2D]:
    """Return the legend entry of the operating speed, with the smallest and the largest amplitude there."""
    speed = result.operating_speed
    if speed is None:
        return []
    label = f"operating speed, {speed_unit().text(speed, 5)}"
    if result.places and result.speeds[0] <= speed <= result.speeds[-1]:
        values = [float(np.interp(speed, result.speeds, p.amplitude)) / unit.size for p in result.places.values()]
        ends = dict.fromkeys(f"{value:.2g}" for value in (min(values), max(values)))
        label += f": {' to '.join(ends)} {unit.label}"
    return [Line2D([], [], color=GREY, lw=1.2, label=label)]


def _draw_polar(axes: Any, result: UnbalanceResponse, unit: ShownUnit) -> None:
    """Draw amplitude against phase, counterclockwise from the unbalance, with critical and operating speeds.

    Amplitudes of a levitated machine have a logarithmic scale, as in the Bode plot.
    """
    largest = max((float(p.amplitude.max(initial=0.0)) for p in result.places.values()), default=0.0) / unit.size
    is_logarithmic = bool(result.scenario) and largest > 0.0
    if is_logarithmic:
        axes.set_rscale("log")
    for place, colour in zip(result.places.values(), cycle(COLOURS), strict=False):
        axes.plot(place.phase, unit.of(place.amplitude), color=colour)
        for item in result.critical_speeds:
            at = int(np.argmin(np.abs(result.speeds - item.speed)))
            axes.plot(place.phase[at], place.amplitude[at] / unit.size, "o", ms=2.5, color="0.2")
        if result.operating_speed is not None:
            at = int(np.argmin(np.abs(result.speeds - result.operating_speed)))
            axes.plot(place.phase[at], place.amplitude[at] / unit.size, "s", ms=3.5, color=colour)
    if is_logarithmic:
        axes.set_rlim(FLOOR * largest, 1.5 * largest)
    else:
        axes.set_rmin(0.0)
        axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.grid(color="0.88", lw=0.6)
    handles = [Line2D([], [], color="0.2", ls="", marker="o", ms=2.5, label="critical speed")]
    if result.operating_speed is not None:
        handles.append(Line2D([], [], color="0.4", ls="", marker="s", ms=3.5, label="operating speed"))
    title = f"amplitude ({unit.label}) against phase"
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=2, title=title)


def _clearances(result: UnbalanceResponse) -> dict[float, list[str]]:
    """Return the names of the places for each clearance (m)."""
    places_by_clearance: dict[float, list[str]] = {}
    for name, place in result.places.items():
        if place.clearance is not None:
            places_by_clearance.setdefault(place.clearance, []).append(name)
    return places_by_clearance
