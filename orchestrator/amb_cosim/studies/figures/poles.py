"""Campbell diagram of a levitated machine."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from amb_cosim.presentation.style import TITLE_SIZE
from amb_cosim.studies.closed_loop_poles import ClosedLoopPoles
from amb_cosim.studies.figures.over_speed import add_legend, draw_over_speed, shade_unstable


def draw(result: ClosedLoopPoles) -> Figure:
    """Draw damped frequencies with the synchronous line above, and logarithmic decrements below."""
    speeds = result.speeds
    vibrations = [(pole.whirl, pole.frequencies, pole.decrements) for pole in result.poles]
    figure, top, bottom = draw_over_speed(speeds, vibrations)
    top.set_xlim(0.0, speeds[-1])
    bottom.set_yscale("symlog", linthresh=0.1)
    bottom.set_ylabel("logarithmic decrement")
    lowest = min(0.0, 1.5 * float(np.nanmin([pole.decrements for pole in result.poles], initial=0.0)))
    shade_unstable(bottom, lowest, speeds[-1])
    add_legend(figure, vibrations)
    figure.suptitle(f"{result.scenario}: vibrations of the sampled loop over speed", fontsize=TITLE_SIZE)
    return figure
