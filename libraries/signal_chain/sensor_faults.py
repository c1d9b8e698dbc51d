"""Faults of a sensor: dead, stuck, offset."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel


@kernel
def with_faults(faults: np.record, sound: float, last: float) -> float:
    """Return the signal of a sensor under its faults; noise is added before.

    Dead: 0, whatever the other faults. Stuck: its last signal. Offset: added to the sound signal.

    Parameters
    ----------
    faults
        The sensor's fault inputs.
    sound, last
        Signal without faults, and signal at the previous sample (m).
    """
    if faults.dead:
        return 0.0
    if faults.stuck:
        return last
    signal: float = sound + faults.offset
    return signal
