"""Marks of what rests on coefficients beyond their tables, or on those of one whirl frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.patches import Patch

from amb_analysis.studies.coefficient_limits import EXTRAPOLATED, Limits, covered_speeds, frozen_at
from amb_cosim.presentation.units import speed_unit
from array_types import Array

HATCH: dict[str, Any] = {"facecolor": "none", "edgecolor": "0.8", "hatch": "////", "lw": 0.0}


def hatch_extrapolated(panels: Sequence[Axes], speeds: Array, limits: Limits) -> list[Patch]:
    """Hatch the speeds (rad/s) that a table of coefficients does not cover, and return their legend, if there are any.

    `speeds` ascend; the panels have the spin speed as their x axis.
    """
    unit, (lowest, highest) = speed_unit(), covered_speeds(limits)
    first, last = float(speeds[0]), float(speeds[-1])
    spans = [(first, min(lowest, last))] if first < lowest else []
    spans += [(max(highest, first), last)] if last > highest else []
    for panel in panels:
        for ends in spans:
            panel.axvspan(*unit.of(ends), zorder=-1, **HATCH)
    return [Patch(label=f"coefficients {EXTRAPOLATED}", **HATCH)] if spans else []


def with_frozen(title: str, limits: Limits) -> str:
    """Return a title with a line for each whirl frequency at which coefficients are frozen."""
    frozen = [item for item in limits if item.whirl_frequency is not None]
    return "\n".join([title, *(f"{', '.join(i.parts)}: {frozen_at(i.whirl_frequency or 0.0)}" for i in frozen)])
