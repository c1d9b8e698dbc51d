"""Figure of a touchdown: orbits on the retainers, heights, speeds, temperatures."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import DASHED, GREY, StyledFigure, fitted, set_orbit_axes
from amb_cosim.presentation.units import SYMBOLS, length_unit, speed_unit
from amb_cosim.results.orbits import centre
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    Station,
    add_title,
    clearance,
    colour_of,
    label_time_axis,
    mark_events,
    plant_signal,
    stations,
    time_values,
    title_padding,
)
from amb_cosim.results.series import parameters, speed
from amb_cosim.results.touchdown import height

ZERO_CELSIUS = 273.15  # K


def touchdown(dataset: Signals) -> Figure:
    """Draw the orbit at each station in its clearance, and below, over time, heights, speeds and temperatures.

    Heights are those in the bearings, where they have retainers.
    """
    drawn, retainers = [station for station in stations(dataset) if station.site], places(dataset).retainers
    warm = [station for station in drawn if parameters(dataset).get(f"{station.site}.heat_capacity")]
    rows, width = 3 if warm else 2, max(2.5 * len(drawn), 7.0)
    orbit = width / max(len(drawn), 2)
    figure = StyledFigure(figsize=(width, orbit + 0.3 + 1.7 * rows), layout="constrained")
    grid = figure.add_gridspec(1 + rows, max(len(drawn), 1), height_ratios=[orbit, *[1.7] * rows])
    limit = 1.05 * max((_reach(dataset, station) for station in drawn), default=1.0)
    for k, station in enumerate(drawn):
        panel = figure.add_subplot(grid[0, k])
        _draw_orbit(panel, dataset, station, limit)
        panel.set_title(fitted(station.title, 0.95 * orbit))
    first = figure.add_subplot(grid[1, :])
    panels = [first, *(figure.add_subplot(grid[row, :], sharex=first) for row in range(2, 1 + rows))]
    _draw_heights(panels[0], dataset, [station for station in drawn if station.site in retainers] or drawn)
    _draw_speeds(panels[1], dataset, drawn)
    if warm:
        _draw_temperatures(panels[2], dataset, warm)
    for panel in panels:
        mark_events(panel, dataset, named=panel is first)
        panel.tick_params(labelbottom=panel is panels[-1])
    label_time_axis(panels[-1], dataset)
    figure.legend(handles=_legend(dataset, drawn), loc="outside lower center", ncols=min(len(drawn) + 3, 5))
    add_title(figure, dataset)
    return figure


def _has_housing(dataset: Signals, station: Station) -> bool:
    return bool(parameters(dataset).get(f"{station.site}.housing_mass"))


def _legend(dataset: Signals, drawn: list[Station]) -> list[Line2D]:
    """Return what colours and dashes mean in all panels."""
    entries = [Line2D([], [], color=colour_of(dataset, station.site), label=station.site.upper()) for station in drawn]
    entries += [
        Line2D([], [], color="black", label="rotor"),
        Line2D([], [], color="black", ls=DASHED, label="clearance"),
    ]
    if any(_has_housing(dataset, station) for station in drawn):
        entries.append(Line2D([], [], color=GREY, label="centre of the housing"))
    return entries


def _reach(dataset: Signals, station: Station) -> float:
    """Return the largest coordinate in the picture of an orbit (m)."""
    return max(clearance(dataset, station.site), float(np.nanmax(np.abs(_seen(dataset, station)))))


def _seen(dataset: Signals, station: Station) -> NDArray[np.float64]:
    """Return x and y (m) of the journal as one sees them who stands by, shape (2, n)."""
    return station.path(dataset) + centre(dataset, station.place)


def _draw_orbit(panel: Axes, dataset: Signals, station: Station, limit: float) -> None:
    """Draw the path of the journal, that of the housing if it moves, and the clearance about its place at rest."""
    unit = length_unit(limit)
    (x, y), turn = unit.of(_seen(dataset, station)), np.linspace(0.0, 2.0 * np.pi, 361)
    values = parameters(dataset)
    x_0, y_0 = (unit.of(float(values.get(f"{station.site}.offset_{axis}", 0.0))) for axis in "xy")
    c = unit.of(clearance(dataset, station.site))
    panel.plot(x_0 + c * np.cos(turn), y_0 + c * np.sin(turn), color="black", ls=DASHED, zorder=3)
    panel.plot(x, y, color=colour_of(dataset, station.site), lw=0.6)
    if _has_housing(dataset, station):
        panel.plot(*unit.of(centre(dataset, station.site)), color=GREY, lw=0.6)
    set_orbit_axes(panel, station.title, limit / unit.size, unit.label)
    panel.set_ylabel(f"$y$ ({unit.label})")


def _draw_heights(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    unit = length_unit(max((_reach(dataset, station) for station in drawn), default=1.0))
    for station in drawn:
        of_station = height(dataset, station.place)
        if of_station is not None:
            panel.plot(time_values(dataset), unit.of(of_station), color=colour_of(dataset, station.site))
            panel.axhline(-clearance(dataset, station.site) / unit.size, color="black", lw=0.8, ls=DASHED)
    panel.set_title("Height against gravity", loc="left", pad=title_padding(dataset, highest=True))
    panel.set_ylabel(f"height ({unit.label})")


def _draw_speeds(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    panel.plot(time_values(dataset), speed_unit().of(speed(dataset)), color="black")
    races = {station.site: plant_signal(dataset, f"{station.site}.race_speed") for station in drawn}
    for site, race in races.items():
        if np.any(race != 0.0):
            panel.plot(time_values(dataset), speed_unit().of(race), color=colour_of(dataset, site))
    panel.set_title("Spin speed of rotor and races", loc="left")
    panel.set_ylabel(SYMBOLS[speed_unit().name])


def _draw_temperatures(panel: Axes, dataset: Signals, drawn: list[Station]) -> None:
    for station in drawn:
        celsius = plant_signal(dataset, f"{station.site}.temperature") - ZERO_CELSIUS
        panel.plot(time_values(dataset), celsius, color=colour_of(dataset, station.site))
    panel.set_title("Temperature of the retainers", loc="left")
    panel.set_ylabel("temperature (°C)")
