"""Which effects of the signal chain are on."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.variables import Enumeration

# Of chain.preset.
PRESETS = Enumeration(
    "SignalChain", (("ideal", "no effects"), ("rig", "all effects"), ("custom", "those whose switches are on"))
)
IDEAL, RIG, CUSTOM = range(3)


@kernel
def is_on(preset: float, switch: float) -> bool:
    """Return whether an effect is on: never for the ideal chain, always for the rig's, by its switch otherwise.

    Parameters
    ----------
    preset
        The parameter `chain.preset`.
    switch
        The parameter of the effect, such as `chain.filter`.
    """
    if preset == IDEAL:
        return False
    return preset == RIG or switch != 0.0
