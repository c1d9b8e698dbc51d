"""Hysteresis loops of the classical contact laws."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.presentation.style import BLUE, ORANGE, TITLE_SIZE, StyledFigure
from bath_thesis.studies.contact_hysteresis import AS_PRINTED, ContactLaws


def draw(result: ContactLaws) -> Figure:
    """Draw force over penetration of each law, separately for compression and restitution; points A and B as in Fig.
    4.1.
    """
    figure = StyledFigure(figsize=(9.2, 5.4), layout="constrained")
    panels = figure.subplots(2, 4, sharex=True, sharey=True)
    for axes, (name, loop) in zip(panels.flat, result.laws.items(), strict=True):
        delta, force = 1e6 * loop.penetration, 1e-3 * loop.force
        top = int(np.argmax(delta))
        axes.axhline(0.0, color="0.8", lw=0.6)
        axes.plot([0.0, *delta[: top + 1]], [0.0, *force[: top + 1]], color=BLUE)
        axes.plot([*delta[top:], 0.0], [*force[top:], 0.0], color=ORANGE)
        axes.fill(delta, force, color="0.93", lw=0.0, zorder=0)
        if name == AS_PRINTED:
            for label, point in (("A", force[0]), ("B", force[-1])):
                axes.plot(0.0, point, "o", color="black", ms=3.0, clip_on=False)
                axes.annotate(label, (0.0, point), (6, -1 if label == "A" else -5), textcoords="offset points")
        axes.set_title(f"{name.replace('_', ' ')}\n({loop.equation})")
        axes.text(0.97, 0.03, f"e = {loop.restitution:.2f}", transform=axes.transAxes, ha="right", fontsize=8)
    for axes in panels[1]:
        axes.set_xlabel(r"penetration $\delta$ ($\mu$m)")
    for axes in panels[:, 0]:
        axes.set_ylabel("force (kN)")
    handles = [
        Line2D([], [], color=BLUE, label="penetration phase"),
        Line2D([], [], color=ORANGE, label="restitution phase"),
        Line2D([], [], color="0.85", lw=6.0, label="energy lost"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    figure.suptitle(
        f"{result.mass:.3g} kg hits a retainer at {result.speed:g} m/s, "
        f"$k_c$ = {1e-6 * result.k_c:.3g} N/um, damping tuned to e = {result.wanted_restitution:g}",
        fontsize=TITLE_SIZE,
    )
    return figure
