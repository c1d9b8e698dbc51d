"""H, the inverse of the receptance, exact and interpolated."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_cosim.plots.style import BLUE, DASHED, ORANGE, TITLE_SIZE, StyledFigure
from amb_cosim.studies.figures.sensors import PLANE_COLOURS, add_sensor_legend
from amb_cosim.studies.h_interpolation import InverseReceptance

ROUNDING = 1e-9  # %


def draw(result: InverseReceptance) -> Figure:
    """Draw magnitudes of H for forces in x at both bearings, errors of interpolation, and condition number of R."""
    figure = StyledFigure(figsize=(8.4, 7.2), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    speeds, table = result.speeds, result.table
    exact, linear = result.h, result.h_interpolated
    known = np.isin(speeds, table)
    for axes, force in zip(panels[0], (0, 2), strict=True):
        for plane, colour in enumerate(PLANE_COLOURS):
            for axis, line in enumerate(("-", DASHED)):
                element = (slice(None), force, 2 * plane + axis)
                axes.plot(speeds, 1e-6 * np.abs(exact[element]), color=colour, ls=line, lw=0.9 - 0.2 * axis)
                axes.plot(speeds, 1e-6 * np.abs(linear[element]), color="black", ls=":", lw=0.6)
                axes.plot(speeds[known], 1e-6 * np.abs(exact[element])[known], "o", color=colour, ms=2.2)
        axes.set(title=f"force at {result.forces[force]}", ylim=(0.0, None))
    panels[0, 0].set_ylabel("element of H (N/um)")
    panels[0, 1].sharey(panels[0, 0])
    _draw_errors(panels[1, 0], result)
    panels[1, 1].plot(speeds, result.condition_number, color=BLUE)
    panels[1, 1].set(ylabel="condition number of R", ylim=(1.0, None))
    for axes in panels[1]:
        axes.set(xlabel="speed (Hz)", xlim=(speeds[0], speeds[-1]))
    for axes in panels.flat:
        axes.grid(color="0.9", lw=0.5)
        if speeds[-1] > table[-1]:
            axes.axvspan(table[-1], speeds[-1], color="0.95", lw=0.0, zorder=0)
    add_sensor_legend(figure, result.planes)
    figure.suptitle(
        f"{result.rotor}: H over speed; dots: the twelve speeds of the thesis, dotted: linear between them",
        fontsize=TITLE_SIZE,
    )
    return figure


def _draw_errors(axes: Axes, result: InverseReceptance) -> None:
    """Draw the errors of H interpolated in two tables; values of rounding are left out."""
    for name, label, colour in (("thesis", "twelve speeds", ORANGE), ("every_hertz", "every 1 Hz", BLUE)):
        table = result.tables[name]
        for error, line, quantity in (
            (table.relative_error, "-", "error of H"),
            (table.left_by_a_step, DASHED, "|I + H R|"),
        ):
            percent = np.where(100.0 * error > ROUNDING, 100.0 * error, np.nan)
            axes.semilogy(result.speeds, percent, color=colour, ls=line, label=f"{label}: {quantity}")
    axes.set(ylabel="interpolated against exact (%)", ylim=(1e-2, 3e3))
    axes.legend(loc="upper center", ncols=2, columnspacing=1.0, handlelength=1.6)
