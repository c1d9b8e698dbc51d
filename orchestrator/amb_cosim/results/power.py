"""Times at which the amplifiers of the magnets are off."""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.component_names import ACTUATOR
from amb_cosim.results.places import places
from amb_cosim.results.series import cycles
from array_types import Bools


def amplifiers_off(dataset: Signals) -> list[Bools]:
    """Return the samples in which the amplifier is off, for each axis of a magnet with a switched amplifier."""
    magnets = places(dataset).magnetic
    labels = [f"{ACTUATOR}.{magnet}.amplifier_off_{axis}" for magnet in magnets for axis in "xy"]
    return [np.asarray(dataset[label].values, bool) for label in labels if label in dataset]


def without_power(dataset: Signals) -> Bools:
    """Return the samples in which the amplifiers of all magnets are off; none without magnets."""
    off = amplifiers_off(dataset)
    if not off or len(off) < 2 * len(places(dataset).magnetic):
        return np.zeros(dataset.sizes["time"], bool)
    return np.all(off, axis=0)


def power_lost_at(dataset: Signals) -> float | None:
    """Return the cycle from which no magnet has power until the end; None if a magnet has power, or without magnets."""
    off = without_power(dataset)
    if not off.any() or not off[-1]:
        return None
    powered = np.flatnonzero(~off)
    return float(cycles(dataset)[powered[-1] + 1 if len(powered) else 0])
