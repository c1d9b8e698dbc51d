"""Figures of the rotor's motion: orbits at the bearings, and their radius over the run."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from amb_cosim.cosim.signals import Signals
from amb_cosim.orbits import radius
from amb_cosim.plots.axes import (
    SITE_COLOURS,
    add_title,
    clearance,
    label_time_axis,
    mark_events,
    plant_signal,
    site_title,
    time_values,
    title_padding,
)
from amb_cosim.plots.style import BLUE, DASHED, GREY, ORANGE, StyledFigure
from amb_cosim.series import BEARINGS, cycles, speed, switched_on

# Colours of the parts of a run.
BEFORE, LOADED, AFTER = GREY, ORANGE, BLUE


def orbits(dataset: Signals) -> Figure:
    """Draw the path of the rotor centre at both bearings and the clearance, coloured by part of the run."""
    figure = StyledFigure(figsize=(7.0, 3.9), layout="constrained")
    limit = 1.1 * max([1e3 * clearance(dataset, site) for site in BEARINGS] + _largest_coordinates(dataset))
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    for panel, (site, mb) in zip(panels, BEARINGS.items(), strict=True):
        x, y = 1e3 * plant_signal(dataset, f"{mb}.x"), 1e3 * plant_signal(dataset, f"{mb}.y")
        angle = np.linspace(0.0, 2.0 * np.pi, 361)
        c = 1e3 * clearance(dataset, site)
        panel.plot(c * np.cos(angle), c * np.sin(angle), color="black", lw=1.0, ls=DASHED, zorder=3, label="clearance")
        for label, colour, within in run_parts(dataset):
            panel.plot(np.where(within, x, np.nan), np.where(within, y, np.nan), color=colour, lw=0.7, label=label)
        panel.set(title=site_title(site), xlabel="$x$ (mm)", xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
        panel.xaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        panel.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
    panels[0].set_ylabel("$y$ (mm)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    add_title(figure, dataset)
    return figure


def displacement(dataset: Signals) -> Figure:
    """Draw radial displacement over clearance at both bearings, and below it the spin speed where it changes."""
    changing = "speed_profile" in dataset.attrs
    figure = StyledFigure(figsize=(7.0, 5.4 if changing else 4.2), layout="constrained")
    ratios = (3, 3, 2) if changing else (1, 1)
    panels = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
    highest = 1.0
    for panel, (site, mb) in zip(panels[:2], BEARINGS.items(), strict=True):
        r = radius(dataset, mb)
        assert r is not None
        relative = r / clearance(dataset, site)
        highest = max(highest, float(relative.max()))
        panel.axhline(1.0, color="black", lw=1.0, ls=DASHED)
        panel.plot(time_values(dataset), relative, color=SITE_COLOURS[site])
        panel.set_title(site_title(site), loc="left", pad=title_padding(dataset, panel is panels[0]))
        panel.set_ylabel("radius / clearance")
        mark_events(panel, dataset, named=panel is panels[0])
    for panel in panels[:2]:
        panel.set_ylim(0.0, 1.05 * highest)
    if changing:
        _draw_speed(panels[2], dataset)
    label_time_axis(panels[-1], dataset)
    add_title(figure, dataset)
    return figure


def _draw_speed(panel: Axes, dataset: Signals) -> None:
    """Draw the spin speed, in rad/s on the left and in Hz on the right."""
    panel.plot(time_values(dataset), speed(dataset), color="black")
    panel.set_title("Spin speed", loc="left")
    panel.set(ylabel=r"$\Omega$ (rad/s)", ylim=(0.0, None))
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


def _largest_coordinates(dataset: Signals) -> list[float]:
    """Return the largest |x| and |y| (mm) at each bearing."""
    return [
        1e3 * float(np.nanmax(np.abs(plant_signal(dataset, f"{mb}.{a}")))) for mb in BEARINGS.values() for a in "xy"
    ]
