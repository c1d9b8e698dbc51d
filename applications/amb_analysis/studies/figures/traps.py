"""Response over speed, including its folds, and the map of traps over speed and unbalance."""

from __future__ import annotations

import math
from itertools import cycle
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from amb_analysis.steady_contact.branches import branches
from amb_analysis.studies.contact_traps import WIDE, Traps
from amb_analysis.studies.figures.over_speed import shade_unstable
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import (
    BLUE,
    DASHED,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY_BLUE,
    YELLOW,
    StyledFigure,
    write_title,
)
from amb_cosim.presentation.units import force_unit, speed_unit, spin_label
from array_types import Array

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY_BLUE, YELLOW)
FREE, BOTH, CONTACT, WHIRL = "#FFFFFF", "#F6D98B", "#E08E5B", "#C9C9D6"
WORD_WIDTH, WORD_SHAPE = 0.014, 2.0  # of a letter over the map's width; width over height of the words of an area
ALIKE = 0.95  # of the largest room for a word, of places that have as much; the middle one is chosen
WORD_LENGTH = 10  # letters of a line of them
ORBITS = (1.2, 2.0)  # least and largest end of the axis of orbits
BACKED: dict[str, Any] = {"frameon": True, "framealpha": 0.8, "edgecolor": "none"}  # of a legend that lines cross
DECADE = 10.0  # least ratio of the ends of the axis of forces
POINT = 0.02  # of the axis of speeds; states within it are drawn as points, since a line would not be seen
INSIDE = 6  # most entries of a legend inside the panel
NO_CONTACT = "no steady contact at this unbalance, at any of these speeds"
LABELS = ("free", "free or in contact", "in contact", "unsteady rub")


def draw(result: Traps) -> Figure:
    """Draw orbits and forces over speed on the left, and the map with the machine's point on the right."""
    figure = StyledFigure(figsize=(10.0, 5.4), layout="constrained")
    touches = any(len(states.speed) for states in result.curves.states[1:]) or any(s.contact for s in result.states)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.15))
    top = figure.add_subplot(grid[0 if touches else slice(None), 0])
    _draw_orbits(top, result)
    if touches:
        _draw_forces(figure.add_subplot(grid[1, 0], sharex=top), result)
        top.tick_params(labelbottom=False)
    else:
        top.set(xlabel=spin_label(), title=NO_CONTACT)
    _draw_map(figure.add_subplot(grid[:, 1]), result)
    unbalance = f"{1e3 * result.unbalance:.4g} g m"
    write_title(figure, f"{result.scenario}: where the rotor can stay in contact; curves at {unbalance}")
    return figure


def unstable_ranges(result: Traps) -> list[tuple[float, float]]:
    """Return the ranges of speed (rad/s) in which the loop is not stable without contact."""
    speeds, free = result.curves.speeds, result.curves.states[0]
    unstable = np.array([dynamics.free_growth >= 0.0 for dynamics in free.dynamics])
    changes = np.flatnonzero(np.diff(np.pad(unstable, 1).astype(int))).reshape(-1, 2)
    return [(float(speeds[first]), float(speeds[end - 1])) for first, end in changes]


def _draw_orbits(panel: Axes, result: Traps) -> None:
    """Draw the ratio of each contact-free orbit to the clearance, dotted above 1 and where the loop is not stable."""
    free, speeds = result.curves.states[0], speed_unit().of(result.curves.speeds)
    unstable = unstable_ranges(result)
    for k, (site, colour) in enumerate(zip(result.sites, cycle(COLOURS), strict=False)):
        share = result.orbits[:, k] / result.clearances[k]
        exists = np.isin(np.arange(len(speeds)), free.speed)
        for first, last in unstable:
            exists &= (result.curves.speeds < first) | (result.curves.speeds > last)
        panel.plot(speeds, np.where(exists, share, np.nan), color=colour, lw=1.8, label=name_label(site))
        panel.plot(speeds, np.where(exists, np.nan, share), color=colour, ls=":")
    panel.axhline(1.0, color="black", lw=0.8, ls=DASHED)
    panel.axvline(result.speed / speed_unit().size, color="0.6", lw=0.7)
    top = float(np.clip(1.2 * np.nanmax(result.orbits / result.clearances, initial=0.0), *ORBITS))
    panel.set(ylabel="orbit without contact / clearance", ylim=(0.0, top))
    panel.set_xlim(0.0, speeds[-1])
    shade_unstable([panel], unstable)
    handles = panel.get_legend_handles_labels()[0]
    handles.append(Line2D([], [], color="0.3", ls=":", label="would touch" + " or not stable" * bool(unstable)))
    panel.legend(handles=[*handles, _operating(result)], loc="best", ncols=2, **BACKED)


def _operating(result: Traps) -> Line2D:
    """Return the legend entry of the line at the scenario's speed."""
    return Line2D([], [], color="0.6", lw=0.7, label=f"at {speed_unit().text(result.speed, 5)}")


def _draw_forces(panel: Axes, result: Traps) -> None:
    """Draw the sum of normal forces of each state in contact: thick if stable, thin and dashed if unstable."""
    speeds, at = speed_unit().of(result.curves.speeds), result.speed / speed_unit().size
    totals = [states.N.sum(axis=1) for states in result.curves.states[1:]]
    unit = force_unit(max((float(total.max()) for total in totals if len(total)), default=0.0))
    colours = cycle(COLOURS)
    for states, total_force in zip(result.curves.states[1:], totals, strict=True):
        colour = next(colours)
        if not len(states.speed):
            continue
        total, stable = unit.of(total_force), states.stable
        is_point = np.ptp(states.speed) <= POINT * len(speeds)
        for branch in branches(states, len(speeds)):
            for piece, is_stable in _pieces(branch, stable):
                line: dict[str, Any] = {"lw": 1.8} if is_stable else {"lw": 0.8, "ls": (0, (3, 1.5))}
                line |= {"marker": "."} if is_point else {}
                panel.plot(speeds[states.speed[piece]], total[piece], color=colour, **line)
        label = "+".join(name_label(result.sites[k]) for k in states.contact)
        panel.plot([], [], color=colour, label=label)
    for state in result.states:
        if state.contact:
            fill = "black" if state.stable else "white"
            panel.plot(at, sum(state.normal_forces.values()) / unit.size, "o", ms=4, mec="black", mfc=fill, zorder=4)
    panel.axvline(result.speed / speed_unit().size, color="0.6", lw=0.7)
    panel.set(xlabel=spin_label(), ylabel=f"sum of normal contact forces ({unit.label})", xlim=(0.0, speeds[-1]))
    panel.set_yscale("log")
    low, high = panel.get_ylim()
    if high < DECADE * low:
        middle = math.sqrt(low * high)
        panel.set_ylim(middle / math.sqrt(DECADE), middle * math.sqrt(DECADE))
    styles = [Line2D([], [], color="black", lw=1.8, label="stable")]
    styles.append(Line2D([], [], color="black", lw=0.8, ls=(0, (3, 1.5)), label="unstable"))
    handles = [*panel.get_legend_handles_labels()[0], *styles]
    if len(handles) <= INSIDE:
        panel.legend(handles=handles, loc="upper left", ncols=2, **BACKED)
    else:
        panel.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=4)


def _pieces(branch: list[int], stable: np.ndarray) -> list[tuple[list[int], bool]]:
    """Return a branch, divided into stable and unstable pieces that join each other."""
    pieces: list[tuple[list[int], bool]] = []
    for number in branch:
        if pieces and pieces[-1][1] == stable[number]:
            pieces[-1][0].append(number)
        else:
            if pieces:
                pieces[-1][0].append(number)
            pieces.append(([number], bool(stable[number])))
    return pieces


def _name_areas(panel: Axes, result: Traps, speeds: Array, amounts: Array) -> set[int]:
    """Write the word for each kind into the largest circle within its area, and return the kinds whose word fits."""
    from scipy.ndimage import distance_transform_edt  # slow to import

    named, aspect = set(), result.kinds.shape[0] / result.kinds.shape[1]
    star = (
        int(np.argmin(np.abs(result.speeds - result.speed))),
        int(np.argmin(np.abs(amounts - 1e3 * result.unbalance))),
    )
    for kind, word in enumerate(LABELS):
        area = np.pad(result.kinds == kind, 1)
        area[star[0] + 1, star[1] + 1] = False  # the machine's mark
        room = distance_transform_edt(area, sampling=(1.0 / WORD_SHAPE, aspect))[1:-1, 1:-1]
        widest = np.argwhere(room >= ALIKE * room.max())
        k, m = widest[np.square(widest - widest.mean(axis=0)).sum(axis=1).argmin()]
        lines = wrap(word, WORD_LENGTH)
        if room[k, m] * WORD_SHAPE > 0.5 * WORD_WIDTH * max(map(len, lines)) * len(speeds):
            panel.text(speeds[k], amounts[m], "\n".join(lines), ha="center", va="center", fontsize=8)
            named.add(kind)
    return named


def _draw_map(panel: Axes, result: Traps) -> None:
    amounts = 1e3 * result.unbalances
    colours = (FREE, BOTH, CONTACT, WHIRL)
    unit = speed_unit()
    speeds, at = unit.of(result.speeds), (result.speed / unit.size, 1e3 * result.unbalance)
    panel.pcolormesh(
        speeds,
        amounts,
        result.kinds.T,
        cmap=ListedColormap(colours),
        vmin=-0.5,
        vmax=3.5,
        shading="nearest",
    )
    panel.plot(
        *at,
        marker="*",
        ms=13,
        mfc="black",
        mec="white",
        ls="none",
        zorder=5,
    )
    panel.plot(speeds, 1e3 * result.grade_limit, color="black", lw=0.9, ls=DASHED)
    if amounts[-1] > WIDE * at[1]:
        panel.set_yscale("log")
    grade = Line2D([], [], color="black", lw=0.9, ls=DASHED, label="limit of G 2.5")
    named = _name_areas(panel, result, speeds, amounts)
    occurring = np.unique(result.kinds)
    patches = [
        Patch(fc=colour, ec=GREY, label=label)
        for kind, (colour, label) in enumerate(zip(colours, LABELS, strict=True))
        if kind in occurring and kind not in named
    ]
    patches += shade_unstable([panel], unstable_ranges(result))
    star = Line2D([], [], marker="*", ms=10, mfc="black", mec="white", ls="none", label="the machine")
    panel.legend(
        handles=[*patches, star, grade], loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3, handlelength=1.2
    )
    panel.set(xlabel=spin_label(), ylabel="unbalance (g m)")
    panel.set(xlim=(speeds[0], speeds[-1]), ylim=(amounts[0], amounts[-1]))
