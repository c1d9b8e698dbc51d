"""Overlaid figures of several runs: orbits, radial displacement, contact force."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import (
    DASHED,
    STYLE,
    TITLE_SIZE,
    StyledFigure,
    draw_retainer,
    fitted,
    set_orbit_axes,
)
from amb_cosim.presentation.units import force_unit, length_unit
from amb_cosim.results.contact_forces import peaks
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.orbits import path, radius, support, turned_upright
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import COLOURS, clearance, draw_events, event_times, mark_axes, orbit_labels
from amb_cosim.results.series import cycles, speed_changes
from array_types import Array

Runs = Mapping[str, Signals]
"""Records of the runs, by label."""

OPACITY = 0.8
LAST_TURNS = 2  # last cycles of a run whose orbit is drawn thick, so that no other run hides it


def overlays(runs: Runs) -> dict[str, Figure]:
    """Return the figures for which the runs have data, by name: `orbits`, `displacement`, `contact`."""
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
    """Draw the path of the rotor centre at each bearing in one colour per run, and the retainers below them.

    All orbits have the orientation of the first run.
    """
    first = next(iter(runs.values()))
    figure = StyledFigure(figsize=(max(3.7 * len(bearings), 4.5), 4.2), layout="constrained")
    panels = figure.subplots(1, len(bearings), squeeze=False)[0]
    unit = length_unit(_largest(radius(run, support(run, bearing)) for run in runs.values() for bearing in bearings))
    for panel, bearing in zip(panels, bearings, strict=True):
        for colour, run in zip(COLOURS * 2, runs.values(), strict=False):
            motion, c = path(run, support(run, bearing)), _clearance(run, bearing)
            if motion is not None:
                orbit = unit.of(turned_upright(first, motion))
                end = cycles(run) >= cycles(run).max(initial=0.0) - LAST_TURNS
                panel.plot(*orbit, color=colour, lw=0.6, alpha=OPACITY)
                panel.plot(*orbit[:, end], color=colour, lw=1.8, zorder=3)
            if c is not None:
                draw_retainer(panel, c / unit.size)
        right, up = orbit_labels(first, unit.label)
        set_orbit_axes(panel, fitted(bearing.upper(), 3.5), _reach(panel), right)
        mark_axes(panel, first)
    panels[0].set_ylabel(up)
    return _with_legend(figure, f"Orbits, the last {LAST_TURNS} cycles thick", panels[0], runs)


def displacement(runs: Runs, bearings: list[str]) -> Figure:
    """Draw the radius over the clearance at each bearing along the run, as a length where no run has a clearance."""

    def curves(bearing: str) -> tuple[str, list[Array | None]]:
        radii = [radius(run, support(run, bearing)) for run in runs.values()]
        gaps = [_clearance(run, bearing) for run in runs.values()]
        if any(c is not None for c in gaps):
            pairs = zip(radii, gaps, strict=True)
            return "radius / clearance", [None if r is None or c is None else r / c for r, c in pairs]
        unit = length_unit(_largest(radii))
        return f"radius ({unit.label})", [None if r is None else unit.of(r) for r in radii]

    figure = _along_the_run("Radial displacement", runs, bearings, curves)
    for panel in figure.axes:
        if panel.get_ylabel() == "radius / clearance":
            panel.axhline(1.0, color="black", lw=0.9, ls=DASHED, zorder=1)
    return figure


def contact(runs: Runs, sites: list[str]) -> Figure:
    """Draw the normal contact force at each site along the run."""
    unit = force_unit(_largest(peaks(run, site) for run in runs.values() for site in sites))

    def curves(site: str) -> tuple[str, list[Array | None]]:
        forces = (peaks(run, site) for run in runs.values())
        return f"force ({unit.label})", [None if force is None else unit.of(force) for force in forces]

    return _along_the_run("Normal contact force, maximum per step", runs, sites, curves)


def _along_the_run(
    what: str, runs: Runs, names: list[str], curves: Callable[[str], tuple[str, list[Array | None]]]
) -> Figure:
    """Draw a panel for each name, with a curve of each run over cycles or, if a speed varies, time.

    `curves` returns the label of a panel, and its values for each run, None without.
    """
    changing = any(speed_changes(run) for run in runs.values())
    figure = StyledFigure(figsize=(7.6, 2.2 * len(names) + 0.6), layout="constrained")
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for panel, name in zip(panels, names, strict=True):
        label, values = curves(name)
        for colour, run, series in zip(COLOURS * 2, runs.values(), values, strict=False):
            if series is not None:
                axis = np.asarray(run["time"].values) if changing else cycles(run)
                panel.plot(axis, series, color=colour, alpha=OPACITY, zorder=2)
        panel.set_title(name.upper(), loc="left", pad=16.0 if panel is panels[0] else None)
        panel.set(ylabel=label, ylim=(0.0, None))
        _mark_events(panel, runs, named=panel is panels[0])
    panels[-1].set_xlabel("time (s)" if changing else "synchronous cycles")
    return _with_legend(figure, what, panels[0], runs)


def _union(names: Iterable[Iterable[str]]) -> list[str]:
    """Return the names of all runs without repetition, in order of first appearance."""
    return list(dict.fromkeys(name for of_run in names for name in of_run))


def _clearance(run: Signals, bearing: str) -> float | None:
    """Return the clearance of a bearing's retainer (m), if it has one."""
    site = places(run).bearings.get(bearing)
    return clearance(run, site) if site else None


def _largest(values: Iterable[Array | None]) -> float:
    """Return the largest of all values; 0 if there are none."""
    return max((float(np.nanmax(series, initial=0.0)) for series in values if series is not None), default=0.0)


def _reach(panel: Axes) -> float:
    """Return symmetric axis limits that contain all data of a panel."""
    return 1.08 * float(np.abs([*panel.dataLim.intervalx, *panel.dataLim.intervaly]).max())


def _mark_events(panel: Axes, runs: Runs, named: bool) -> None:
    """Draw the events of all runs, each once; none if the axis mixes time and cycles."""
    if len({speed_changes(run) for run in runs.values()}) > 1:
        return
    marked: set[tuple[str, float]] = set()
    for run in runs.values():
        new = {event: time for event, time in event_times(run).items() if (event, time) not in marked}
        marked.update(new.items())
        draw_events(panel, new, named)


def _with_legend(figure: Figure, what: str, panel: Axes, runs: Runs) -> Figure:
    """Add a title, and a legend with one colour per run."""
    figure.suptitle(fitted(f"{what}: {' and '.join(runs)}", figure.get_figwidth()), fontsize=TITLE_SIZE)
    handles = [panel.plot([], [], color=colour, lw=1.4)[0] for colour, _ in zip(COLOURS * 2, runs, strict=False)]
    longest = max(len(label) for label in runs)
    figure.legend(handles, list(runs), loc="outside lower center", ncols=max(1, min(len(runs), 90 // (longest + 6))))
    return figure
