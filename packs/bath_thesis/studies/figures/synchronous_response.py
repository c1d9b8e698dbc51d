"""Norm of the synchronous response, modelled and measured."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter, ScalarFormatter

from amb_cosim.presentation.style import BLUE, DASHED, ORANGE, TITLE_SIZE, StyledFigure
from bath_thesis.studies.measured_response import SynchronousResponse

COLOURS = (BLUE, ORANGE)


def draw(result: SynchronousResponse) -> Figure:
    """Draw S for forces in x over frequency, on linear and on logarithmic axes, measured values as crosses."""
    figure = StyledFigure(figsize=(8.4, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True)
    at = result.at_speeds
    displayed = list(zip(range(0, len(result.forces), 2), COLOURS, strict=False))
    for axes in (left, right):
        for k, colour in displayed:
            axes.plot(result.speeds, 1e6 * result.norm[:, k], color=colour)
            axes.plot(result.speeds, 1e6 * result.norm_without_conjugate[:, k], color=colour, ls=":", lw=0.8)
            axes.plot(at.speeds, 1e6 * at.measured[:, k], "x", color=colour, ms=5.0, mew=1.2)
        axes.plot(result.speeds, 1e6 * result.thesis, color="black", ls=DASHED)
        axes.set(xlabel="frequency (Hz)", xlim=(0.0, result.speeds[-1]))
        axes.grid(color="0.9", lw=0.5)
    left.set(ylabel=r"$S$ ($\mu$m/N)", ylim=(0.0, None))
    right.set_yscale("log")
    right.set_yticks([0.2, 0.5, 1.0, 2.0, 5.0])
    right.yaxis.set_major_formatter(ScalarFormatter())
    right.yaxis.set_minor_formatter(NullFormatter())
    handles = [Line2D([], [], color=colour, label=f"force {result.forces[k]}, model") for k, colour in displayed]
    handles += [
        Line2D([], [], color="0.3", ls="", marker="x", ms=5.0, mew=1.2, label="measured in co-simulation"),
        Line2D([], [], color="0.3", ls=":", label="model, (5.18) without the conjugate"),
        Line2D([], [], color="black", ls=DASHED, label="thesis (5.19)"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    figure.suptitle(f"{result.rotor}: norm of the synchronous response of the sensors", fontsize=TITLE_SIZE)
    return figure
