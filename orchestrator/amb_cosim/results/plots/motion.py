"""Figures of the rotor's motion: orbits at bearings and other sites touched, and their radius over the run."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from amb_cosim.cosim.signals import Signals
from amb_cosim.presentation.style import BLUE, DASHED, GREY, ORANGE, StyledFigure, set_orbit_axes
from amb_cosim.results.plots.axes import (
    Station,
    add_title,
    clearance,
    colour_of,
    label_time_axis,
    mark_events,
    stations,
    time_values,
    title_padding,
)
from amb_cosim.results.series import cycles, speed, speed_changes, switched_on

# Colours of the parts of a run.
BEFORE, LOADED, AFTER = GREY, ORANGE, BLUE


def orbits(dataset: Signals) -> Figure:
    """Draw the path of the rotor centre at each station and the clearance, coloured by part of the run."""
    drawn = stations(dataset)
    clearances = [1e3 * clearance(dataset, station.site) for station in drawn if station.site]
    limit = 1.1 * max(clearances + _largest_coordinates(dataset, drawn))
    figure = StyledFigure(figsize=(max(3.5 * len(drawn), 4.5), 3.9), layout="constrained")
    panels = figure.subplots(1, len(drawn), sharex=True, sharey=True, squeeze=False)[0]
    for panel, station in zip(panels, drawn, strict=True):
        x, y = 1e3 * station.path(dataset)
        angle = np.linspace(0.0, 2.0 * np.pi, 361)
        if station.site:
            c = 1e3 * clearance(dataset, station.site)
            circle = {"color": "black", "lw": 1.0, "ls": DASHED, "zorder": 3, "label": "clearance"}
            panel.plot(c * np.cos(angle), c * np.sin(angle), **circle)
        for label, colour, within in run_parts(dataset):
            panel.plot(np.where(within, x, np.nan), np.where(within, y, np.nan), color=colour, lw=0.7, label=label)
        set_orbit_axes(panel, station.title, limit)
    panels[0].set_ylabel("$y$ (mm)")
    with_clearance = next((k for k, station in enumerate(drawn) if station.site), 0)
    handles, labels = panels[with_clearance].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    add_title(figure, dataset)
    return figure


def displacement(dataset: Signals) -> Figure:
    """Draw the radius of the motion at each station, over its clearance, and below it the speed where it changes."""
    drawn, changing = stations(dataset), speed_changes(dataset)
    figure = StyledFigure(figsize=(7.0, 2.1 * len(drawn) + 1.2 * changing), layout="constrained")
    ratios = (3,) * len(drawn) + (2,) * changing
    panels = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios, squeeze=False)[:, 0]
    highest = 1.0
    for panel, station in zip(panels, drawn, strict=False):
        r = np.hypot(*station.path(dataset))
        panel.set_title(station.title, loc="left", pad=title_padding(dataset, panel is panels[0]))
        mark_events(panel, dataset, named=panel is panels[0])
        if not station.site:
            panel.plot(time_values(dataset), 1e3 * r, color="black")
            panel.set(ylabel="radius (mm)", ylim=(0.0, None))
            continue
        relative = r / clearance(dataset, station.site)
        highest = max(highest, float(relative.max()))
        panel.axhline(1.0, color="black", lw=1.0, ls=DASHED)
        panel.plot(time_values(dataset), relative, color=colour_of(dataset, station.site))
        panel.set_ylabel("radius / clearance")
    for panel, station in zip(panels, drawn, strict=False):
        if station.site:
            panel.set_ylim(0.0, 1.05 * highest)
    if changing:
        _draw_speed(panels[-1], dataset)
    label_time_axis(panels[-1], dataset)
    add_title(figure, dataset)
    return figure


def _draw_speed(panel: Axes, dataset: Signals) -> None:
    """Draw the spin speed, in rad/s on the left and in Hz on the right."""
    panel.plot(time_values(dataset), speed(dataset), color="black")
    panel.set_title("Spin speed", loc="left")
    panel.set(ylabel=r"$\Omega$ (rad/s)", ylim=(0.0, 1.08 * float(speed(dataset).max(initial=0.0)) or None))
    turn = 2.0 * np.pi
    turns = panel.secondary_yaxis("right", functions=(lambda s: np.divide(s, turn), lambda f: np.multiply(f, turn)))
    turns.set_ylabel(r"$\Omega/2\pi$ (Hz)")
    turns.spines["right"].set_visible(True)
    mark_events(panel, dataset, named=False)


def run_parts(dataset: Signals) -> list[tuple[str, str, NDArray[np.bool_]]]:
    """Return name, colour and samples of the parts of a run: before the step, with the step, after its removal.

    A run without step and removal is divided where ROLAC is switched on, if it is. Neighbouring parts share a sample.
    """
    cycle = cycles(dataset)
    step, removal = dataset.attrs.get("step_cycle"), dataset.attrs.get("removal_cycle")
    if step is None and removal is None:
        begin = switched_on(dataset)
        if begin is None:
            return [("run", AFTER, np.ones(len(cycle), dtype=bool))]
        return [("before ROLAC", BEFORE, cycle <= begin), ("with ROLAC", AFTER, cycle >= begin)]
    begin, end = (-np.inf if step is None else step), (np.inf if removal is None else removal)
    loaded = "with the unbalance" if step is None else "with the added unbalance"
    parts = [
        ("before the step", BEFORE, cycle <= begin),
        (loaded, LOADED, (cycle >= begin) & (cycle <= end)),
        ("after its removal", AFTER, cycle >= end),
    ]
    return [part for part, bound in zip(parts, (step, True, removal), strict=True) if bound is not None]


def _largest_coordinates(dataset: Signals, drawn: list[Station]) -> list[float]:
    """Return the largest |x| and |y| (mm) at each station."""
    return [1e3 * float(np.nanmax(np.abs(station.path(dataset)))) for station in drawn]
