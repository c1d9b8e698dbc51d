"""Touches of the stators of magnetic bearings over a run, computed from a data set."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.contact_forces import largest_averaged_force, peak_force, touches
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import at_every_step, cycles


@dataclass(frozen=True)
class StatorTouch:
    """Touches of a stator from cycle 0 on.

    Attributes
    ----------
    bearing
        The magnetic bearing.
    first
        End of the first step with contact (s from cycle 0).
    force
        Largest normal force averaged over 1 ms, including impacts (N); None if not recorded.
    peak
        Largest normal force without impacts (N); None if not recorded.
    """

    bearing: str
    first: Annotated[float, "s"]
    force: Annotated[float | None, "N"]
    peak: Annotated[float | None, "N"]


def stator_touches(dataset: Signals) -> dict[str, StatorTouch]:
    """Return the touches of each stator that the rotor has touched, by contact site, earliest touch first."""
    steps, result = at_every_step(dataset), {}
    for site, bearing in places(dataset).stators.items():
        touching = touches(steps, site) & (cycles(steps) >= 0.0)
        if touching.any():
            first = float(steps["time"].values[np.argmax(touching)])
            result[site] = StatorTouch(bearing, first, largest_averaged_force(steps, site), peak_force(steps, site))
    return dict(sorted(result.items(), key=lambda item: item[1].first))
