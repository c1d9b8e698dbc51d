"""Mode shapes of a rotor."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.interpolate import CubicHermiteSpline

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, is_extrapolated
from amb_analysis.studies.figures.over_speed import WHIRL_STYLES, with_frozen
from amb_analysis.studies.natural_modes import ModeShapes
from amb_cosim.presentation.style import DASHED, StyledFigure, write_title
from amb_cosim.presentation.units import frequency_unit, spin_text
from rotor_analysis.modes import Mode
from rotor_analysis.rotor import Rotor

DRAWN = 4  # speeds, at most


def draw(result: ModeShapes) -> Figure:
    """Draw the mode shapes in three dimensions: the deflected axis, and the orbits of the ends, bodies and bearings.

    Each orbit begins at a dot on the deflected axis and ends before a full turn, so that its direction is visible. Each
    speed has its own rows. If there are more than `DRAWN` speeds, only the first and the last are drawn, and the title
    names them.
    """
    rotor, speeds = result.description, list(result.modes)
    speeds = speeds if len(speeds) <= DRAWN else [speeds[0], speeds[-1]]
    columns = min(max(len(result.modes[speed]) for speed in speeds), 4) or 1
    places, rows = list[tuple[float, int, int]](), 0
    for speed in speeds:
        places += [(speed, k, rows * columns + k + 1) for k in range(len(result.modes[speed]))]
        rows += -(-len(result.modes[speed]) // columns) or 1
    height = 2.4 * rows + 0.9
    figure = StyledFigure(figsize=(max(3.1 * columns, 6.2), height))
    figure.subplots_adjust(0.0, 0.55 / height, 0.97, 1.0 - 0.5 / height, wspace=0.0, hspace=0.2)
    for speed, k, place in places:
        mode, kind = result.modes[speed][k], result.shapes[speed][k].kind
        axes = figure.add_subplot(rows, columns, place, projection="3d", computed_zorder=False)
        _draw_mode(axes, rotor, mode)
        at = "" if len(speeds) == 1 else f"at {spin_text(speed)}, "
        axes.set_title(
            f"{at}{k + 1}: {kind}, {mode.whirl}\n"
            f"{frequency_unit().text(mode.frequency)}, $\\zeta$ = {mode.damping_ratio:z.3f}",
            y=0.94,
        )
    handles = [
        Line2D([], [], color="0.6", lw=0.8, ls=DASHED, label="axis at rest"),
        Line2D([], [], color="black", marker="o", ms=4, ls="", label="body"),
        Line2D([], [], color="black", marker="^", ms=5, mfc="white", ls="", label="bearing"),
        Line2D([], [], color="0.3", lw=1.4, label="deflected axis"),
    ]
    handles += [
        Line2D([], [], color=colour, label=f"{whirl} orbit")
        for whirl, (colour, _) in WHIRL_STYLES.items()
        if any(result.modes[speed][k].whirl == whirl for speed, k, _ in places)
    ]
    figure.legend(handles=handles, loc="lower center", ncols=len(handles) if columns > 2 else 3)
    limits = result.frequencies.limits
    marks = (f" (coefficients {EXTRAPOLATED})" if is_extrapolated(limits, speed) else "" for speed in speeds)
    at = ", ".join(f"{spin_text(speed)}{mark}" for speed, mark in zip(speeds, marks, strict=True))
    title = with_frozen(f"{rotor.name}: modes at {at}", limits)
    write_title(figure, title)
    return figure


def _draw_mode(axes: Any, rotor: Rotor, mode: Mode) -> None:
    """Draw a mode shape in three-dimensional axes."""
    z = np.array(rotor.shaft.nodes)
    colour, _ = WHIRL_STYLES[mode.whirl]
    fine_z = np.linspace(z[0], z[-1], 200)
    x, y, slope_x, slope_y = mode.shape.reshape(-1, 4).T
    line_x, line_y = (CubicHermiteSpline(z, value, slope)(fine_z) for value, slope in ((x, slope_x), (y, slope_y)))
    largest = max(np.max(np.abs(line_x)), np.max(np.abs(line_y)))
    x, y, line_x, line_y = x / largest, y / largest, line_x / largest, line_y / largest
    axes.plot(z[[0, -1]], [0, 0], [0, 0], color="0.6", lw=0.8, ls=DASHED)
    rotation = np.exp(1j * np.linspace(0.0, 0.88 * 2.0 * np.pi, 80))
    for node in sorted({1, len(z), *rotor.bearing_nodes, *(body.node for body in rotor.bodies)}):
        k = node - 1
        axes.plot(np.full(len(rotation), z[k]), (x[k] * rotation).real, (y[k] * rotation).real, color=colour, lw=0.9)
        axes.plot(z[k], x[k].real, y[k].real, "o", color=colour, ms=2.5)
    axes.plot(fine_z, line_x.real, line_y.real, color="0.3", lw=1.4)
    for parts, style in (
        (rotor.bodies, {"marker": "o", "ms": 3}),
        (rotor.bearings, {"marker": "^", "ms": 5, "mfc": "white"}),
    ):
        at = [z[part.node - 1] for part in parts]
        axes.plot(at, np.zeros(len(at)), np.zeros(len(at)), ls="", color="black", **style)
    axes.set(xlim=(z[0], z[-1]), ylim=(-1, 1), zlim=(-1, 1), xlabel="$z$ (m)")
    axes.set_yticks([], [])
    axes.set_zticks([], [])
    axes.set_ylabel("$x$", labelpad=-12)
    axes.text(z[-1], 1.0, 0.9, " $y$", ha="left", va="top")  # beside its axis; a label would stand in the next panel
    axes.tick_params(axis="x", labelsize=7, pad=-2)
    axes.set_box_aspect((2.4, 1, 1), zoom=1.25)
    axes.view_init(elev=18, azim=-62)
    axes.grid(visible=False)
    for artist in axes.lines:
        artist.set_clip_on(False)
