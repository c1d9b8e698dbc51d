"""Campbell diagram."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_analysis.studies.campbell_diagram import CampbellDiagram
from amb_analysis.studies.figures.over_speed import (
    SIZE,
    WHIRL_STYLES,
    add_legend,
    draw_over_speed,
    draw_zones,
    hatch_extrapolated,
    label_points,
    with_frozen,
)
from amb_cosim.presentation.style import StyledFigure, write_title
from amb_cosim.presentation.units import speed_unit


def draw(diagram: CampbellDiagram) -> Figure:
    """Draw the damped frequencies, with the lines 1x and 2x and the critical speeds, above the damping ratios."""
    unit, operating = speed_unit(), diagram.operating_speed
    vibrations = [(mode.whirl, mode.frequencies, mode.damping_ratios) for mode in diagram.modes]
    figure = StyledFigure(figsize=SIZE, layout="constrained")
    top, bottom = draw_over_speed(figure, diagram.speeds, vibrations, operating)
    points = []
    for critical in diagram.critical_speeds:
        colour, _ = WHIRL_STYLES[critical.whirl]
        at = critical.speed / unit.size
        top.plot(at, at, "o", ms=3.5, color=colour)
        points.append((at, at, f"{critical.mode}: {unit.number(critical.speed)}", colour))
    label_points(top, points)
    bottom.set_ylabel(r"damping ratio $\zeta$")
    draw_zones(bottom, [mode.damping_ratios for mode in diagram.modes], is_decrement=False)
    mark = Line2D([], [], color="0.3", ls="", marker="o", ms=3.5, label="mode: critical speed")
    hatched = hatch_extrapolated((top, bottom), diagram.speeds, diagram.limits)
    add_legend(figure, vibrations, operating, mark, *hatched)
    support = "free" if diagram.is_free else "on the bearings of its file"
    title = f"{diagram.rotor}, {support}: natural frequencies and damping ratios"
    write_title(figure, with_frozen(title, diagram.limits))
    return figure
