"""The digital-to-analogue converters (DAC) for the demands: range and resolution."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import kernel
from signal_chain.converters import Converter, converter_of, quantised
from signal_chain.presets import is_on


class Limits(NamedTuple):
    """Smallest and largest demand."""

    low: float
    high: float


@kernel
def dac_of(chain: np.record) -> Converter:
    """Return the DAC that converts all demands of a sample; its least significant bit is 0 V if it is off."""
    if not is_on(chain.preset, chain.dac):
        return Converter(0.0, 0.0)
    return converter_of(chain.dac_bits, chain.dac_range)


@kernel
def within_converter(low: float, high: float, chain: np.record, dac: Converter) -> Limits:
    """Return the limits of a demand, narrowed to the range of the DAC if it is on."""
    if dac.step == 0.0:
        return Limits(low, high)
    lowest = -chain.amplifier_gain * chain.dac_range
    highest = chain.amplifier_gain * (chain.dac_range - dac.step)
    return Limits(max(low, lowest), min(high, highest))


@kernel
def converted(demand: float, chain: np.record, dac: Converter) -> float:
    """Return the demand that the amplifier receives; if the DAC is on, this is the nearest level of the DAC."""
    if dac.step == 0.0:
        return demand
    output: float = chain.amplifier_gain * quantised(demand / chain.amplifier_gain, dac)
    return output
