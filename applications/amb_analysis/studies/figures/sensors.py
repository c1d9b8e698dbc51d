"""Colours and legend of the sensors."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.presentation.style import BLUE, DASHED, GREEN, ORANGE, PURPLE

PLANE_COLOURS = (BLUE, ORANGE, GREEN, PURPLE)


def add_sensor_legend(figure: Figure, planes: Sequence[float]) -> None:
    """Add a legend with the colour of each sensor plane, given by its axial position (m), and two line styles."""
    handles = [
        Line2D([], [], color=colour, label=f"s{2 * k + 1}, s{2 * k + 2} at z = {z:.4g} m")
        for k, (colour, z) in enumerate(zip(PLANE_COLOURS, planes, strict=True))
    ]
    handles += [
        Line2D([], [], color="0.3", label="in x, along the force"),
        Line2D([], [], color="0.3", ls=DASHED, lw=0.7, label="in y, across"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
