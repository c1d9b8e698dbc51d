"""Recovery from contact by control and unbalance."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from amb_cosim.presentation.style import BLUE, GREY, ORANGE, PURPLE, SKY_BLUE, TITLE_SIZE, YELLOW, StyledFigure
from bath_thesis.studies.contact_recovery import ControlComparison


def draw(result: ControlComparison) -> Figure:
    """Draw the share of runs that recover for each control and unbalance, and median and range of their duration."""
    figure = StyledFigure(figsize=(7.6, 6.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(2, 3))
    controls = result.controls
    shares = 100.0 * np.array([[cell.recovered_share for cell in cells] for cells in controls.values()])
    top.imshow(shares, cmap="Greens", vmin=0.0, vmax=140.0, aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        top.text(column, row, f"{share:.0f}", ha="center", va="center", fontsize=8)
    top.set_yticks(range(len(controls)), list(controls))
    top.tick_params(length=0)
    top.set_title(f"runs free of contact at cycle {result.end_cycle:g} (%)")
    styles = zip(controls.items(), (GREY, PURPLE, YELLOW, SKY_BLUE, ORANGE, BLUE), "xvd^so", strict=True)
    for (control, cells), colour, marker in styles:
        durations = [[run.cycles for run in cell.runs if run.recovered] or [np.nan] for cell in cells]
        middle, low, high = (np.array([f(cycles) for cycles in durations]) for f in (np.median, np.min, np.max))
        style = {"color": colour, "marker": marker, "ms": 4.5, "capsize": 2.0, "elinewidth": 0.7}
        bottom.errorbar(range(len(cells)), middle, (middle - low, high - middle), label=control, **style)
    bottom.set(xlabel="unbalance added on D1 (g m)", ylabel="cycles from step to last contact", ylim=(-1.0, None))
    bottom.set_xticks(range(shares.shape[1]), [f"{1e3 * value:g}" for value in result.added])
    bottom.set_title("median and range; 0 without contact")
    bottom.grid(color="0.9", lw=0.5)
    bottom.legend(loc="upper left")
    figure.suptitle(
        rf"Recovery at {result.speed:g} Hz, unbalances times {result.unbalance_factor:g}, "
        rf"$\alpha$ = {result.alpha:g} 1/s, {result.instants} instants of the step",
        fontsize=TITLE_SIZE,
    )
    return figure
