"""Full, condensed and coarse model of the rig."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.presentation.style import BLUE, DASHED, GREEN, ORANGE, TITLE_SIZE, StyledFigure
from bath_thesis.studies.reduced_models import CONDENSED, DRAWN, FULL, ModelReduction

MODEL_STYLES: dict[str, dict[str, Any]] = dict(
    zip(
        DRAWN,
        (
            {"color": "0.3", "lw": 1.0},
            {"color": ORANGE, "ls": ":", "lw": 1.8},
            {"color": BLUE, "ls": DASHED, "lw": 1.0},
        ),
        strict=True,
    )
)
FLOOR = 1e-5  # %, below which an error is drawn there


def draw(result: ModelReduction) -> Figure:
    """Draw frequencies (Fig. 3.6), unbalance response (Fig. 3.7), its error, and the errors of all models."""
    figure = StyledFigure(figsize=(9.0, 7.2), layout="constrained")
    (frequencies, response), (errors, deviation) = figure.subplots(2, 2)
    speeds = result.speeds
    for model, style in MODEL_STYLES.items():
        matches = result.models[model]
        frequencies.plot(speeds, matches.frequencies.T, **style)
        response.semilogy(speeds, matches.displacement, **style)
        if model != FULL:
            error = 100.0 * (matches.displacement / result.models[FULL].displacement - 1.0)
            deviation.semilogy(speeds, np.maximum(np.abs(error), FLOOR), **style)
    frequencies.plot(speeds, speeds, color=GREEN, lw=0.8)
    frequencies.set(ylabel="damped frequency (rad/s)", ylim=(0.0, speeds[-1]), title="frequencies (Fig. 3.6)")
    response.set(ylabel="largest amplitude (m)", title=f"{1e3 * result.unbalance:.3g} g m on D1 (Fig. 3.7)")
    deviation.set(ylabel="amplitude against 13 nodes (%)", title="error of the response")
    for axes in (frequencies, response, deviation):
        axes.set(xlabel=r"spin speed $\Omega$ (rad/s)", xlim=(0.0, speeds[-1]))
        axes.grid(color="0.9", lw=0.5)
    _draw_errors(errors, result)
    handles = [
        Line2D([], [], label=f"{model.replace('_', ' ')}, {result.models[model].coordinates} coordinates", **style)
        for model, style in MODEL_STYLES.items()
    ]
    handles.append(Line2D([], [], color=GREEN, lw=0.8, label="synchronous line"))
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    figure.suptitle("Reduced models of the rig, diagonal mass", fontsize=TITLE_SIZE)
    return figure


def _draw_errors(axes: Axes, result: ModelReduction) -> None:
    """Draw the mean errors of the frequencies of each model, computed and in the thesis."""
    labels = []
    rows = [(model, mass, row) for model, by_mass in result.mean_errors.items() for mass, row in by_mass.items()]
    rows = [row for row in rows if row[2].computed > 0.0]
    for place, (model, mass, row) in enumerate(rows):
        labels.append(f"{model.replace('_', ' ') if model != CONDENSED else model}, {mass}")
        axes.plot(row.computed, place, "o", color=BLUE, ms=4.5)
        if row.thesis is not None:
            axes.plot(row.thesis, place, "s", color=ORANGE, mfc="none", ms=5.5)
    axes.set_xscale("log")
    axes.set_yticks(range(len(rows)), labels)
    axes.invert_yaxis()
    axes.grid(axis="x", color="0.9", lw=0.5)
    axes.set(xlabel="mean error of eight frequencies (%)", title="errors against 23 nodes (Figs 3.4, 3.5)")
    handles = [
        Line2D([], [], color=BLUE, ls="", marker="o", ms=4.5, label="computed"),
        Line2D([], [], color=ORANGE, ls="", marker="s", mfc="none", ms=5.5, label="thesis"),
    ]
    axes.legend(handles=handles, loc="upper left")
