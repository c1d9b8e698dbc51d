"""Campbell diagram."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.presentation.style import TITLE_SIZE, StyledFigure
from amb_cosim.studies.campbell_diagram import CampbellDiagram
from amb_cosim.studies.figures.whirl import WHIRL_STYLES


def draw(diagram: CampbellDiagram) -> Figure:
    """Draw damped frequencies with synchronous line and critical speeds above, and damping ratios below."""
    figure = StyledFigure(figsize=(7.0, 6.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    speeds = diagram.speeds
    for mode in diagram.modes:
        for whirl, (colour, line) in WHIRL_STYLES.items():
            selected = np.array([direction == whirl for direction in mode.whirl])
            for axes, values in ((top, mode.frequencies), (bottom, mode.damping_ratios)):
                axes.plot(speeds, np.where(selected, values, np.nan), color=colour, ls=line)
    highest = float(np.nanmax([mode.frequencies for mode in diagram.modes], initial=1.0))
    top.plot(speeds, speeds, color="black", lw=0.8, ls=":")
    for critical in diagram.critical_speeds:
        colour, _ = WHIRL_STYLES[critical.whirl]
        top.plot(critical.speed, critical.speed, "o", ms=3.5, color=colour)
        if critical.whirl != "backward":
            point = (critical.speed, critical.speed)
            top.annotate(f"{critical.speed:.1f} ", point, (-3, 4), textcoords="offset points", ha="right", color=colour)
    top.set(ylabel="damped frequency (rad/s)", ylim=(0.0, 1.08 * highest), xlim=(speeds[0], speeds[-1]))
    lowest = min(0.0, 1.1 * float(np.nanmin([mode.damping_ratios for mode in diagram.modes], initial=0.0)))
    bottom.set(ylabel=r"damping ratio $\zeta$", xlabel=r"spin speed $\Omega$ (rad/s)", ylim=(lowest, None))
    if lowest < 0.0:
        bottom.axhspan(lowest, 0.0, color="0.93")
        bottom.text(speeds[-1], lowest, "unstable ", ha="right", va="bottom", fontsize=8, color="0.3")
    present = {whirl for mode in diagram.modes for whirl in mode.whirl}
    handles = [
        Line2D([], [], color=WHIRL_STYLES[w][0], ls=WHIRL_STYLES[w][1], label=f"{w} whirl")
        for w in WHIRL_STYLES
        if w in present
    ]
    handles += [
        Line2D([], [], color="black", lw=0.8, ls=":", label=r"synchronous, $\omega = \Omega$"),
        Line2D([], [], color="0.3", ls="", marker="o", ms=3.5, label="critical speed"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    figure.suptitle(f"{diagram.rotor}: damped natural frequencies and damping ratios", fontsize=TITLE_SIZE)
    return figure
