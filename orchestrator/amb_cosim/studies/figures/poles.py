"""Campbell diagram of a levitated machine."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_cosim.presentation.style import TITLE_SIZE
from amb_cosim.studies.closed_loop_poles import ClosedLoopPoles
from amb_cosim.studies.figures.over_speed import add_legend, draw_over_speed, draw_zones


def draw(result: ClosedLoopPoles) -> Figure:
    """Draw damped frequencies with the lines 1x and 2x above, and logarithmic decrements below."""
    vibrations = [(pole.whirl, pole.frequencies, pole.decrements) for pole in result.poles]
    figure, _, bottom = draw_over_speed(result.speeds, vibrations, result.operating_speed)
    bottom.set_ylabel("logarithmic decrement")
    draw_zones(bottom, [pole.decrements for pole in result.poles], is_decrement=True)
    add_legend(figure, vibrations, result.operating_speed)
    figure.suptitle(f"{result.scenario}: vibrations of the sampled loop over speed", fontsize=TITLE_SIZE)
    return figure
