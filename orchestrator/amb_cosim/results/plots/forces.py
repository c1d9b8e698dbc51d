"""Curves of a contact force: a thick line for the 1 ms mean, a pale one for the peaks, a mark at the largest mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import spread, write_in_corner
from amb_cosim.presentation.units import force_unit
from amb_cosim.results.contact_forces import averaged_force, peaks
from amb_cosim.results.signal_arrays import cycles
from array_types import Array

PALE = 0.45  # opacity of peaks
THICK, THIN = 1.6, 0.7  # points, of a mean and of peaks
REACH = 2.0  # end of the axis over the largest mean; higher peaks are written
ROOM = 1.18  # above the largest value, for its number
LETTERS = 0.1  # share of an axis' height that a number takes


@dataclass(frozen=True)
class SiteForce:
    """The force (N) at a site at each sample: its largest value in a step, and its mean over the last millisecond.

    A value that was not recorded is NaN. `marked` contains the index of a sample and its force, which the summary
    states: the largest mean from cycle 0 on or, without means, the largest peak.
    """

    peak: Array
    mean: Array
    marked: tuple[int, float]

    def within(self, samples: slice) -> SiteForce:
        """Return the curves of these samples, with the same mark."""
        return SiteForce(self.peak[samples], self.mean[samples], self.marked)

    @property
    def highest(self) -> float:
        """The upper limit of an axis for this force (N); it includes the marked force, but peaks may be higher."""
        return max(min(self.highest_peak, REACH * self.marked[1]), self.marked[1])

    @property
    def highest_peak(self) -> float:
        """The largest force (N)."""
        return float(np.nanmax(self.peak, initial=0.0))


def site_force(dataset: Signals, site: str) -> SiteForce | None:
    """Return the force at a site; None if it was not touched from cycle 0 on."""
    recorded, from_cycle_0 = (peaks(dataset, site), averaged_force(dataset, site)), cycles(dataset) >= 0.0
    peak, mean = (np.full(dataset.sizes["time"], np.nan) if force is None else force for force in recorded)
    for force in (mean, peak):
        after = np.where(from_cycle_0, np.nan_to_num(force), 0.0)
        if after.any():
            at = int(np.argmax(after))
            return SiteForce(peak, mean, (at, float(after[at])))
    return None


def draw_forces(panel: Axes, forces: list[tuple[Array, SiteForce, str]]) -> None:
    """Draw forces over time, each in its colour, on a shared scale that includes the marked forces."""
    end = _end_of(forces)
    unit = force_unit(end)
    top = ROOM * end / unit.size
    for times, force, colour in forces:
        panel.plot(times, unit.of(force.peak), color=colour, alpha=PALE, lw=THIN, zorder=1.9)
        panel.plot(times, unit.of(force.mean), color=colour, lw=THICK)
    panel.set(ylim=(0.0, top), ylabel=f"$N$ ({unit.label})")
    highest = max(force.highest_peak for _, force, _ in forces)
    if highest > top * unit.size:
        write_in_corner(panel, f"peaks to {force_unit(highest).text(highest, 3)}")


def mark_forces(panel: Axes, forces: list[tuple[Array, SiteForce, str]]) -> None:
    """Mark the forces that the summary states, if within the limits of a panel, and write their values beside them."""
    unit, (begin, end) = force_unit(_end_of(forces)), panel.get_xlim()
    places = [(float(times[force.marked[0]]), force.marked[1], colour) for times, force, colour in forces]
    places = [place for place in places if begin <= place[0] <= end]
    top = panel.get_ylim()[1]
    heights = spread([force / unit.size for _, force, _ in places], LETTERS * top, 0.0, (1.0 - 0.5 * LETTERS) * top)
    for (at, force, colour), height in zip(places, heights, strict=True):
        panel.plot(at, force / unit.size, "o", ms=4.5, mfc="white", mec=colour, zorder=4, clip_on=False)
        side = "left" if at < begin + 0.8 * (end - begin) else "right"
        shift = (6 if side == "left" else -6, 0)
        box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5}
        style: dict[str, Any] = {"ha": side, "va": "center", "fontsize": 8, "color": colour, "bbox": box, "zorder": 5}
        text = force_unit(force).text(force, 3)
        panel.annotate(text, (at, height), shift, textcoords="offset points", **style)


def _end_of(forces: list[tuple[Array, SiteForce, str]]) -> float:
    """Return the upper limit of the force axis (N)."""
    return max(force.highest for _, force, _ in forces)
