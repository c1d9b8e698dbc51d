"""Figure of the last contact and the largest contact force of a scenario and of its variations."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_cosim.presentation.style import BLUE, DASHED, ORANGE, StyledFigure, write_title
from amb_cosim.presentation.units import force_unit
from amb_sweeps.robustness import Robustness


def draw(result: Robustness) -> Figure:
    """Plot a line for each variation, orange if its outcome differs from the scenario's."""
    rows = result.rows[::-1]
    forces = [max(row.contact_force.values(), default=0.0) for row in rows]
    unit = force_unit(max(forces))
    figure = StyledFigure(figsize=(7.2, 1.4 + 0.26 * len(rows)), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, values, size in ((left, [row.last_contact for row in rows], 1.0), (right, forces, unit.size)):
        for k, (row, value) in enumerate(zip(rows, values, strict=True)):
            if value is not None:
                axes.plot(value / size, k, "o", color=BLUE if row.outcome == result.outcome else ORANGE, ms=5)
        if values[-1] is not None:
            axes.axvline(values[-1] / size, color="0.6", lw=0.8, ls=DASHED)
        axes.set_xlim(0.0, 1.05 * max((value for value in values if value), default=1.0) / size)
        axes.grid(axis="y", color="0.93", lw=0.6)
    names = [row.changed + (f" ({row.outcome})" if row.outcome != result.outcome else "") for row in rows]
    left.set_yticks(range(len(rows)), names)
    left.set(xlabel="last contact (cycle)", ylim=(-0.6, len(rows) - 0.4))
    right.set(xlabel=f"largest contact force, 1 ms mean ({unit.label})")
    write_title(figure, f"{result.scenario}: {result.outcome}, {result.verdict}")
    return figure
