"""H, the inverse of the receptance, exact and interpolated."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_analysis.studies.figures.sensors import PLANE_COLOURS, add_sensor_legend
from amb_cosim.presentation.style import BLUE, DASHED, ORANGE, TITLE_SIZE, StyledFigure
from bath_thesis.studies.h_interpolation import InverseReceptance
from bath_thesis.studies.printed_h import PrintedH

ROUNDING = 1e-9  # %


def draw(result: InverseReceptance) -> Figure:
    """Draw magnitudes of H for forces in x at both bearings, errors of interpolation, condition number of R, and norms.

    For the rig of the thesis also H at 10 Hz, computed and printed.
    """
    figure = StyledFigure(figsize=(8.4, 9.6), layout="constrained")
    rows = figure.subplots(3, 2)
    panels = rows[:2]
    for axes in panels[0]:
        axes.tick_params(labelbottom=False)
    speeds, table = result.speeds, result.table
    exact, linear = result.h, result.h_interpolated
    available = np.isin(speeds, table)
    for axes, force in zip(panels[0], (0, 2), strict=True):
        for plane, colour in enumerate(PLANE_COLOURS):
            for axis, line in enumerate(("-", DASHED)):
                element = (slice(None), force, 2 * plane + axis)
                axes.plot(speeds, 1e-6 * np.abs(exact[element]), color=colour, ls=line, lw=0.9 - 0.2 * axis)
                axes.plot(speeds, 1e-6 * np.abs(linear[element]), color="black", ls=":", lw=0.6)
                axes.plot(speeds[available], 1e-6 * np.abs(exact[element])[available], "o", color=colour, ms=2.2)
        axes.set(title=f"force at {result.forces[force]}", ylim=(0.0, None))
    panels[0, 0].set_ylabel("element of H (N/um)")
    panels[0, 1].sharey(panels[0, 0])
    _draw_errors(panels[1, 0], result)
    panels[1, 1].plot(speeds, result.condition_number, color=BLUE)
    panels[1, 1].set(ylabel="condition number of R", ylim=(1.0, None))
    _draw_norms(rows[2, 0], result)
    over_speed = [*panels.flat, rows[2, 0]]
    for axes in (*panels[1], rows[2, 0]):
        axes.set_xlabel("speed (Hz)")
    for axes in over_speed:
        axes.set_xlim(speeds[0], speeds[-1])
        axes.grid(color="0.9", lw=0.5)
        if speeds[-1] > table[-1]:
            axes.axvspan(table[-1], speeds[-1], color="0.95", lw=0.0, zorder=0)
    if result.at_10_hz is None:
        rows[2, 1].set_axis_off()
    else:
        _draw_beside_print(rows[2, 1], result.at_10_hz)
    add_sensor_legend(figure, result.planes)
    figure.suptitle(
        f"{result.rotor}: H over speed; dots: the twelve speeds of the thesis, dotted: linear between them",
        fontsize=TITLE_SIZE,
    )
    return figure


def _draw_errors(axes: Axes, result: InverseReceptance) -> None:
    """Draw the errors of H interpolated in two tables, without rounding errors."""
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


def _draw_norms(axes: Axes, result: InverseReceptance) -> None:
    """Draw |H_i| of the forces in x over the speed (Fig. 5.3)."""
    for force, colour in ((0, BLUE), (2, ORANGE)):
        axes.plot(result.speeds, 1e-6 * result.norm_by_force[:, force], color=colour, label=result.forces[force])
    axes.set(ylabel="norm of a row of H (N/um)", ylim=(0.0, None))
    axes.legend(loc="upper left")


def _draw_beside_print(axes: Axes, at_10_hz: PrintedH) -> None:
    """Draw the magnitudes of the elements of H at 10 Hz for the forces in x, computed and printed."""
    signals = np.arange(1, at_10_hz.computed.shape[1] + 1)
    for force, colour, shift in ((0, BLUE, -0.1), (2, ORANGE, 0.1)):
        name = at_10_hz.forces[force]
        axes.plot(
            signals + shift, 1e-6 * at_10_hz.computed[force], "o", color=colour, ms=4.0, label=f"{name}, computed"
        )
        axes.plot(
            signals + shift,
            1e-6 * at_10_hz.printed[force],
            "s",
            color=colour,
            mfc="none",
            ms=5.0,
            label=f"{name}, printed",
        )
    axes.set(xlabel="signal", ylabel="element of H at 10 Hz (N/um)", ylim=(-0.01, 0.38))
    axes.grid(color="0.9", lw=0.5)
    axes.legend(loc="upper center", ncols=2)
