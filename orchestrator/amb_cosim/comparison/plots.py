"""Overlaid figures of several runs: orbits, radial displacement, contact force."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import (
    DASHED,
    STYLE,
    StyledFigure,
    draw_retainer,
    fitted,
    set_orbit_axes,
    write_title,
)
from amb_cosim.presentation.units import length_unit
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.orbits import path, radius, support, turned_upright
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    COLOURS,
    FIRST_TEXT,
    WHOLE,
    bearing_title,
    clearance,
    draw_events,
    enlarge,
    event_times,
    mark_axes,
    orbit_labels,
    site_title,
    write_events,
)
from amb_cosim.results.plots.enlarged import first_impacts
from amb_cosim.results.plots.forces import (
    ENLARGED_REACH,
    REACH,
    SiteForce,
    draw_forces,
    mark_forces,
    site_force,
)
from amb_cosim.results.plots.joined import draw_joined, orbit_line
from amb_cosim.results.signal_arrays import cycles, finite_signals, speed_changes
from amb_cosim.results.thinned import judged
from amb_cosim.results.touchdown import height_in_retainer, touchdown
from array_types import Array

Runs = Mapping[str, Signals]
"""Records of the runs, by label."""

OPACITY = 0.8
LAST_TURNS = 2  # last cycles of a run whose orbit is drawn thick, so that no other run hides it


def overlays(runs: Runs) -> dict[str, Figure]:
    """Return the figures for which the runs have data, by name: `orbits`, `displacement`, `contact`."""
    drawn, runs = {}, {label: finite_signals(run)[0] for label, run in runs.items()}
    of_steps = {label: judged(run) for label, run in runs.items()}
    with mpl.rc_context(STYLE):
        bearings = _union(places(run).bearings for run in runs.values() if run.sizes["time"])
        moving = [name for name in bearings if any(radius(run, name) is not None for run in runs.values())]
        if moving:
            drawn["orbits"] = orbits(of_steps, moving)
            drawn["displacement"] = displacement(of_steps, moving)
        sites = _union(touchable(run) for run in runs.values() if run.sizes["time"])
        touched = [name for name in sites if any(site_force(run, name) is not None for run in runs.values())]
        if touched:
            drawn["contact"] = contact(runs, touched)
    return drawn


def orbits(runs: Runs, bearings: list[str]) -> Figure:
    """Draw the path of the rotor centre at each bearing, in one colour per run, with the retainers in the background.

    The orbits of all runs are oriented like the orbits of the first run.
    """
    first = next(iter(runs.values()))
    figure = StyledFigure(figsize=(max(3.7 * len(bearings), 4.5), 4.5), layout="constrained")
    figure.get_layout_engine().set(h_pad=0.1)  # type: ignore[call-arg, union-attr]
    panels = figure.subplots(1, len(bearings), squeeze=False)[0]
    unit = length_unit(_largest(radius(run, support(run, bearing)) for run in runs.values() for bearing in bearings))
    for panel, bearing in zip(panels, bearings, strict=True):
        for colour, run in zip(COLOURS * 2, runs.values(), strict=False):
            motion, c = path(run, support(run, bearing)), _clearance(run, bearing)
            if motion is not None:
                site = places(run).bearings.get(bearing) or ""
                line, sample = orbit_line(run, site, turned_upright(first, motion), c or 0.0)
                orbit, end = unit.of(line), (cycles(run) >= cycles(run).max(initial=0.0) - LAST_TURNS)[sample]
                draw_joined(panel, *orbit, color=colour, lw=0.6, alpha=OPACITY)
                draw_joined(panel, *orbit[:, end], color=colour, lw=1.8, zorder=3)
            if c is not None:
                draw_retainer(panel, c / unit.size)
        right, up = orbit_labels(first, unit.label)
        set_orbit_axes(panel, fitted(_title(runs, bearing_title, bearing), 3.5), _reach(panel), right)
        mark_axes(panel, first)
    panels[0].set_ylabel(up)
    return _with_legend(figure, f"Orbits (thick: last {LAST_TURNS} cycles)", panels[0], runs)


def displacement(runs: Runs, bearings: list[str]) -> Figure:
    """Draw the ratio of radius to clearance over the run at each bearing, or the radius if no run has a clearance.

    If a rotor falls, its height is drawn instead (the gap if the rotor is upright), and the first impacts are enlarged
    in a second column.
    """
    falls, changing = any(touchdown(run) is not None for run in runs.values()), _is_changing(runs)

    def draw(panel: Axes, bearing: str) -> None:
        label, values, limits = _motion(runs, bearing, falls)
        for colour, run, series in zip(COLOURS * 2, runs.values(), values, strict=False):
            if series is not None:
                panel.plot(_times(run, changing), series, color=colour, alpha=OPACITY, zorder=2)
        panel.set_ylabel(label)
        if not falls:
            panel.set_ylim(0.0, None)
        for limit in limits:
            panel.axhline(limit, color="black", lw=0.9, ls=DASHED, zorder=1)

    figure, columns = _along_the_run(runs, bearings, bearing_title, draw)
    zoom = _first_impacts(runs)
    if zoom is not None:
        for panel in columns[1]:
            enlarge(panel, zoom)
    return _with_legend(figure, "Height" if falls else "Radial displacement", columns[0][0], runs)


def _motion(runs: Runs, bearing: str, falls: bool) -> tuple[str, list[Array | None], set[float]]:
    """Return the axis label of a bearing, the motion to plot, and the values at which a rotor touches the retainer."""
    radii = [radius(run, support(run, bearing)) for run in runs.values()]
    gaps = [_clearance(run, bearing) for run in runs.values()]
    clearances = [c for c in gaps if c is not None]
    unit = length_unit(max(_largest(radii), *clearances, 0.0))
    if falls and clearances:
        heights = [height_in_retainer(run, support(run, bearing)) for run in runs.values()]
        if all(h is not None for h in heights):
            lowest = {-c / unit.size for c in clearances}
            return f"height ({unit.label})", [None if h is None else unit.of(h) for h in heights], lowest
        left = [None if r is None or c is None else unit.of(c - r) for r, c in zip(radii, gaps, strict=True)]
        return f"gap ({unit.label})", left, {0.0}
    if clearances:
        shares = [None if r is None or c is None else r / c for r, c in zip(radii, gaps, strict=True)]
        return "radius / clearance", shares, {1.0}
    return f"radius ({unit.label})", [None if r is None else unit.of(r) for r in radii], set()


def contact(runs: Runs, sites: list[str]) -> Figure:
    """Draw the normal contact force at each site over the run, with its 1 ms mean as a thick line; mark the largest.

    If a rotor falls, the first impacts are enlarged in a second column.
    """
    forces = {site: _forces_at(runs, site, _is_changing(runs)) for site in sites}
    figure, columns = _along_the_run(runs, sites, site_title, lambda panel, site: draw_forces(panel, forces[site]))
    for column, reach in zip(columns, (REACH, ENLARGED_REACH), strict=False):
        for panel, site in zip(column, sites, strict=True):
            mark_forces(panel, forces[site], reach)
    curves = "thick: 1 ms mean with impact impulses; pale: peaks without impacts"
    return _with_legend(figure, f"Normal contact force ({curves})", columns[0][0], runs)


def _forces_at(runs: Runs, site: str, changing: bool) -> list[tuple[Array, SiteForce, str]]:
    """Return the times, force and colour of each run in which the rotor touches a site."""
    forces = [(run, site_force(run, site), colour) for run, colour in zip(runs.values(), COLOURS * 2, strict=False)]
    return [(_times(run, changing), force, colour) for run, force, colour in forces if force is not None]


def _times(run: Signals, changing: bool) -> Array:
    """Return the position of each sample on the time axis: its cycle, or its time (s) if any run changes its speed."""
    return np.asarray(run["time"].values, np.float64) if changing else cycles(run)


def _is_changing(runs: Runs) -> bool:
    """Return whether the speed of any run changes; the time axis of all runs is then in seconds."""
    return any(speed_changes(run) for run in runs.values())


def _first_impacts(runs: Runs) -> tuple[float, float] | None:
    """Return limits of the time axis that contain the first impacts of all falls; None if no rotor falls."""
    changing = _is_changing(runs)
    drawn = [(run, first) for run in runs.values() if (first := first_impacts(run)) is not None]
    sizes = [1.0 if changing else float(run.attrs["period_s"]) for run, _ in drawn]
    ends = [(begin / size, end / size) for (_, (begin, end)), size in zip(drawn, sizes, strict=True)]
    begin, end = min((b for b, _ in ends), default=0.0), max((e for _, e in ends), default=np.inf)
    longest = max(float(np.ptp(_times(run, changing))) for run in runs.values() if run.sizes["time"])
    return (begin, end) if end - begin < WHOLE * longest else None


def _along_the_run(
    runs: Runs, names: list[str], title_in: Callable[[Signals, str], str], draw: Callable[[Axes, str], None]
) -> tuple[Figure, NDArray[np.object_]]:
    """Return a figure with a panel for each name, and its columns; time is in cycles, or in s if a speed varies.

    If the rotor falls in any run, a second column enlarges the first impacts.
    """
    zoom = _first_impacts(runs)
    size = (7.6 if zoom is None else 10.4, 2.2 * len(names) + 0.8)
    figure = StyledFigure(figsize=size, layout="constrained")
    columns = figure.subplots(len(names), 1 if zoom is None else 2, sharex="col", squeeze=False).T
    for column in columns:
        for panel, name in zip(column, names, strict=True):
            draw(panel, name)
            panel.margins(x=0.0)
            panel.set_title(_title(runs, title_in, name), loc="left", pad=16.0 if panel is column[0] else None)
            _draw_events(panel, runs)
        column[-1].set_xlabel("time (s)" if _is_changing(runs) else "synchronous cycles")
    if zoom is not None:
        for panel in columns[1]:
            panel.set_title("", loc="left")
        columns[1][0].set_title(FIRST_TEXT, loc="left", pad=16.0)
        columns[1][-1].set_xlim(zoom)
        columns[1][-1].xaxis.set_major_locator(MaxNLocator(6))
    for column in columns:
        _write_events(column[0], runs)
    return figure, columns


def _union(names: Iterable[Iterable[str]]) -> list[str]:
    """Return the names in all runs without repetition, in order of first appearance."""
    return list(dict.fromkeys(name for of_run in names for name in of_run))


def _title(runs: Runs, title_in: Callable[[Signals, str], str], name: str) -> str:
    """Return the title of a bearing or a site: its name and, unless it differs between runs, its position."""
    having = [run for run in runs.values() if name in {*places(run).bearings, *places(run).sites}]
    titles = {title_in(run, name) for run in having}
    return titles.pop() if len(titles) == 1 else name_label(name)


def _clearance(run: Signals, bearing: str) -> float | None:
    """Return the clearance of a bearing's retainer (m), if it has one."""
    site = places(run).bearings.get(bearing)
    return clearance(run, site) if site else None


def _largest(values: Iterable[Array | None]) -> float:
    """Return the largest of all values; 0 if there are none."""
    return max((float(np.nanmax(series, initial=0.0)) for series in values if series is not None), default=0.0)


def _reach(panel: Axes) -> float:
    """Return the limit of symmetric axes that contain all data of a panel."""
    return 1.08 * float(np.abs([*panel.dataLim.intervalx, *panel.dataLim.intervaly]).max())


def _events(runs: Runs) -> list[tuple[str, float]]:
    """Return the events of all runs, each once; return none if the speed changes in some runs but not in all."""
    if len({speed_changes(run) for run in runs.values()}) > 1:
        return []
    return list(dict.fromkeys(event for run in runs.values() for event in event_times(run).items()))


def _draw_events(panel: Axes, runs: Runs) -> None:
    draw_events(panel, [time for _, time in _events(runs)])


def _write_events(panel: Axes, runs: Runs) -> None:
    write_events(panel, _events(runs))


def _with_legend(figure: Figure, what: str, panel: Axes, runs: Runs) -> Figure:
    """Add a title, and a legend with one colour per run."""
    write_title(figure, f"{what}: {' and '.join(runs)}")
    handles = [panel.plot([], [], color=colour, lw=1.4)[0] for colour, _ in zip(COLOURS * 2, runs, strict=False)]
    longest = max(len(label) for label in runs)
    figure.legend(handles, list(runs), loc="outside lower center", ncols=max(1, min(len(runs), 90 // (longest + 6))))
    return figure
