"""Amplitude and phase of a rotor under unbalance."""

from __future__ import annotations

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from amb_cosim.presentation.style import BLUE, DASHED, GREEN, ORANGE, PURPLE, SKY_BLUE, TITLE_SIZE, YELLOW, StyledFigure
from amb_cosim.presentation.units import length_unit, speed_unit, spin_label
from amb_cosim.studies.unbalance_over_speed import UnbalanceResponse

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY_BLUE, YELLOW)


def draw(result: UnbalanceResponse) -> Figure:
    """Draw amplitude, with the clearances, and phase over the spin speed."""
    figure = StyledFigure(figsize=(7.0, 5.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    speeds = speed_unit().of(result.speeds)
    unit = length_unit(max((float(p.amplitude.max(initial=0.0)) for p in result.places.values()), default=0.0))
    for (label, place), colour in zip(result.places.items(), cycle(COLOURS), strict=False):
        top.plot(speeds, unit.of(place.amplitude), color=colour, label=label)
        bottom.plot(speeds, np.degrees(place.phase), color=colour)
    for clearance, places in _clearances(result).items():
        top.axhline(clearance / unit.size, color="black", lw=0.9, ls=DASHED)
        text = f"clearance {unit.text(clearance, 3)}: {', '.join(places)}"
        top.annotate(text, (speeds[0], clearance / unit.size), (3, 2), textcoords="offset points", fontsize=7.5)
    top.set(ylabel=f"amplitude ({unit.label})", ylim=(0.0, None), xlim=(0.0, speeds[-1]))
    bottom.set(ylabel="phase (deg)", xlabel=spin_label())
    bottom.yaxis.set_major_locator(MultipleLocator(90.0))
    bottom.grid(axis="y", color="0.9", lw=0.6)
    figure.legend(loc="outside lower center", ncols=3)
    title = f"{result.rotor}: steady response to {1e3 * result.unbalance:.4g} g m at node {result.node}"
    figure.suptitle(title, fontsize=TITLE_SIZE)
    return figure


def _clearances(result: UnbalanceResponse) -> dict[float, list[str]]:
    """Return the places of each clearance (m)."""
    matches: dict[float, list[str]] = {}
    for name, place in result.places.items():
        if place.clearance is not None:
            matches.setdefault(place.clearance, []).append(name)
    return matches
