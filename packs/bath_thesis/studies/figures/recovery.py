"""Recovery from contact by control and unbalance."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from amb_cosim.presentation.style import StyledFigure, write_title
from amb_cosim.presentation.units import SIZES, speed_unit
from bath_thesis.studies.contact_recovery import ControlComparison, RecoveryStatistics


def draw(result: ControlComparison) -> Figure:
    """Draw the share of runs that recover for each control and unbalance, and write their median duration."""
    controls = result.controls
    shares = np.array([[cell.recovered_share for cell in cells] for cells in controls.values()])
    figure = StyledFigure(figsize=(7.6, 1.6 + 0.27 * len(controls)), layout="constrained")
    panel = figure.subplots()
    panel.imshow(shares, cmap="Greens", vmin=0.0, vmax=1.6, aspect="auto")
    for row, cells in enumerate(controls.values()):
        for column, cell in enumerate(cells):
            size = 8.0 if cell.recovered_share in (0.0, 1.0) else 6.5
            panel.text(column, row, _text(cell), ha="center", va="center", fontsize=size, linespacing=0.9)
    names = [control.partition(",")[0] for control in controls]
    for row in range(1, len(names)):
        if names[row] != names[row - 1]:
            panel.axhline(row - 0.5, color="0.3", lw=0.8)
    panel.set_yticks(range(len(controls)), list(controls))
    panel.set_xticks(range(shares.shape[1]), [f"{1e3 * value:g}" for value in result.added])
    panel.tick_params(length=0)
    panel.set_xlabel(f"unbalance added on D1 (g m), before multiplication by {result.unbalance_factor:g}")
    panel.set_title(
        "number: cycles from the step to the last contact (median); dash: no contact;\n"
        f"white cell: still trapped at cycle {result.end_cycle:g}",
        fontsize=8,
    )
    at = speed_unit().text(SIZES["speed"]["Hz"] * result.spin_frequency)
    write_title(figure, f"Recovery from contact at {at} for each control, adaptation rate and H")
    return figure


def _text(cell: RecoveryStatistics) -> str:
    """Return the median number of cycles to the last contact, and the share of recovered runs unless it is 100 %."""
    if cell.median_cycles is None:
        return ""
    cycles = f"{cell.median_cycles:.1f}" if cell.median_cycles > 0.0 else "-"
    return cycles if cell.recovered_share == 1.0 else f"{cycles}\n{100.0 * cell.recovered_share:.0f} %"
