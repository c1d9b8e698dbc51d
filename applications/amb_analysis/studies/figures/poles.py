"""Campbell diagram of a levitated machine, and its poles in the s-plane."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_analysis.studies.closed_loop_poles import ClosedLoopPoles, CriticalCrossing
from amb_analysis.studies.damping_zones import ZONES, damping_ratio
from amb_analysis.studies.figures.over_speed import (
    SHADES,
    SIZE,
    WHIRL_STYLES,
    add_legend,
    draw_over_speed,
    draw_zones,
    hatch_extrapolated,
    label_points,
    with_frozen,
)
from amb_analysis.studies.loop_vibrations import LeastDamped
from amb_cosim.presentation.style import DASHED, StyledFigure, write_title
from amb_cosim.presentation.units import frequency_unit, speed_unit

UNSTABLE = "#882255"  # colour of speeds and of the pole where the loop is not stable
AT_RAY = 0.6  # place of the damping ratio on its ray, away from the poles of its ends
PLANE = 4.6  # inches, width of the s-plane


def draw(result: ClosedLoopPoles) -> Figure:
    """Draw the frequencies (with 1x, 2x and the critical speeds), the logarithmic decrements, and the s-plane."""
    vibrations = [(pole.whirl, pole.frequencies, pole.decrements) for pole in result.poles]
    figure = StyledFigure(figsize=(SIZE[0] + PLANE, SIZE[1]), layout="constrained")
    left, right = np.ravel(np.asarray(figure.subfigures(1, 2, width_ratios=(SIZE[0], PLANE))))
    top, bottom = draw_over_speed(left, result.speeds, vibrations, result.operating_speed)
    _mark_criticals(top, result)
    bottom.set_ylabel("logarithmic decrement")
    least = _least_decrement(result)
    draw_zones(bottom, [pole.decrements for pole in result.poles], is_decrement=True, also=least)
    critical = Line2D([], [], color="0.3", ls="", marker="o", ms=3.5, label="mode: critical speed")
    marks: list[Artist] = [critical] if result.critical_speeds else []
    if not all(map(_amplifies, result.critical_speeds)):
        marks.append(
            Line2D([], [], color="0.3", ls="", marker="o", ms=3.5, mfc="white", label="amplification below 2.5")
        )
    marks += _mark_unstable((top, bottom), result)
    marks += hatch_extrapolated((top, bottom), result.speeds, result.limits)
    add_legend(left, vibrations, result.operating_speed, *marks)
    plane = right.subplots()
    _draw_plane(plane, result)
    if result.least_damped is not None and least:
        mark = _mark_least_damped((top, bottom, plane), result.least_damped, least[0])
        right.legend(handles=[mark], loc="outside lower center")
    title = f"{result.scenario}: vibrations of the sampled loop at each speed"
    write_title(figure, with_frozen(title, result.limits))
    return figure


def _mark_criticals(axes: Axes, result: ClosedLoopPoles) -> None:
    """Mark critical speeds, with hollow marks for those that are not critical by API 617 (amplification below 2.5)."""
    unit, points = speed_unit(), []
    for critical in result.critical_speeds:
        at, colour = critical.speed / unit.size, "0.2"
        axes.plot(at, at, "o", ms=3.5, color=colour, mfc=colour if _amplifies(critical) else "white")
        points.append((at, at, f"{critical.mode}: {unit.number(critical.speed)}", colour))
    label_points(axes, points)


def _amplifies(critical: CriticalCrossing) -> bool:
    """Return whether a critical speed has an amplification of 2.5 or more."""
    return critical.decrement < ZONES[-1][0]


def _mark_unstable(panels: Sequence[Axes], result: ClosedLoopPoles) -> list[Line2D]:
    """Draw a bar or a square at the speeds at which the loop is not stable, and return its legend entry."""
    unit = speed_unit()
    style: dict[str, Any] = {"color": UNSTABLE, "lw": 4.0, "marker": "s", "ms": 4.0}
    for axes in panels:
        for ends in result.unstable_ranges:
            axes.plot(unit.of(np.array(ends)), [0.0, 0.0], transform=axes.get_xaxis_transform(), clip_on=False, **style)
    return [Line2D([], [], **style, label="not stable")] if result.unstable else []


def _least_decrement(result: ClosedLoopPoles) -> list[float]:
    """Return a list with the decrement of the least damped vibration; empty unless its damping ratio is in (0, 1)."""
    ratio = 0.0 if result.least_damped is None else result.least_damped.damping_ratio
    return [2.0 * math.pi * ratio / math.sqrt(1.0 - ratio**2)] if 0.0 < ratio < 1.0 else []


def _mark_least_damped(panels: Sequence[Axes], least: LeastDamped, decrement: float) -> Line2D:
    """Mark the least damped vibration in all three plots, at the edge of a plot if the vibration lies outside it."""
    unit, plane = speed_unit(), speed_unit("rad/s")
    style: dict[str, Any] = {"color": "black", "mfc": "none", "ls": "", "ms": 7.0, "clip_on": False, "zorder": 5}
    at, real = least.speed / unit.size, -decrement / (2.0 * math.pi) * least.frequency
    places = ((at, least.frequency / unit.size), (at, decrement), (real / plane.size, least.frequency / plane.size))
    is_beyond = False
    for axes, (x, y) in zip(panels, places, strict=True):
        low, high = axes.get_ylim()
        left, right = axes.get_xlim()
        marker = "^" if y > high else "v" if y < low else "D"
        axes.plot(min(max(x, left), right), min(max(y, low), high), marker, **style)
        is_beyond |= marker != "D"
    drawn, usual = unit.text(least.frequency), frequency_unit().text(least.frequency)
    frequency = drawn if usual == drawn else f"{drawn} ({usual})"
    text = f"least damped: {frequency},\ndecrement {decrement:.2g} at {unit.text(least.speed, 5)}" + (
        " (triangle: outside the plot)" if is_beyond else ""
    )
    return Line2D([], [], marker="D", color="black", mfc="none", ls="", ms=7.0, label=text)


def _draw_plane(axes: Axes, result: ClosedLoopPoles) -> None:
    """Draw the path of each pole over the speeds, a dot at the operating speed, and rays that bound the damping zones.

    A cross marks the pole that grows most; the cross is on the real axis if this pole is a drift without vibration.

    s = omega_d (j - delta / 2 pi), where delta is the decrement, so lines of constant damping ratio are rays from the
    origin.
    """
    unit = speed_unit("rad/s")
    highest, leftmost = 0.0, 0.0
    for pole in result.poles:
        imaginary = unit.of(pole.frequencies)
        real = -pole.decrements / (2.0 * math.pi) * imaginary
        for whirl, (colour, line) in WHIRL_STYLES.items():
            selected = np.array([direction == whirl for direction in pole.whirl])
            axes.plot(np.where(selected, real, np.nan), np.where(selected, imaginary, np.nan), color=colour, ls=line)
            at = int(np.argmin(np.abs(result.speeds - result.operating_speed)))
            if selected[at]:
                axes.plot(real[at], imaginary[at], "o", ms=4.0, color=colour)
        highest = max(highest, float(np.nanmax(imaginary, initial=0.0)))
        leftmost = min(leftmost, float(np.nanmin(real, initial=0.0)))
    rightmost = 0.06 * max(-leftmost, 0.02 * highest)
    if result.unstable:
        worst = result.least_stable
        growth, frequency = unit.of(np.array([worst.growth_rate])), unit.of(np.array([worst.frequency]))
        axes.plot(growth, frequency, "x", ms=6.0, color=UNSTABLE, clip_on=False)
        highest = max(highest, float(frequency[0]))
        reals = [-p.decrements / (2.0 * math.pi) * unit.of(p.frequencies) for p in result.poles]
        rightmost = max(rightmost, 1.1 * max(float(np.nanmax(r, initial=growth[0])) for r in [*reals, growth]))
    axes.set(xlim=(1.08 * leftmost or -1.0, rightmost), ylim=(0.0, 1.08 * highest or 1.0))
    axes.axvspan(0.0, rightmost, color=SHADES[0], lw=0.0, zorder=-2)
    for decrement, _ in ZONES[1:]:
        zeta = damping_ratio(decrement)
        slope = -zeta / math.sqrt(1.0 - zeta**2)
        axes.plot([0.0, slope * 1.08 * highest], [0.0, 1.08 * highest], color="0.6", lw=0.7, ls=DASHED)
        reach = min(1.0, 1.08 * leftmost / (slope * 1.08 * highest)) if highest else 0.0
        axes.text(
            AT_RAY * reach * slope * 1.08 * highest,
            AT_RAY * reach * 1.08 * highest,
            rf"$\zeta$ = {zeta:.2g}",
            fontsize=7,
            color="0.4",
            ha="left",
            va="bottom",
        )
    axes.set(xlabel=f"Re $s$ ({unit.label})", ylabel=f"Im $s$ ({unit.label})")
    axes.set_title(f"Poles; dots: at {speed_unit().text(result.operating_speed, 5)}", loc="left")
