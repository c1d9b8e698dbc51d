"""Sensitivity and Nyquist plot of the levitated rotor."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.ticker import FuncFormatter

from amb_analysis.studies.injection import HIGHEST
from amb_analysis.studies.stability_margin import StabilityMargin
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import BLUE, COLOURS, DASHED, ORANGE, StyledFigure, write_title
from amb_cosim.presentation.units import frequency_label, frequency_text, frequency_unit, spin_text
from array_types import Complex

ZONE_SHADES = {"A": "1.0", "B": "0.95", "C": "0.89", "D": "0.82"}
CURVES, PLANE = 8.0, 5.0  # inches, widths of the curves over frequency and of the Nyquist plot
ROOM = 1.3  # end of the axis of |S| over the largest peak of all axes
LETTER_HEIGHT = 0.1  # of a zone's letter over the axis
STANDARD_ENDS: dict[str, Any] = {"color": "0.45", "lw": 0.7, "ls": DASHED}
AROUND = (1.3, 2.5)  # least and largest half width of the Nyquist plot, about -1


def draw(result: StabilityMargin) -> Figure:
    """Draw the computed and measured |S| of each axis with the zones of ISO 14839-3, and L with the zones' circles."""
    rows = (len(result.axes) + 1) // 2
    whole = StyledFigure(figsize=(CURVES + PLANE, 1.2 + 2.5 * (rows + 1)), layout="constrained")
    figure, right = np.ravel(np.asarray(whole.subfigures(1, 2, width_ratios=(CURVES, PLANE))))
    panels = figure.subplots(rows + 1, 2, sharex=True, squeeze=False)
    for axes, name in zip(panels.flat, result.axes, strict=False):
        _draw_zones(axes, result.zone_limits)
        _draw_sensitivity(axes, result, name)
    for unused in panels.flat[len(result.axes) : 2 * rows]:
        unused.set_axis_off()
    for first in panels[:-1, 0]:
        first.set_ylabel("sensitivity |S|")
    for last in panels[-1]:
        last.set_xlabel(frequency_label())
    _draw_all_loops(panels[-1], result)
    delay = f", {result.delay:g} sample{'s' * (result.delay != 1.0)} of delay" if result.delay else ""
    handles = [
        Line2D([], [], color=BLUE, label="computed from the sampled linear loop"),
        Line2D([], [], color=ORANGE, ls="", marker="o", ms=3, label="measured in the co-simulation"),
    ]
    if result.frequencies[-1] > HIGHEST:
        handles.append(Line2D([], [], **STANDARD_ENDS, label=f"{frequency_text(HIGHEST)}, upper limit of ISO 14839-3"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    _draw_nyquist(right.subplots(), result)
    write_title(
        whole,
        f"{result.rotor}: sensitivity at {spin_text(result.speed)}, sampled every {1e6 * result.sample_time:g} µs, "
        f"{result.amplifier} amplifiers{delay}",
    )
    return whole


def _draw_nyquist(axes: Axes, result: StabilityMargin) -> None:
    """Draw L = 1/S - 1 of each axis. The distance of L from -1 is 1/|S|; the circles are the limits of the zones."""
    farthest = max(float(np.abs(axis.L + 1.0).max()) for axis in result.axes.values())
    around = float(np.clip(1.1 * farthest, *AROUND))
    for (name, limit), shade in zip(result.zone_limits.items(), list(ZONE_SHADES.values())[1:], strict=True):
        axes.add_patch(Circle((-1.0, 0.0), 1.0 / limit, facecolor=shade, edgecolor="0.45", lw=0.7, ls=DASHED))
        axes.annotate(
            f"end of {name}: |S| = {limit:g}",
            (-1.0, 1.0 / limit),
            (-0.5, (0.9 - 0.11 * limit) * around),
            fontsize=7,
            color="0.3",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
            arrowprops={"arrowstyle": "-", "lw": 0.5, "color": "0.45", "shrinkB": 0.0},
        )
    axes.plot(-1.0, 0.0, "+", ms=7, color="black")
    for (name, axis), colour in zip(result.axes.items(), cycle(COLOURS), strict=False):
        at = int(np.argmax(axis.computed))
        label = f"{name}: nearest at {frequency_text(result.frequencies[at], 3)}"
        style: Any = DASHED if name.endswith("y") else "-"
        axes.plot(axis.L.real, axis.L.imag, color=colour, ls=style, lw=0.9, label=label)
        nearest = axis.L[at]
        axes.plot(nearest.real, nearest.imag, "o", ms=3.5, color=colour)
        _draw_direction(axes, axis.L, around, colour)
    axes.set(
        title="Nyquist plot, other axes closed",
        xlabel="real part of L",
        ylabel="imaginary part of L",
        aspect="equal",
        xlim=(-1.0 - around, -1.0 + around),
        ylim=(-around, around),
    )
    axes.axhline(0.0, color="0.85", lw=0.6, zorder=0)
    axes.axvline(0.0, color="0.85", lw=0.6, zorder=0)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)


def _draw_direction(axes: Axes, L: Complex, around: float, colour: str) -> None:
    """Draw an arrow towards higher frequencies, at the point of a curve within the plot that is farthest from -1."""
    distance = np.where(np.abs(L + 1.0) < 0.9 * around, np.abs(L + 1.0), 0.0)
    distance = np.minimum(distance[:-1], distance[1:])
    if distance.any():
        k = int(np.argmax(distance))
        begin, end = ((float(value.real), float(value.imag)) for value in L[k : k + 2])
        axes.annotate("", end, begin, arrowprops={"arrowstyle": "->", "color": colour, "lw": 0.9})


def _draw_all_loops(panels: Sequence[Axes], result: StabilityMargin) -> None:
    """Draw the largest singular values of S and T, and the disk margins for all loops at once."""
    gang, frequencies = result.gang_of_four, frequency_unit().of_hertz(result.frequencies)
    for label, curve, colour in (("S", gang.S, BLUE), ("T", gang.T, ORANGE)):
        panels[0].loglog(frequencies, curve, color=colour, lw=0.8, label=label)
    for (place, margin), (colour, width) in zip(result.disk_margins.items(), ((BLUE, 2.4), (ORANGE, 0.8)), strict=True):
        label = f"at the {place}: {margin.least:.2f}, {margin.phase:.0f} deg"
        panels[1].semilogx(frequencies, np.minimum(margin.alpha, 2.5), color=colour, lw=width, label=label)
    panels[0].set(ylabel="largest singular value", title="all loops")
    panels[1].set(ylabel="disk margin", ylim=(0.0, 2.5), title="all loops at once")
    for axes in panels:
        axes.legend(loc="best")


def _draw_zones(axes: Axes, zone_limits: dict[str, float]) -> None:
    """Shade the zones of ISO 14839-3."""
    limits = [0.0, *zone_limits.values(), 1e6]
    for low, high, (name, shade) in zip(limits[:-1], limits[1:], ZONE_SHADES.items(), strict=True):
        axes.axhspan(low, high, color=shade, lw=0.0)
        if name != "D":
            axes.axhline(high, color="0.45", lw=0.7, ls=DASHED)


def _draw_sensitivity(axes: Axes, result: StabilityMargin, name: str) -> None:
    """Draw the computed curve of an axis, and some measured values that are evenly spaced on the logarithmic axis."""
    unit, axis = frequency_unit(), result.axes[name]
    frequencies, lines = unit.of_hertz(result.frequencies), unit.of_hertz(axis.measured_frequencies)
    values = axis.measured
    marked = np.unique(np.searchsorted(lines, np.geomspace(lines[0], lines[-1], 150)).clip(0, len(lines) - 1))
    axes.semilogx(lines[marked], values[marked], "o", color=ORANGE, ms=2.6)
    axes.semilogx(frequencies, axis.computed, color=BLUE, lw=0.8)
    top = ROOM * max(float(max(o.computed.max(), o.measured.max())) for o in result.axes.values())
    if result.frequencies[-1] > HIGHEST:
        axes.axvline(float(unit.of_hertz(HIGHEST)), **STANDARD_ENDS)
    axes.set(xlim=(frequencies[0], frequencies[-1]), ylim=(0.0, top))
    peak = f"{axis.peak:.2f} at {frequency_text(axis.peak_frequency)}, zone {axis.zone}"
    bearing, _, direction = name.rpartition(".")
    axes.set_title(f"{name_label(bearing)}, {direction} axis: {peak}")
    ends = [0.0, *result.zone_limits.values(), np.inf]
    for letter, low, high in zip(ZONE_SHADES, ends[:-1], ends[1:], strict=True):
        if min(high, top) - low > LETTER_HEIGHT * top:
            style: Any = {"ha": "right", "va": "top", "color": "0.3"}
            axes.text(0.99, min(high, top) - 0.02 * top, letter, transform=axes.get_yaxis_transform(), **style)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.9g}"))
