"""Figure of a touchdown: orbits on the retainers, heights, speeds, temperatures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import (
    DASHED,
    GREY,
    StyledFigure,
    draw_retainer,
    fitted,
    retainer_sample,
    set_orbit_axes,
)
from amb_cosim.presentation.units import SYMBOLS, length_unit, speed_unit
from amb_cosim.results.orbits import centre, turned_upright
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    Station,
    add_title,
    clearance,
    colour_of,
    label_time_axis,
    mark_axes,
    mark_events,
    orbit_labels,
    plant_signal,
    stations,
    time_values,
    title_padding,
)
from amb_cosim.results.series import cycles, parameters, speed
from amb_cosim.results.touchdown import height
from array_types import Array

ZERO_CELSIUS = 273.15  # K


def touchdown(dataset: Signals) -> Figure:
    """Draw the orbit at each station in its retainer, and below, over time, heights, speeds, heat and temperatures.

    Heights, which need gravity, are those in the bearings with retainers.
    """
    drawn, result = [station for station in stations(dataset) if station.site], places(dataset)
    retainers = {**result.retainers, **result.second}
    warm = [station for station in drawn if parameters(dataset).get(f"{station.site}.heat_capacity")]
    heated = [station for station in drawn if f"rotor_contact.{station.site}.heat" in dataset]
    falls = bool(parameters(dataset).get("gravity"))
    over_time: list[tuple[Callable[[Axes, Signals, list[Station]], None], list[Station]]] = [
        *([(_draw_heights, [station for station in drawn if station.site in retainers] or drawn)] if falls else []),
        (_draw_speeds, drawn),
        *([(_draw_heat, heated)] if heated else []),
        *([(_draw_temperatures, warm)] if warm else []),
    ]
    width = max(2.5 * len(drawn), 7.0)
    orbit = width / max(len(drawn), 2)
    heights = (orbit + 0.3, 1.7 * len(over_time))
    figure = StyledFigure(figsize=(width, sum(heights) + 0.5), layout="constrained")
    above, below = np.ravel(np.asarray(figure.subfigures(2, 1, height_ratios=heights)))
    limit = 1.08 * max((_reach(dataset, station) for station in drawn), default=1.0)
    for panel, station in zip(above.subplots(1, max(len(drawn), 1), squeeze=False)[0], drawn, strict=False):
        _draw_orbit(panel, dataset, station, limit)
        panel.set_title(fitted(station.title, 0.95 * orbit))
    panels = below.subplots(len(over_time), 1, sharex=True, squeeze=False)[:, 0]
    for panel, (draw, of_stations) in zip(panels, over_time, strict=True):
        draw(panel, dataset, of_stations)
        highest = panel is panels[0]
        panel.set_title(panel.get_title("left"), loc="left", pad=title_padding(dataset, highest))
        mark_events(panel, dataset, named=highest)
    label_time_axis(panels[-1], dataset)
    figure.legend(handles=_legend(dataset, drawn), loc="outside lower center", ncols=max(int(width / 2.4), 2))
    add_title(figure, dataset)
    return figure


def _has_housing(dataset: Signals, station: Station) -> bool:
    return bool(parameters(dataset).get(f"{station.site}.housing_mass"))


def _legend(dataset: Signals, drawn: list[Station]) -> list[Artist]:
    """Return the legend of colours and dashes of all panels."""
    falls = bool(parameters(dataset).get("gravity"))
    entries: list[Artist] = [
        Line2D([], [], color=colour_of(dataset, station.site), label=station.site.upper()) for station in drawn
    ]
    entries += [
        Line2D([], [], color="black", label="rotor"),
        *([Line2D([], [], color="black", ls=DASHED, label="height of a rotor at the bottom")] if falls else []),
        retainer_sample(),
    ]
    if any(_has_housing(dataset, station) for station in drawn):
        entries.append(Line2D([], [], color=GREY, label="centre of the housing"))
    return entries


def _reach(dataset: Signals, station: Station) -> float:
    """Return the largest coordinate in the picture of an orbit (m)."""
    ring = clearance(dataset, station.site) + float(np.abs(_offset(dataset, station.site)).max())
    return max(ring, float(np.nanmax(np.abs(_seen(dataset, station)))))


def _offset(dataset: Signals, site: str) -> Array:
    """Return the place of a retainer at rest to the right and upwards, shape (2,) (m)."""
    values = parameters(dataset)
    offset = np.array([[float(values.get(f"{site}.offset_{axis}") or 0.0)] for axis in "xy"])
    return turned_upright(dataset, offset)[:, 0]


def _seen(dataset: Signals, station: Station) -> Array:
    """Return the place of the journal to the right and upwards, for an observer at rest, shape (2, n) (m)."""
    return turned_upright(dataset, station.path(dataset) + centre(dataset, station.place))


def _draw_orbit(panel: Axes, dataset: Signals, station: Station, limit: float) -> None:
    """Draw the path of the journal, that of a moving housing, and the clearance about its position at rest."""
    unit = length_unit(limit)
    x, y = unit.of(_seen(dataset, station))
    x_0, y_0 = unit.of(_offset(dataset, station.site))
    draw_retainer(panel, clearance(dataset, station.site) / unit.size, (float(x_0), float(y_0)))
    panel.plot(x, y, color=colour_of(dataset, station.site), lw=0.6)
    if _has_housing(dataset, station):
        panel.plot(*unit.of(turned_upright(dataset, centre(dataset, station.site))), color=GREY, lw=0.6)
    right, up = orbit_labels(dataset, unit.label)
    set_orbit_axes(panel, station.title, limit / unit.size, right)
    mark_axes(panel, dataset)
    panel.set_ylabel(up)


def _draw_heights(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    unit = length_unit(max((_reach(dataset, station) for station in drawn), default=1.0))
    for station in drawn:
        heights = height(dataset, station.place)
        if heights is not None:
            panel.plot(time_values(dataset), unit.of(heights), color=colour_of(dataset, station.site))
            lowest = float(_offset(dataset, station.site)[1]) - clearance(dataset, station.site)
            panel.axhline(lowest / unit.size, color="black", lw=0.8, ls=DASHED)
    panel.set_title("Height against gravity", loc="left")
    panel.set_ylabel(f"height ({unit.label})")


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
    panel.set_title("Temperature of the retainers", loc="left")
    panel.set_ylabel("temperature (°C)")
