"""Receptance of the levitated rotor."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator

from amb_analysis.studies.sensor_receptance import SensorReceptance
from amb_cosim.presentation.style import COLOURS, DASHED, StyledFigure, write_title
from amb_cosim.presentation.units import speed_unit, spin_label
from array_types import Array

WIDTH = 4.2  # inches, of a bearing's panels


def draw(result: SensorReceptance) -> Figure:
    """Draw the magnitude (sensors in x and y) and the phase (in x) over speed, for a force in x at each bearing."""
    bearings = len(result.forces) // 2
    figure = StyledFigure(figsize=(WIDTH * max(bearings, 2), 6.0), layout="constrained")
    panels = figure.subplots(2, bearings, squeeze=False, sharex=True, sharey="row", height_ratios=(3, 2))
    speeds, R = speed_unit().of_hertz(result.spin_frequencies), result.receptance
    for column, force in enumerate(range(0, len(result.forces), 2)):
        top, bottom = panels[:, column]
        for plane in range(len(result.planes)):
            colour = _colour(plane)
            along, across = R[:, 2 * plane, force], R[:, 2 * plane + 1, force]
            top.semilogy(speeds, 1e6 * np.abs(along), color=colour)
            top.semilogy(speeds, 1e6 * np.abs(across), color=colour, ls=DASHED, lw=0.7)
            bottom.plot(speeds, _without_wraps(np.degrees(np.angle(along))), color=colour)
        top.set_title(f"force at {result.forces[force]}")
        bottom.set(xlabel=spin_label(), xlim=(speeds[0], speeds[-1]), ylim=(-180.0, 180.0))
        bottom.yaxis.set_major_locator(MultipleLocator(90.0))
        for axes in (top, bottom):
            axes.grid(color="0.9", lw=0.5)
    largest = 1e6 * np.abs(R).max()
    panels[0, 0].set(ylabel="displacement / force (µm/N)", ylim=(1e-5 * largest, 2.0 * largest))
    panels[1, 0].set_ylabel("phase in x (deg)")
    _add_legend(figure, result)
    write_title(figure, f"{result.rotor}: synchronous receptance of the levitated rotor, from the model")
    return figure


def _without_wraps(phase: Array) -> Array:
    """Return the phase (deg) with gaps at jumps between -180 and 180 degrees."""
    return np.where(np.abs(np.diff(phase, prepend=phase[0])) > 180.0, np.nan, phase)


def _colour(plane: int) -> str:
    return COLOURS[plane % len(COLOURS)]


def _add_legend(figure: Figure, result: SensorReceptance) -> None:
    """Add a legend of the sensor planes, by axial position (m), and of the two line styles."""
    handles = [
        Line2D([], [], color=_colour(k), label=f"{', '.join(result.sensors[2 * k : 2 * k + 2])} at z = {z:.4g} m")
        for k, z in enumerate(result.planes)
    ]
    handles += [
        Line2D([], [], color="0.3", label="in x, along the force"),
        Line2D([], [], color="0.3", ls=DASHED, lw=0.7, label="in y, across"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
