"""What a broken sensor shows."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.interface import DEAD, OFFSET, STUCK


@kernel
def faulty(fault: Array, value: float, last: float) -> float:
    """Signal of a sensor under its faults; noise is added before.

    Dead: 0, whatever else. Stuck: what it last showed. Offset: so much more.

    Parameters
    ----------
    fault
        The sensor's fault inputs, shape (FAULT_INPUTS,).
    value, last
        What the sensor would show, and what it showed at the sample before (m).
    """
    if fault[DEAD] != 0.0:
        return 0.0
    if fault[STUCK] != 0.0:
        return last
    return value + fault[OFFSET]
