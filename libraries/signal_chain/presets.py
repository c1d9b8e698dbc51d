"""Presets of the signal chain."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.variables import Enumeration

# The values of chain.preset.
PRESETS = Enumeration(
    "SignalChain", (("ideal", "no effects"), ("rig", "all effects"), ("custom", "the effects that are switched on"))
)
IDEAL, RIG, CUSTOM = range(3)


@kernel
def is_on(preset: float, switch: float) -> bool:
    """Return whether an effect is on: always with the preset rig, never with ideal, otherwise if `switch` is on.

    Parameters
    ----------
    preset
        The parameter `chain.preset`.
    switch
        The parameter that switches the effect on, such as `chain.filter`.
    """
    if preset == IDEAL:
        return False
    return preset == RIG or switch != 0.0
