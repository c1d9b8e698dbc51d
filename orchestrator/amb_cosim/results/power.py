"""When the amplifiers of the magnets are off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.signals import Signals
from amb_cosim.results.places import ACTUATOR, places


def amplifiers_off(dataset: Signals) -> dict[str, NDArray[np.bool_]]:
    """Return the samples in which the amplifier of an axis, `BEARING.x`, is off, for the axes that a run switches."""
    axes = [f"{bearing}.{{}}{axis}" for bearing in places(dataset).magnetic for axis in "xy"]
    labels = {axis.format(""): f"{ACTUATOR}.{axis.format('amplifier_off_')}" for axis in axes}
    return {axis: np.asarray(dataset[label].values, bool) for axis, label in labels.items() if label in dataset}


def without_power(dataset: Signals) -> NDArray[np.bool_]:
    """Return the samples in which the amplifiers of all magnets are off; none without magnets."""
    off = amplifiers_off(dataset)
    if not off or len(off) < 2 * len(places(dataset).magnetic):
        return np.zeros(dataset.sizes["time"], bool)
    return np.all(list(off.values()), axis=0)
