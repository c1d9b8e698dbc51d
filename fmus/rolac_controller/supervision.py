"""Sensors that cannot be right: one that stands still for a revolution in which others move."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.names import N_SENSORS

LAST = 0
STILL = LAST + N_SENSORS  # samples since the reading changed
N_MEMORY = STILL + N_SENSORS


@kernel
def suspect(measured: Array, revolution: float, memory: Array) -> int:
    """Number of the first sensor that has not moved for a revolution although another has, from 1; 0 if none.

    Parameters
    ----------
    measured
        Displacements, shape (N_SENSORS,) (m).
    revolution
        Length of the last revolution in samples; 0 where there is none.
    memory
        Shape (N_MEMORY,); changed.
    """
    first, still = 0, 0
    for s in range(N_SENSORS):
        if measured[s] == memory[LAST + s]:
            memory[STILL + s] += 1.0
        else:
            memory[STILL + s] = 0.0
        memory[LAST + s] = measured[s]
        if revolution > 0.0 and memory[STILL + s] >= revolution:
            still += 1
            if first == 0:
                first = s + 1
    return first if still < N_SENSORS else 0
