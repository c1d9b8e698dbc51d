"""Which effects of the signal chain are on."""

from __future__ import annotations

from fmi_export.jit import kernel
from rolac_controller.enumerations import IDEAL, RIG


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
