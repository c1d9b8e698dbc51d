"""Figure of the last turns of a run: orbits with keyphasor marks and the direction of whirl."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import StyledFigure, fitted, set_orbit_axes
from amb_cosim.presentation.units import length_unit
from amb_cosim.results.orbits import settled_amplitude
from amb_cosim.results.plots.axes import add_title, colour_of, mark_axes, orbit_labels, stations
from amb_cosim.results.signal_arrays import turns as turns_of
from array_types import Array

TURNS = 3.0  # of the rotor, that are drawn


def turns(dataset: Signals) -> Figure:
    """Draw the last turns at each station, with a mark at each whole turn of the rotor and an arrow at the end.

    The marks are where a keyphasor would pulse, at the rotor's angle 0. The whirl is forward if the area that the
    motion encloses is positive in the sense of the rotor's spin,

        A = 1/2 integral of x dy - y dx about the centre of the orbit.
    """
    drawn = stations(dataset)
    revolutions = turns_of(dataset)
    last = revolutions >= revolutions[-1] - TURNS
    paths = [station.seen(dataset)[:, last] for station in drawn]
    limit = 1.15 * max((float(np.nanmax(np.abs(path))) for path in paths), default=0.0) or 1e-6
    unit = length_unit(limit)
    figure = StyledFigure(figsize=(max(3.5 * len(drawn), 4.5), 4.7), layout="constrained")
    panels = figure.subplots(1, max(len(drawn), 1), squeeze=False)[0]
    right, up = orbit_labels(dataset, unit.label)
    for panel, station, path in zip(panels, drawn, paths, strict=False):
        colour = colour_of(dataset, station.site) if station.site else "black"
        x, y = unit.of(path)
        panel.plot(x, y, color=colour)
        _mark_turns(panel, revolutions[last], x, y, colour)
        amplitude = settled_amplitude(dataset, station.path(dataset), "end")
        synchronous = "" if amplitude is None else f", 1x {unit.text(amplitude, 3)}"
        text = f"{whirl_direction(path)}{synchronous}"
        panel.text(0.5, 0.01, text, transform=panel.transAxes, ha="center", va="bottom", fontsize=8, color="0.3")
        set_orbit_axes(panel, fitted(station.title, 3.3), limit / unit.size, right)
        mark_axes(panel, dataset)
    panels[0].set_ylabel(up)
    mark = Line2D([], [], color="0.3", ls="", marker="o", ms=5.0, label=f"angle 0 of the rotor, last {TURNS:g} turns")
    figure.legend(handles=[mark], loc="outside lower center")
    add_title(figure, dataset)
    return figure


def whirl_direction(path: Array) -> str:
    """Return `forward whirl`, `backward whirl` or `to and fro` for a motion of shape (2, n), from its enclosed area.

    The motion is to and fro if the area is less than 5 % of the area of a circle of the same size.
    """
    x, y = path - path.mean(axis=1, keepdims=True)
    area = 0.5 * float(np.sum(x[:-1] * np.diff(y) - y[:-1] * np.diff(x)))
    swept = np.pi * float(np.max(np.hypot(x, y), initial=0.0)) ** 2
    if abs(area) < 0.05 * swept or swept == 0.0:
        return "to and fro"
    return "forward whirl" if area > 0.0 else "backward whirl"


def _mark_turns(panel: Axes, revolutions: Array, x: Array, y: Array, colour: str) -> None:
    """Draw a dot at each whole turn, and an arrow along the end of the motion."""
    whole = np.arange(np.ceil(revolutions[0]), np.floor(revolutions[-1]) + 1.0)
    panel.plot(np.interp(whole, revolutions, x), np.interp(whole, revolutions, y), "o", ms=5.0, color=colour)
    if len(x) > 2:
        style = {"arrowstyle": "-|>", "color": colour, "lw": 0.8}
        panel.annotate("", (x[-1], y[-1]), (x[-3], y[-3]), arrowprops=style)
