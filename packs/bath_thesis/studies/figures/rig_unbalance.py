"""Error of the fits of the rig's unbalance, and the amplitudes of the best pair."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from amb_cosim.presentation.style import BLUE, GREY, ORANGE, TITLE_SIZE, StyledFigure
from bath_thesis.studies.unbalance_fit import RigUnbalance


def draw(result: RigUnbalance) -> Figure:
    """Draw the error of each fit, and measured amplitudes next to those of the best pair of discs."""
    figure = StyledFigure(figsize=(7.6, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    best = result.best_pair
    left.barh(
        range(len(result.fits)),
        [fit.error for fit in result.fits],
        color=[BLUE if fit is best else GREY for fit in result.fits],
    )
    left.set_yticks(range(len(result.fits)), [" ".join(fit.discs) for fit in result.fits])
    left.invert_yaxis()
    left.set(xlabel="root mean square of ln(ours/theirs)", title="discs with unbalance")
    places = np.arange(len(result.measured))
    right.bar(places - 0.2, [m.amplitude for m in result.measured], width=0.4, color=GREY, label="thesis")
    right.bar(places + 0.2, best.amplitudes, width=0.4, color=ORANGE, label=" and ".join(best.discs))
    right.set_xticks(places, [f"{m.figure}\n{m.sensor}" for m in result.measured], fontsize=8)
    right.set(ylabel="amplitude under PID (mm)", xlabel="figure, sensor", title="best pair")
    right.legend(loc="upper left")
    figure.suptitle(f"Unbalance of the rig, $K_b$ = {result.k_b:g} N/m", fontsize=TITLE_SIZE)
    return figure
