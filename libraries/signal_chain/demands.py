"""The digital-to-analogue converters of the demands: what they can show, and how finely."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel
from signal_chain.converters import quantised, resolution
from signal_chain.presets import is_on


class Limits(NamedTuple):
    """Least and largest demand."""

    low: float
    high: float


@kernel
def within_converter(low: float, high: float, chain: np.record) -> Limits:
    """Return the limits of a demand: its own, and those of the DAC where that is on."""
    if not is_on(chain.preset, chain.dac):
        return Limits(low, high)
    lowest = -chain.amplifier_gain * chain.dac_range
    highest = chain.amplifier_gain * (chain.dac_range - resolution(chain.dac_bits, chain.dac_range))
    return Limits(max(low, lowest), min(high, highest))


@kernel
def converted(demand: float, chain: np.record) -> float:
    """Return the demand that the amplifier gets: the nearest level of the DAC where that is on."""
    if not is_on(chain.preset, chain.dac):
        return demand
    shown: float = chain.amplifier_gain * quantised(demand / chain.amplifier_gain, chain.dac_bits, chain.dac_range)
    return shown
