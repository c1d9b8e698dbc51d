"""Campbell diagram."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.presentation.style import TITLE_SIZE
from amb_cosim.studies.campbell_diagram import CampbellDiagram
from amb_cosim.studies.figures.over_speed import add_legend, draw_over_speed, shade_unstable
from amb_cosim.studies.figures.whirl import WHIRL_STYLES


def draw(diagram: CampbellDiagram) -> Figure:
    """Draw damped frequencies with synchronous line and critical speeds above, and damping ratios below."""
    speeds = diagram.speeds
    vibrations = [(mode.whirl, mode.frequencies, mode.damping_ratios) for mode in diagram.modes]
    figure, top, bottom = draw_over_speed(speeds, vibrations)
    for critical in diagram.critical_speeds:
        colour, _ = WHIRL_STYLES[critical.whirl]
        top.plot(critical.speed, critical.speed, "o", ms=3.5, color=colour)
        if critical.whirl != "backward":
            point = (critical.speed, critical.speed)
            top.annotate(f"{critical.speed:.1f} ", point, (-3, 4), textcoords="offset points", ha="right", color=colour)
    top.set_xlim(speeds[0], speeds[-1])
    bottom.set_ylabel(r"damping ratio $\zeta$")
    lowest = min(0.0, 1.1 * float(np.nanmin([mode.damping_ratios for mode in diagram.modes], initial=0.0)))
    shade_unstable(bottom, lowest, speeds[-1])
    add_legend(figure, vibrations, Line2D([], [], color="0.3", ls="", marker="o", ms=3.5, label="critical speed"))
    figure.suptitle(f"{diagram.rotor}: damped natural frequencies and damping ratios", fontsize=TITLE_SIZE)
    return figure
