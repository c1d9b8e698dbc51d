"""Sensors that cannot be right: one whose reading does not change for a revolution in which others do."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.records import record
from rolac_controller.rig_layout import N_SENSORS

CHECK_MEMORY = record(
    ("displacements", "f8", (N_SENSORS,)),  # at the sample before (m)
    ("n_unchanged", "f8", (N_SENSORS,)),  # samples since the reading changed
)


@kernel
def suspect_sensor(displacements: Array, samples_of_revolution: float, memory: np.record) -> int:
    """Return the number of the first sensor that did not change for a revolution although another did.

    Numbers start from 1; 0 means that there is none.

    Parameters
    ----------
    displacements
        As measured, shape (N_SENSORS,) (m).
    samples_of_revolution
        Length of the last revolution in samples; 0 where there is none.
    memory
        Record CHECK_MEMORY; changed.
    """
    first = n_suspect = 0
    for s in range(N_SENSORS):
        if displacements[s] == memory.displacements[s]:
            memory.n_unchanged[s] += 1.0
        else:
            memory.n_unchanged[s] = 0.0
        memory.displacements[s] = displacements[s]
        if samples_of_revolution > 0.0 and memory.n_unchanged[s] >= samples_of_revolution:
            n_suspect += 1
            if first == 0:
                first = s + 1
    return first if n_suspect < N_SENSORS else 0
