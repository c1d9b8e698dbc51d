"""Figures of several runs over each other: orbits, radial displacement, contact force."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import DASHED, STYLE, StyledFigure, fitted, set_orbit_axes
from amb_cosim.presentation.units import force_unit, length_unit
from amb_cosim.results.contact_forces import peaks
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.orbits import path, radius, support
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import COLOURS, clearance
from amb_cosim.results.series import cycles, speed_changes

Runs = Mapping[str, Signals]
"""What each run recorded, by its label."""

OPACITY = 0.8


def overlays(runs: Runs) -> dict[str, Figure]:
    """Return the figures that the runs have data for, by name: `orbits`, `displacement`, `contact`."""
    drawn = {}
    with mpl.rc_context(STYLE):
        bearings = _union(places(run).bearings for run in runs.values() if run.sizes["time"])
        moving = [name for name in bearings if any(radius(run, name) is not None for run in runs.values())]
        if moving:
            drawn["orbits"] = orbits(runs, moving)
            drawn["displacement"] = displacement(runs, moving)
        sites = _union(touchable(run) for run in runs.values() if run.sizes["time"])
        touched = [name for name in sites if any(peaks(run, name) is not None for run in runs.values())]
        if touched:
            drawn["contact"] = contact(runs, touched)
    return drawn


def orbits(runs: Runs, bearings: list[str]) -> Figure:
    """Draw the path of the rotor centre at each bearing, a colour for each run, and the clearances."""
    figure = StyledFigure(figsize=(max(3.7 * len(bearings), 4.5), 4.2), layout="constrained")
    panels = figure.subplots(1, len(bearings), squeeze=False)[0]
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    unit = length_unit(_largest(radius(run, support(run, bearing)) for run in runs.values() for bearing in bearings))
    for panel, bearing in zip(panels, bearings, strict=True):
        for colour, run in zip(COLOURS * 2, runs.values(), strict=False):
            result, c = path(run, support(run, bearing)), _clearance(run, bearing)
            if result is not None:
                panel.plot(*unit.of(result), color=colour, lw=0.6, alpha=OPACITY)
            if c is not None:
                panel.plot(unit.of(c) * np.cos(angle), unit.of(c) * np.sin(angle), color="black", ls=DASHED, lw=0.9)
        set_orbit_axes(panel, fitted(bearing.upper(), 3.5), _reach(panel), unit.label)
    panels[0].set_ylabel(f"$y$ ({unit.label})")
    return _with_legend(figure, panels[0], runs)


def displacement(runs: Runs, bearings: list[str]) -> Figure:
    """Draw the radius at each bearing over the clearance there, over the run; see `_axis`."""
    label, axis = _axis(runs)
    figure = StyledFigure(figsize=(7.6, 2.2 * len(bearings) + 0.6), layout="constrained")
    panels = figure.subplots(len(bearings), 1, sharex=True, squeeze=False)[:, 0]
    for panel, bearing in zip(panels, bearings, strict=True):
        unit = length_unit(_largest(radius(run, support(run, bearing)) for run in runs.values()))
        available = any(_clearance(run, bearing) is not None for run in runs.values())
        for colour, run in zip(COLOURS * 2, runs.values(), strict=False):
            r, c = radius(run, support(run, bearing)), _clearance(run, bearing)
            if r is not None and (c is not None or not available):
                panel.plot(axis(run), r / c if c is not None else unit.of(r), color=colour, alpha=OPACITY)
        if available:
            panel.axhline(1.0, color="black", lw=0.9, ls=DASHED)
        panel.set_title(bearing.upper(), loc="left")
        panel.set(ylabel="radius / clearance" if available else f"radius ({unit.label})", ylim=(0.0, None))
    panels[-1].set_xlabel(label)
    return _with_legend(figure, panels[0], runs)


def contact(runs: Runs, sites: list[str]) -> Figure:
    """Draw the normal contact force at each site over the run; see `_axis`."""
    label, axis = _axis(runs)
    figure = StyledFigure(figsize=(7.6, 2.2 * len(sites) + 0.6), layout="constrained")
    panels = figure.subplots(len(sites), 1, sharex=True, squeeze=False)[:, 0]
    unit = force_unit(_largest(peaks(run, site) for run in runs.values() for site in sites))
    for panel, site in zip(panels, sites, strict=True):
        for colour, run in zip(COLOURS * 2, runs.values(), strict=False):
            force = peaks(run, site)
            if force is not None:
                panel.plot(axis(run), unit.of(force), color=colour, alpha=OPACITY)
        panel.set_title(site.upper(), loc="left")
        panel.set(ylabel=f"force ({unit.label})", ylim=(0.0, None))
    panels[-1].set_xlabel(label)
    return _with_legend(figure, panels[0], runs)


def _axis(runs: Runs) -> tuple[str, Callable[[Signals], NDArray[np.float64]]]:
    """Return label and values of the axis along a run: its cycles or, where a speed changes, its time."""
    if any(speed_changes(run) for run in runs.values()):
        return "time (s)", lambda run: np.asarray(run["time"].values)
    return "synchronous cycles", cycles


def _union(names: Iterable[Iterable[str]]) -> list[str]:
    """Return the names of all runs, each once, in the order of their first appearance."""
    return list(dict.fromkeys(name for result in names for name in result))


def _clearance(run: Signals, bearing: str) -> float | None:
    """Return the clearance of a bearing's retainer (m); None where it has none."""
    site = places(run).bearings.get(bearing)
    return clearance(run, site) if site else None


def _largest(values: Iterable[NDArray[np.float64] | None]) -> float:
    """Return the largest of all values; 0 without any."""
    return max((float(np.nanmax(result, initial=0.0)) for result in values if result is not None), default=0.0)


def _reach(panel: Axes) -> float:
    """Return a limit about zero, either way, that holds all that a panel shows."""
    return 1.08 * float(np.abs([*panel.dataLim.intervalx, *panel.dataLim.intervaly]).max())


def _with_legend(figure: Figure, panel: Axes, runs: Runs) -> Figure:
    """Add a legend with a colour for each run."""
    handles = [panel.plot([], [], color=colour, lw=1.4)[0] for colour, _ in zip(COLOURS * 2, runs, strict=False)]
    longest = max(len(label) for label in runs)
    figure.legend(handles, list(runs), loc="outside lower center", ncols=max(1, min(len(runs), 90 // (longest + 6))))
    return figure
