"""Campbell diagram of a levitated machine."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from amb_cosim.presentation.style import TITLE_SIZE, StyledFigure
from amb_cosim.studies.closed_loop_poles import ClosedLoopPoles
from amb_cosim.studies.figures.whirl import WHIRL_STYLES


def draw(result: ClosedLoopPoles) -> Figure:
    """Draw damped frequencies with the synchronous line above, and logarithmic decrements below."""
    figure = StyledFigure(figsize=(7.0, 6.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    speeds = result.speeds
    for pole in result.poles:
        for whirl, (colour, line) in WHIRL_STYLES.items():
            selected = np.array([direction == whirl for direction in pole.whirl])
            for axes, values in ((top, pole.frequencies), (bottom, pole.decrements)):
                axes.plot(speeds, np.where(selected, values, np.nan), color=colour, ls=line)
    highest = float(np.nanmax([pole.frequencies for pole in result.poles], initial=1.0))
    top.plot(speeds, speeds, color="black", lw=0.8, ls=":")
    top.set(ylabel="damped frequency (rad/s)", ylim=(0.0, 1.08 * highest), xlim=(0.0, speeds[-1]))
    decrements = np.array([pole.decrements for pole in result.poles])
    bottom.set_yscale("symlog", linthresh=0.1)
    lowest = min(0.0, 1.5 * float(np.nanmin(decrements, initial=0.0)))
    bottom.set(ylabel="logarithmic decrement", xlabel=r"spin speed $\Omega$ (rad/s)", ylim=(lowest, None))
    if lowest < 0.0:
        bottom.axhspan(lowest, 0.0, color="0.93")
        bottom.text(speeds[-1], lowest, "unstable ", ha="right", va="bottom", fontsize=8, color="0.3")
    present = {whirl for pole in result.poles for whirl in pole.whirl}
    handles = [
        Line2D([], [], color=c, ls=ls, label=f"{w} whirl") for w, (c, ls) in WHIRL_STYLES.items() if w in present
    ]
    handles += [Line2D([], [], color="black", lw=0.8, ls=":", label=r"synchronous, $\omega = \Omega$")]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    figure.suptitle(f"{result.scenario}: vibrations of the sampled loop over speed", fontsize=TITLE_SIZE)
    return figure
