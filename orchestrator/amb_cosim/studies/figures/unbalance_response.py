"""Amplitude and phase of a rotor under unbalance."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from amb_cosim.presentation.style import BLUE, DASHED, GREEN, ORANGE, PURPLE, TITLE_SIZE, StyledFigure
from amb_cosim.studies.unbalance_over_speed import UnbalanceResponse


def draw(result: UnbalanceResponse) -> Figure:
    """Draw amplitude, with the clearance, and phase over the spin speed."""
    figure = StyledFigure(figsize=(7.0, 5.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    speeds, clearance = result.speeds, 1e3 * result.clearance
    for (label, place), colour in zip(result.places.items(), (BLUE, ORANGE, GREEN, PURPLE), strict=False):
        top.plot(speeds, 1e3 * place.amplitude, color=colour, label=label)
        bottom.plot(speeds, np.degrees(place.phase), color=colour)
    top.axhline(clearance, color="black", lw=0.9, ls=DASHED, label=f"clearance {clearance:.3g} mm")
    top.set(ylabel="amplitude (mm)", ylim=(0.0, None), xlim=(0.0, speeds[-1]))
    bottom.set(ylabel="phase (deg)", xlabel=r"spin speed $\Omega$ (rad/s)")
    bottom.yaxis.set_major_locator(MultipleLocator(90.0))
    bottom.grid(axis="y", color="0.9", lw=0.6)
    figure.legend(loc="outside lower center", ncols=3)
    title = f"{result.rotor}: steady response to {1e3 * result.unbalance:.4g} g m at node {result.node}"
    figure.suptitle(title, fontsize=TITLE_SIZE)
    return figure
