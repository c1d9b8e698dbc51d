"""Where the rotor goes: orbits at the bearings, and their radius over the run."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from amb_cosim.orbits import radius
from amb_cosim.plots.axes import (
    BLUE,
    GREY,
    ORANGE,
    SITE_COLOURS,
    abscissa,
    clearance,
    headline,
    label_abscissa,
    mark,
    plant,
    title_pad,
    titled,
)
from amb_cosim.series import BEARINGS, cycles, speed, switched_on

BEFORE, LOADED, REMOVED = GREY, ORANGE, BLUE


def orbits(dataset: xr.Dataset) -> Figure:
    """Path of the rotor centre at both bearings within the clearance, before, during and after the load."""
    figure = Figure(figsize=(7.0, 3.9), layout="constrained")
    limit = 1.1 * max([1e3 * clearance(dataset, site) for site in BEARINGS] + _largest_coordinates(dataset))
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for axis, (site, mb) in zip(axes, BEARINGS.items(), strict=True):
        x, y = 1e3 * plant(dataset, f"{mb}.x"), 1e3 * plant(dataset, f"{mb}.y")
        angle = np.linspace(0.0, 2.0 * np.pi, 361)
        c = 1e3 * clearance(dataset, site)
        axis.plot(
            c * np.cos(angle), c * np.sin(angle), color="black", lw=1.0, ls=(0, (4, 2)), zorder=3, label="clearance"
        )
        for label, colour, within in phases(dataset):
            axis.plot(np.where(within, x, np.nan), np.where(within, y, np.nan), color=colour, lw=0.7, label=label)
        axis.set(title=titled(site), xlabel="$x$ (mm)", xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
        axis.xaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        axis.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
    axes[0].set_ylabel("$y$ (mm)")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    headline(figure, dataset)
    return figure


def displacement(dataset: xr.Dataset) -> Figure:
    """Radial displacement over clearance at both bearings; below it the speed, where it changes."""
    changing = "speed_profile" in dataset.attrs
    figure = Figure(figsize=(7.0, 5.4 if changing else 4.2), layout="constrained")
    ratios = (3, 3, 2) if changing else (1, 1)
    axes = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
    highest = 1.0
    for axis, (site, mb) in zip(axes[:2], BEARINGS.items(), strict=True):
        r = radius(dataset, mb)
        assert r is not None
        relative = r / clearance(dataset, site)
        highest = max(highest, float(relative.max()))
        axis.axhline(1.0, color="black", lw=1.0, ls=(0, (4, 2)))
        axis.plot(abscissa(dataset), relative, color=SITE_COLOURS[site])
        axis.set_title(titled(site), loc="left", pad=title_pad(dataset, axis is axes[0]))
        axis.set_ylabel("radius / clearance")
        mark(axis, dataset, named=axis is axes[0])
    for axis in axes[:2]:
        axis.set_ylim(0.0, 1.05 * highest)
    if changing:
        _draw_speed(axes[2], dataset)
    label_abscissa(axes[-1], dataset)
    headline(figure, dataset)
    return figure


def _draw_speed(axis: Axes, dataset: xr.Dataset) -> None:
    """Speed in rad/s on the left, in turns per second on the right."""
    axis.plot(abscissa(dataset), speed(dataset), color="black")
    axis.set_title("Spin speed", loc="left")
    axis.set(ylabel=r"$\Omega$ (rad/s)", ylim=(0.0, None))
    turn = 2.0 * np.pi
    turns = axis.secondary_yaxis("right", functions=(lambda s: np.divide(s, turn), lambda f: np.multiply(f, turn)))
    turns.set_ylabel(r"$\Omega/2\pi$ (Hz)")
    turns.spines["right"].set_visible(True)
    mark(axis, dataset, named=False)


def phases(dataset: xr.Dataset) -> list[tuple[str, str, NDArray[np.bool_]]]:
    """Name, colour and samples of the parts of a run: before the step, with it, after its removal.

    A run without either has the parts before and with ROLAC, if that begins within it.
    """
    cycle = cycles(dataset)
    step, removal = dataset.attrs.get("step_cycle"), dataset.attrs.get("removal_cycle")
    if step is None and removal is None:
        begin = switched_on(dataset)
        if begin is None:
            return [("run", REMOVED, np.ones(len(cycle), dtype=bool))]
        return [("before ROLAC", BEFORE, cycle <= begin), ("with ROLAC", REMOVED, cycle >= begin)]
    begin, end = (-np.inf if step is None else step), (np.inf if removal is None else removal)
    loaded = "with the unbalance" if step is None else "with the added unbalance"
    parts = [
        ("before the step", BEFORE, cycle <= begin),
        (loaded, LOADED, (cycle >= begin) & (cycle <= end)),
        ("after its removal", REMOVED, cycle >= end),
    ]
    return [part for part, bound in zip(parts, (step, True, removal), strict=True) if bound is not None]


def _largest_coordinates(dataset: xr.Dataset) -> list[float]:
    return [1e3 * float(np.nanmax(np.abs(plant(dataset, f"{mb}.{a}")))) for mb in BEARINGS.values() for a in "xy"]
