"""Curves of a contact force: a thick line for the 1 ms mean, a pale one for the peaks, a mark at the largest mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import spread, write_in_corner
from amb_cosim.presentation.units import ShownUnit, force_unit
from amb_cosim.results.contact_forces import averaged_force, peaks
from amb_cosim.results.signal_arrays import cycles
from array_types import Array

PALE = 0.45  # opacity of peaks
THICK, THIN = 1.6, 0.7  # points, of a mean and of peaks
REACH, ENLARGED_REACH = 2.0, 10.0  # end of the axis over the largest mean; higher peaks are marked and written
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
    """Draw forces over time, each in its colour; `mark_forces` sets the limits of the axis."""
    unit = _unit_of(forces)
    for times, force, colour in forces:
        panel.plot(times, unit.of(force.peak), color=colour, alpha=PALE, lw=THIN, zorder=1.9)
        panel.plot(times, unit.of(force.mean), color=colour, lw=THICK)
    panel.set_ylabel(f"$N$ ({unit.label})")


def mark_forces(panel: Axes, forces: list[tuple[Array, SiteForce, str]], reach: float = REACH) -> None:
    """Mark the forces that the summary states and the peaks beyond the axis, with their values.

    Only forces and peaks within the time limits of the panel are marked, and only these set its force axis, so that the
    first impacts keep their scale if a later force is larger. The axis extends to the highest of these peaks, but at
    most to `reach` times the largest mean between the limits.
    """
    unit, (begin, end) = _unit_of(forces), panel.get_xlim()
    visible = [(begin <= times) & (times <= end) for times, _, _ in forces]
    shown = [(times, np.where(at, force.peak, np.nan)) for at, (times, force, _) in zip(visible, forces, strict=True)]
    highest = [float(np.nanmax(peak, initial=0.0)) for _, peak in shown]
    means = [float(np.nanmax(force.mean[at], initial=0.0)) for at, (_, force, _) in zip(visible, forces, strict=True)]
    mean = max(means) or max(highest) or max(force.marked[1] for _, force, _ in forces)
    top = ROOM * max(min(max(highest), reach * mean), mean) / unit.size
    panel.set_ylim(0.0, top)
    cut = [k for k, peak in enumerate(highest) if peak > top * unit.size]
    for line, k in enumerate(cut):
        (times, peak), colour = shown[k], forces[k][2]
        panel.plot(times[np.nanargmax(peak)], top, "^", ms=4.5, color=colour, zorder=4, clip_on=False)
        text = f"peaks up to {force_unit(highest[k]).text(highest[k], 3)}, off the scale"
        write_in_corner(panel, text, colour, line)
    places = [(float(times[force.marked[0]]), force.marked[1], colour) for times, force, colour in forces]
    places = [place for place in places if begin <= place[0] <= end]
    heights = spread([force / unit.size for _, force, _ in places], LETTERS * top, 0.0, (1.0 - 0.5 * LETTERS) * top)
    for (at, force, colour), height in zip(places, heights, strict=True):
        panel.plot(at, force / unit.size, "o", ms=4.5, mfc="white", mec=colour, zorder=4, clip_on=False)
        side = "left" if at < begin + 0.8 * (end - begin) else "right"
        shift = (6 if side == "left" else -6, 0)
        style: dict[str, Any] = {"ha": side, "va": "center", "fontsize": 8, "color": colour, "zorder": 5}
        style["path_effects"] = [withStroke(linewidth=2.0, foreground="white")]
        text = force_unit(force).text(force, 3)
        panel.annotate(text, (at, height), shift, textcoords="offset points", **style)


def _unit_of(forces: list[tuple[Array, SiteForce, str]]) -> ShownUnit:
    """Return the unit of the force axis, which is the same for all parts of a run."""
    return force_unit(max(force.marked[1] for _, force, _ in forces))
