"""Test force of an identification."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.presentation.style import BLUE, DASHED, ORANGE, TITLE_SIZE, StyledFigure
from array_types import Array
from bath_thesis.studies.identification_force import INTENDED, IdentificationForce


def draw(result: IdentificationForce) -> Figure:
    """Draw S, amplitude of the force, revolutions of a slot, duration of an identification and response."""
    figure = StyledFigure(figsize=(8.0, 8.0), layout="constrained")
    rows = figure.subplots(3, 2, sharex=True)
    panels = rows[:2]
    thesis, jump = result.at_the_speeds_of_the_thesis, result.at_the_jump.frequencies
    frequencies = result.columns.frequencies
    displayed = thesis.frequencies <= frequencies[-1]
    for axes, (name, label) in zip(
        panels.flat,
        {
            "s": "S",
            "amplitude": "amplitude A of the force (N)",
            "periods_per_slot": r"periods of a slot, $N_\mathrm{per}$",
            "t_halt": r"ROLAC halts for $t_\mathrm{halt}$ (s)",
        }.items(),
        strict=True,
    ):
        values = getattr(result.columns, name)
        if len(jump) and name in ("s", "amplitude"):
            after = int(np.searchsorted(frequencies, jump[-1]))
            _draw_with_jump(axes, frequencies, values, after)
        else:
            axes.plot(frequencies, values, color=BLUE)
        axes.plot(thesis.frequencies[displayed], getattr(thesis, name)[displayed], "s", color=ORANGE, ms=3.0)
        axes.set(ylabel=label, ylim=(0.0, 1.08 * values.max()), xlim=(frequencies[0], frequencies[-1]))
        axes.grid(color="0.9", lw=0.5)
    _draw_responses(rows[2], result)
    handles = [
        Line2D([], [], color=BLUE, label="as the controller computes it"),
        Line2D([], [], color=ORANGE, ls="", marker="s", ms=3.0, label="speeds of the thesis"),
        Line2D([], [], color=BLUE, ls="", marker="o", ms=4.0, mfc="white", label="jump: limit from below"),
        Line2D([], [], color=BLUE, ls="", marker="o", ms=4.0, label="value from there"),
    ]
    figure.legend(handles=handles[: 4 if len(jump) else 2], loc="outside lower center", ncols=4)
    figure.suptitle("Test force of an identification", fontsize=TITLE_SIZE)
    return figure


def _draw_with_jump(axes: Axes, frequencies: Array, values: Array, after: int) -> None:
    """Draw a curve in two parts, the second from the index `after`, and both values at the jump."""
    axes.plot(frequencies[:after], values[:after], color=BLUE)
    axes.plot(frequencies[after:], values[after:], color=BLUE)
    for index, other, fill in ((after - 1, after, "white"), (after, after - 1, BLUE)):
        point = (frequencies[index], values[index])
        axes.plot(*point, "o", color=BLUE, ms=4.0, mfc=fill)
        offset = (6, 4 if values[index] > values[other] else -11)
        axes.annotate(f"{values[index]:.3g}", point, offset, textcoords="offset points", fontsize=8)


def _draw_responses(panels: Sequence[Axes], result: IdentificationForce) -> None:
    """Draw the response of the journal in each bearing, and the response intended by the thesis."""
    columns, frequencies = result.columns, result.columns.frequencies
    jump = result.at_the_jump.frequencies
    after = int(np.searchsorted(frequencies, jump[-1])) if len(jump) else len(frequencies)
    for axes, name in zip(panels, ("response_mb1", "response_mb2"), strict=True):
        values = 1e3 * getattr(columns, name)
        for part in (slice(after), slice(after, None)):
            axes.plot(frequencies[part], values[part], color=BLUE)
        axes.axhline(1e3 * INTENDED, color="black", lw=0.9, ls=DASHED)
        axes.annotate("intended", (frequencies[0], 1e3 * INTENDED), (4, 3), textcoords="offset points", fontsize=8)
        axes.set(xlabel="frequency (Hz)", ylabel=f"{name[-3:].upper()} moves by (mm)", ylim=(0.0, 1.08 * values.max()))
        axes.grid(color="0.9", lw=0.5)
