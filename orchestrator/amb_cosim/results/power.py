"""When the amplifiers of the magnets are off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.places import ACTUATOR, places


def amplifiers_off(dataset: Signals) -> list[NDArray[np.bool_]]:
    """Return for each axis of a magnet whose amplifier a run switches the samples in which it is off."""
    magnets = places(dataset).magnetic
    labels = [f"{ACTUATOR}.{magnet}.amplifier_off_{axis}" for magnet in magnets for axis in "xy"]
    return [np.asarray(dataset[label].values, bool) for label in labels if label in dataset]


def without_power(dataset: Signals) -> NDArray[np.bool_]:
    """Return the samples in which the amplifiers of all magnets are off; none without magnets."""
    off = amplifiers_off(dataset)
    if not off or len(off) < 2 * len(places(dataset).magnetic):
        return np.zeros(dataset.sizes["time"], bool)
    return np.all(off, axis=0)
