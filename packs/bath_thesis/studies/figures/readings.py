"""Misfit of the readings of each chapter."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_cosim.presentation.style import BLUE, GREY, TITLE_SIZE, StyledFigure
from bath_thesis.studies.thesis_readings import Readings


def draw(result: Readings) -> Figure:
    """Draw a bar for each reading, and the first reading's misfit as a line."""
    counts = [len(of) for of in result.misfit.values()]
    figure = StyledFigure(figsize=(7.6, 1.2 + 0.3 * sum(counts) + 0.6 * len(counts)), layout="constrained")
    axes = figure.subplots(len(counts), 1, sharex=True, squeeze=False, height_ratios=counts)[:, 0]
    for ax, (chapter, of) in zip(axes, result.misfit.items(), strict=True):
        first, *_ = of.values()
        ax.barh(range(len(of)), list(of.values()), color=[BLUE if value <= first else GREY for value in of.values()])
        for place, (name, value) in enumerate(of.items()):
            ax.text(value, place, f" {value:.2f}, {result.met[chapter][name]} met", va="center", fontsize=8)
        ax.axvline(first, color="0.3", lw=0.7, ls="--")
        ax.set_yticks(range(len(of)), list(of))
        ax.set_title(f"chapter {chapter}, {len(result.rows[chapter])} statements")
        ax.invert_yaxis()
        ax.margins(x=0.2)
    axes[-1].set_xlabel("mean misfit: |ln(ours/theirs)|, 1 for a different outcome")
    figure.suptitle("Readings against the statements of the thesis", fontsize=TITLE_SIZE)
    return figure
