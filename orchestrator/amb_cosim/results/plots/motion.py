"""Figures of the rotor's motion: orbits at bearings and other touched sites, and their radius over the run."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import (
    BLUE,
    DASHED,
    GREY,
    ORANGE,
    StyledFigure,
    draw_retainer,
    fitted,
    retainer_sample,
    set_orbit_axes,
    write_in_corner,
)
from amb_cosim.presentation.units import SYMBOLS, length_unit, speed_unit
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    FIRST_TEXT,
    Station,
    add_title,
    clearance,
    colour_of,
    enlarge,
    fall_interval,
    label_time_axis,
    mark_axes,
    mark_events,
    name_events,
    orbit_labels,
    speed_is_drawn,
    stations,
    time_values,
    title_padding,
)
from amb_cosim.results.plots.fall import draw_fall, draw_gaps_along, lowest_sample
from amb_cosim.results.plots.joined import dots_sample, draw_joined, orbit_line
from amb_cosim.results.signal_arrays import cycles, event_name, speed, switched_on
from amb_cosim.results.touchdown import touchdown
from array_types import Bools

SMALL_MOTION = 0.25  # fraction of the clearance; smaller motion is drawn with its own scale
MOST_COLUMNS = 4  # of orbits side by side

# Colours of the parts of a run.
BEFORE, LOADED, AFTER = GREY, ORANGE, BLUE


def orbits(dataset: Signals) -> Figure:
    """Draw the path of the rotor centre at each station, coloured by part of the run, and the clearance.

    If all orbits are small compared with their clearances, they are enlarged, and the clearance is written as text.
    """
    drawn = stations(dataset)
    gaps = [clearance(dataset, station.site) if station.site else 0.0 for station in drawn]
    reach = [float(np.nanmax(np.abs(station.seen(dataset)), initial=0.0)) for station in drawn]
    small = all(_is_small(r, c) for r, c in zip(reach, gaps, strict=True))
    limit = (1.35 * max(reach) if small else 1.14 * max(gaps + reach)) or 1e-6
    unit, columns = length_unit(limit), min(len(drawn), MOST_COLUMNS)
    rows = -(-len(drawn) // columns)
    figure = StyledFigure(figsize=(max(3.5 * columns, 4.5), 3.4 * rows + 0.5), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    has_dots = False
    for panel, station, c in zip(panels.flat, drawn, gaps, strict=False):
        line, sample = orbit_line(dataset, station.site, station.seen(dataset), c)
        x, y = unit.of(line)
        if station.site and small:
            write_in_corner(panel, f"clearance {unit.text(c)}")
        elif station.site:
            draw_retainer(panel, c / unit.size)
        for _, colour, within in run_parts(dataset):
            shown = within[sample]
            has_dots |= draw_joined(panel, np.where(shown, x, np.nan), np.where(shown, y, np.nan), color=colour, lw=0.7)
        set_orbit_axes(panel, fitted(station.title, 3.3), limit / unit.size, orbit_labels(dataset, unit.label)[0])
        mark_axes(panel, dataset)
    for first in panels[:, 0]:
        first.set_ylabel(orbit_labels(dataset, unit.label)[1])
    for panel in panels.flat[len(drawn) :]:
        panel.remove()
    handles: list[Artist] = [Line2D([], [], color=colour, label=label) for label, colour, _ in run_parts(dataset)]
    if not small and any(gaps):
        handles.insert(0, retainer_sample())
    handles += [dots_sample()] if has_dots else []
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    add_title(figure, dataset)
    return figure


def displacement(dataset: Signals) -> Figure:
    """Draw the radius of the motion at each station, divided by the clearance, and the speed below if it changes.

    The radius is drawn as a length if it is small compared with the clearance, or if there is no clearance. For a fall,
    the height or the gap is drawn, because the radius equals the clearance after the landing; the first impacts are
    enlarged, and a panel below the stations shows the gap along the shaft at each face, if the machine has faces.
    """
    drawn, changing, zoom = stations(dataset), speed_is_drawn(dataset), fall_interval(dataset)
    along = touchdown(dataset) is not None and bool(places(dataset).faces)
    size = (10.0 if zoom else 7.0, max(2.1 * (len(drawn) + along) + 1.2 * changing, 2.8))
    figure = StyledFigure(figsize=size, layout="constrained")
    ratios = (3,) * (len(drawn) + along) + (2,) * changing
    grid = figure.subplots(len(ratios), 1 + bool(zoom), sharex="col", height_ratios=ratios, squeeze=False)
    for panels in grid.T:
        _draw_column(panels, dataset, drawn)
        if along:
            draw_gaps_along(panels[len(drawn)], dataset, drawn)
            mark_events(panels[len(drawn)], dataset)
            panels[len(drawn)].legend(loc="center right")
        if changing:
            _draw_speed(panels[-1], dataset)
        label_time_axis(panels[-1], dataset)
    if zoom:
        for panel in grid[:, 1]:
            enlarge(panel, zoom)
            panel.set_title("", loc="left")
        grid[0, 1].set_title(FIRST_TEXT, loc="left", pad=title_padding(dataset, highest=True))
    for panel in grid[0]:
        name_events(panel, dataset)
    if touchdown(dataset) is not None and any(station.site for station in drawn):
        figure.legend(handles=[lowest_sample(dataset)], loc="outside lower center")
    add_title(figure, dataset)
    return figure


def _draw_column(panels: NDArray[np.object_], dataset: Signals, drawn: list[Station]) -> None:
    """Draw the motion at each station over the run."""
    falls, highest, relative = touchdown(dataset) is not None, 1.0, []
    for panel, station in zip(panels, drawn, strict=False):
        r = np.hypot(*station.path(dataset))
        reach = float(np.nanmax(r, initial=0.0))
        colour = colour_of(dataset, station.site) if station.site else "black"
        mark_events(panel, dataset)
        c = clearance(dataset, station.site) if station.site else 0.0
        if falls and station.site:
            draw_fall(panel, dataset, [station])
            continue
        if _is_small(reach, c):
            unit = length_unit(reach)
            panel.plot(time_values(dataset), unit.of(r), color=colour)
            panel.set(ylabel=f"radius ({unit.label})", ylim=(0.0, 1.25 * reach / unit.size or None))
            if c:
                write_in_corner(panel, f"clearance {unit.text(c)}")
            continue
        highest = max(highest, reach / c)
        relative.append(panel)
        panel.axhline(1.0, color="black", lw=1.0, ls=DASHED)
        panel.plot(time_values(dataset), r / c, color=colour)
        panel.set_ylabel("radius / clearance")
    for panel, station in zip(panels, drawn, strict=False):
        panel.set_title(station.title, loc="left", pad=title_padding(dataset, panel is panels[0]))
    for panel in relative:
        panel.set_ylim(0.0, 1.05 * highest)


def _is_small(reach: float, clearance: float) -> bool:
    """Return whether a motion is too small to be visible beside the clearance, or the clearance is zero."""
    return reach < SMALL_MOTION * clearance or clearance == 0.0


def _draw_speed(panel: Axes, dataset: Signals) -> None:
    """Draw the spin speed on an axis that covers its changes but not zero."""
    speeds = speed_unit().of(speed(dataset))
    panel.plot(time_values(dataset), speeds, color="black")
    panel.set_title("Spin speed", loc="left")
    panel.set_ylabel(SYMBOLS[speed_unit().name])
    mark_events(panel, dataset)


def run_parts(dataset: Signals) -> list[tuple[str, str, Bools]]:
    """Return name, colour and samples of each part of a run: before the disturbance, up to the relief, and after it.

    A run without these events is divided at the time when ROLAC is switched on, if there is one. Adjacent parts share a
    sample.
    """
    cycle = cycles(dataset)
    disturbance, relief = dataset.attrs.get("disturbance_cycle"), dataset.attrs.get("relief_cycle")
    if disturbance is None and relief is None:
        begin = switched_on(dataset)
        if begin is None:
            return [("run", AFTER, np.ones(len(cycle), dtype=bool))]
        return [("before ROLAC", BEFORE, cycle <= begin), ("with ROLAC", AFTER, cycle >= begin)]
    begin, end = (-np.inf if disturbance is None else disturbance), (np.inf if relief is None else relief)
    first, last = event_name(dataset, "disturbance"), event_name(dataset, "relief")
    loaded = f"before the {last}" if disturbance is None else f"from the {first} on"
    parts = [
        (f"before the {first}", BEFORE, cycle <= begin),
        (loaded, LOADED, (cycle >= begin) & (cycle <= end)),
        (f"after the {last}", AFTER, cycle >= end),
    ]
    return [part for part, bound in zip(parts, (disturbance, True, relief), strict=True) if bound is not None]
