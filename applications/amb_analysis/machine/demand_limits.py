"""Limits of the demanded currents, from the limits of the controller and the range of its DAC."""

from __future__ import annotations

import math

import numpy as np

from amb_analysis.machine.axis_capability import current_amplitude
from amb_analysis.machine.machine import Machine
from array_types import Array
from signal_chain.converters import converter_of
from signal_chain.presets import is_on


def demand_amplitude(machine: Machine, bearing: str, axis: str) -> float:
    """Return the largest amplitude (A) of an axis's demand about its offset; infinity if nothing limits it.

        I = min(I_0 - I_low, I_high - I_0)                                                       (1)

    I_low and I_high are the limits of the controller that feeds the axis, and of its DAC if the DAC is on
    (`signal_chain.demands`).
    """
    source = machine.run_loop.sources[machine.run_loop.axes.index((bearing, axis))]
    component, _, demand = source.partition(".")
    p = machine.parameters.get(component, {})
    owner, _, signal = demand.rpartition(".")
    direction = signal.removeprefix("i_")
    low = p.get(f"{demand}.lower", p.get(f"{owner}.i_min_{direction}", -math.inf))
    high = p.get(f"{demand}.upper", p.get(f"{owner}.i_max_{direction}", math.inf))
    if is_on(p.get("chain.preset", 0.0), p.get("chain.dac", 0.0)):
        gain, reach = p["chain.amplifier_gain"], p["chain.dac_range"]
        step = converter_of(p["chain.dac_bits"], reach).step
        low, high = max(low, -gain * reach), min(high, gain * (reach - step))
    offset = p.get(f"{demand}.offset", 0.0)
    return max(min(offset - low, high - offset), 0.0)


def control_amplitude(machine: Machine, bearing: str, axis: str, frequency: Array | float) -> Array:
    """Return the largest amplitude (A) of a control current within the limits of its controller, coils and voltage.

    Parameters
    ----------
    frequency
        Frequencies (Hz).
    """
    coil_limit = current_amplitude(machine.axis(bearing, axis), frequency)
    return np.minimum(coil_limit, demand_amplitude(machine, bearing, axis))
