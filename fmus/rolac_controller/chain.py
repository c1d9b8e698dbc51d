"""Which effects of the signal chain are on."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.interface import PRESET
from rolac_controller.names import IDEAL, RIG


@kernel
def is_on(parameters: Array, effect: int) -> bool:
    """Whether the effect with that switch is on: never for the ideal chain, always for the rig's."""
    preset = parameters[PRESET]
    if preset == IDEAL:
        return False
    if preset == RIG:
        return True
    on: bool = parameters[effect] != 0.0
    return on
