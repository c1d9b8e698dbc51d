"""Figure of a touchdown: orbits on the retainers, heights, speeds, temperatures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import (
    DASHED,
    StyledFigure,
    draw_retainer,
    fitted,
    retainer_sample,
    set_orbit_axes,
)
from amb_cosim.presentation.units import SYMBOLS, ZERO_CELSIUS, force_unit, length_unit, speed_unit
from amb_cosim.results.orbits import gravity_across
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
    plant_signal,
    stations,
    time_values,
    title_padding,
)
from amb_cosim.results.plots.enlarged import first_impacts
from amb_cosim.results.plots.forces import PALE, site_force
from amb_cosim.results.plots.joined import dots_sample, draw_joined, orbit_line
from amb_cosim.results.signal_arrays import cycles, parameters, speed, speed_changes
from amb_cosim.results.touchdown import height_in_retainer
from amb_cosim.results.touchdown import touchdown as describe

Draw = Callable[[Axes, Signals, list[Station]], None]
"""Draws a panel with curves of these stations over time."""

NO_BREAK = "\N{NO-BREAK SPACE}"
LEAST_RISE = 1.0  # K, of an axis
BELOW = 0.45  # part of the panel of heights below its inset


def touchdown(dataset: Signals) -> Figure:
    """Draw the orbit at each station in its retainer, and below it heights, speeds, heat and temperatures over time.

    For a rotor with faces, the gaps along the shaft are also drawn. At bearings with retainers, heights are drawn if
    there is gravity across the shaft, and gaps to the retainers otherwise. Orbits and heights are relative to the
    retainer, which may have an offset and move on its mount, so the journal touches it where it reaches the clearance.
    An inset enlarges the first impacts; the orbit up to their end is drawn in a dark colour. The titles of the orbits
    state the whirl and the largest force.
    """
    drawn, result = [station for station in stations(dataset) if station.site], places(dataset)
    retainers = {**result.retainers, **result.second}
    warm = [station for station in drawn if parameters(dataset).get(f"{station.site}.heat_capacity")]
    heated = [station for station in drawn if np.any(plant_signal(dataset, f"{station.site}.heat") > 0.0)]
    over_time: list[tuple[Draw, list[Station]]] = [
        (draw_fall, [station for station in drawn if station.site in retainers] or drawn),
        *([(draw_gaps_along, drawn)] if result.faces else []),
        (_draw_speeds, drawn),
        *([(_draw_heat, heated)] if heated else []),
        *([(_draw_temperatures, warm)] if warm else []),
    ]
    zoom = fall_interval(dataset)
    width = max(2.5 * len(drawn), 7.0)
    orbit = width / max(len(drawn), 2)
    ratios = [1.7] * len(over_time)
    impacts = 1 if result.faces and not _touches_across(dataset) else 0  # panel with the first impacts
    ratios[impacts] += 1.2 * bool(zoom)
    heights = (orbit + 0.7, sum(ratios))
    figure = StyledFigure(figsize=(width, sum(heights) + 0.5), layout="constrained")
    figure.get_layout_engine().set(h_pad=0.08)  # type: ignore[call-arg, union-attr]
    above, below = np.ravel(np.asarray(figure.subfigures(2, 1, height_ratios=heights)))
    limit = 1.08 * max((_reach(dataset, station) for station in drawn), default=1.0)
    has_dots = False
    for panel, station in zip(above.subplots(1, max(len(drawn), 1), squeeze=False)[0], drawn, strict=False):
        has_dots |= _draw_orbit(panel, dataset, station, limit)
        lines = (station.title, *_facts(dataset, station.site))
        panel.set_title("\n".join(fitted(line, 0.95 * orbit) for line in lines))
    panels = below.subplots(len(over_time), 1, sharex=True, squeeze=False, height_ratios=ratios)[:, 0]
    for panel, (draw, of_stations) in zip(panels, over_time, strict=True):
        draw(panel, dataset, of_stations)
        panel.set_title(panel.get_title("left"), loc="left", pad=title_padding(dataset, panel is panels[0]))
        mark_events(panel, dataset)
    if zoom:
        _add_inset(panels[impacts], dataset, *over_time[impacts], zoom)
    label_time_axis(panels[-1], dataset)
    name_events(panels[0], dataset)
    handles = [*_legend(dataset, drawn), *([dots_sample()] if has_dots else [])]
    figure.legend(handles=handles, loc="outside lower center", ncols=max(int(width / 2.4), 2))
    add_title(figure, dataset)
    return figure


def _facts(dataset: Signals, site: str) -> list[str]:
    """Return the whirl of the rotor about a site after its release, and the largest force there, as texts."""
    fall, force = describe(dataset), site_force(dataset, site)
    if fall is None or site not in fall.retainers or force is None:
        return ["no contact"]
    item = fall.retainers[site]
    whirl = {None: "", "none": "no whirl"}.get(item.whirl, f"{item.whirl} whirl")
    mean = None if item.whirl_speed is None else f"mean {speed_unit().text(abs(item.whirl_speed), 3)}"
    speeds = "" if mean is None else f", {mean.replace(' ', NO_BREAK)}"
    largest = force_unit(force.marked[1]).text(force.marked[1], 3)
    meaning = "1 ms mean" if np.any(force.mean > 0.0) else "samples"
    return [*([f"{whirl}{speeds}"] if whirl else []), f"up to {largest} ({meaning})"]


def _touches_across(dataset: Signals) -> bool:
    """Return whether, in a fall, the rotor touches anything other than faces, which stop its axial motion."""
    fall = describe(dataset)
    return fall is not None and not places(dataset).faces.keys() >= fall.retainers.keys()


def _add_inset(panel: Axes, dataset: Signals, draw: Draw, drawn: list[Station], zoom: tuple[float, float]) -> None:
    """Enlarge the first impacts in the upper part of a panel, whose axis is extended to make room for them."""
    low, high = panel.get_ylim()
    ticks = [tick for tick in MaxNLocator(4).tick_values(low, high) if low <= tick <= high]
    panel.set_ylim(low, low + (high - low) / BELOW)
    panel.set_yticks(ticks)
    panel.axvspan(*zoom, ymax=BELOW, color="0.93", lw=0.0, zorder=-2)
    inset = panel.inset_axes((0.36, BELOW + 0.1, 0.63, 0.76 - BELOW))
    draw(inset, dataset, drawn)
    mark_events(inset, dataset)
    enlarge(inset, zoom)
    title = f"{FIRST_TEXT}: {inset.get_ylabel()} over {'time (s)' if speed_changes(dataset) else 'cycles'}"
    inset.set(ylabel="", facecolor="0.97")
    inset.set_title(title, loc="left", fontsize=8.0, bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0})
    inset.yaxis.set_major_locator(MaxNLocator(4))


def _legend(dataset: Signals, drawn: list[Station]) -> list[Artist]:
    """Return the legend that explains the colours and dashes of all panels."""
    names = [*(station.site for station in drawn), *places(dataset).faces]
    entries: list[Artist] = [Line2D([], [], color=colour_of(dataset, name), label=name_label(name)) for name in names]
    entries += [
        Line2D([], [], color="black", label="rotor"),
        lowest_sample(dataset),
        Line2D([], [], color="0.3", alpha=PALE, lw=0.5, label="orbit after the first impacts"),
        retainer_sample(),
    ]
    return entries


def lowest_sample(dataset: Signals) -> Line2D:
    """Return the legend entry for the dashed line of `draw_fall`."""
    at_rest = "at rest at the bottom of a rigid retainer (higher on the wall)"
    label = at_rest if gravity_across(dataset) else "contact"
    return Line2D([], [], color="black", ls=DASHED, label=label)


def _reach(dataset: Signals, station: Station) -> float:
    """Return the largest coordinate (m) that the picture of an orbit must show."""
    return max(clearance(dataset, station.site), float(np.nanmax(np.abs(station.seen(dataset)))))


def _draw_orbit(panel: Axes, dataset: Signals, station: Station, limit: float) -> bool:
    """Draw the path of the journal relative to its retainer, and the clearance.

    Return whether some samples of the path are drawn as dots.
    """
    unit = length_unit(limit)
    gap = clearance(dataset, station.site)
    line, sample = orbit_line(dataset, station.site, station.seen(dataset), gap)
    x, y = unit.of(line)
    draw_retainer(panel, gap / unit.size)
    colour, first = colour_of(dataset, station.site), first_impacts(dataset)
    early = (dataset["time"].values <= (np.inf if first is None else first[1]))[sample]
    has_dots = draw_joined(panel, x, y, color=colour, lw=0.5, alpha=PALE)
    draw_joined(panel, x[early], y[early], color=colour, lw=0.9)
    right, up = orbit_labels(dataset, unit.label)
    set_orbit_axes(panel, station.title, limit / unit.size, right)
    mark_axes(panel, dataset)
    panel.set_ylabel(up)
    return has_dots


def draw_fall(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    """Draw the height in the retainer at each station and its lower limit or, without gravity, the gap."""
    unit = length_unit(max((_reach(dataset, station) for station in drawn), default=1.0))
    falls = bool(gravity_across(dataset))
    for station in drawn:
        gap = clearance(dataset, station.site) - np.hypot(*station.path(dataset))
        values = height_in_retainer(dataset, station.place) if falls else gap
        if values is not None:
            panel.plot(time_values(dataset), unit.of(values), color=colour_of(dataset, station.site))
        lowest = -clearance(dataset, station.site) if falls else 0.0
        panel.axhline(lowest / unit.size, color="black", lw=0.8, ls=DASHED)
    panel.set_title("Height in the retainer" if falls else "Gap to the retainer", loc="left")
    panel.set_ylabel(f"{'height' if falls else 'gap'} ({unit.label})")


def draw_gaps_along(panel: Axes, dataset: Signals, _: list[Station]) -> None:
    """Draw the gap of each face along the shaft."""
    gaps = {face: plant_signal(dataset, f"{face}.gap") for face in places(dataset).faces}
    unit = length_unit(max((float(np.nanmax(np.abs(gap))) for gap in gaps.values()), default=1.0))
    for face, gap in gaps.items():
        panel.plot(time_values(dataset), unit.of(gap), color=colour_of(dataset, face), label=name_label(face))
    panel.axhline(0.0, color="black", lw=0.8, ls=DASHED)
    panel.set_title("Gap along the shaft", loc="left")
    panel.set_ylabel(f"gap ({unit.label})")


def _draw_speeds(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    panel.plot(time_values(dataset), speed_unit().of(speed(dataset)), color="black")
    races = {station.site: plant_signal(dataset, f"{station.site}.race_speed") for station in drawn}
    for site, race in races.items():
        if np.any(race != 0.0):
            panel.plot(time_values(dataset), speed_unit().of(race), color=colour_of(dataset, site))
    panel.set_title("Spin speed of rotor and races", loc="left")
    panel.set_ylabel(SYMBOLS[speed_unit().name])


def _draw_heat(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    """Draw the heat of friction, race drag and impacts from cycle 0 on."""
    begin = int(np.searchsorted(cycles(dataset), 0.0))
    heats = {station.site: plant_signal(dataset, f"{station.site}.heat") for station in drawn}
    heats = {site: heat - heat[min(begin, len(heat) - 1)] for site, heat in heats.items()}
    kilo = max((float(np.nanmax(heat)) for heat in heats.values()), default=0.0) >= 1e3
    for site, heat in heats.items():
        panel.plot(time_values(dataset), heat / (1e3 if kilo else 1.0), color=colour_of(dataset, site))
    panel.set_title("Heat in the retainers", loc="left")
    panel.set_ylabel("heat (kJ)" if kilo else "heat (J)")


def _draw_temperatures(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    for station in drawn:
        celsius = plant_signal(dataset, f"{station.site}.temperature") - ZERO_CELSIUS
        panel.plot(time_values(dataset), celsius, color=colour_of(dataset, station.site))
    low, high = panel.get_ylim()
    if high - low < LEAST_RISE:
        panel.set_ylim(low - 0.1 * LEAST_RISE, low + LEAST_RISE)
    panel.set_title("Temperature of the retainers", loc="left")
    panel.set_ylabel("temperature (°C)")
