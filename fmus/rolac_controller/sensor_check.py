"""Detection of faulty sensors, whose readings stay constant for a revolution while other readings change."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.records import record
from rolac_controller.sizes import Records

CHECK_MEMORY = record(
    ("displacement", "f8"),  # at the sample before (m)
    ("n_unchanged", "f8"),  # samples since the reading changed
)


@kernel
def suspect_sensor(displacements: Array, samples_of_revolution: float, memory: Records) -> int:
    """Return the number of the first sensor whose reading was constant for a revolution while another reading changed.

    Numbers start from 1; 0 means that there is no such sensor.

    Parameters
    ----------
    displacements
        Measured displacements, shape (n_sensors,) (m).
    samples_of_revolution
        Length of the last revolution in samples; 0 if there is none.
    memory
        Records CHECK_MEMORY of the sensors; changed.
    """
    first = n_suspect = 0
    n_sensors = displacements.shape[0]
    for s in range(n_sensors):
        sensor = memory[s]
        if displacements[s] == sensor.displacement:
            sensor.n_unchanged += 1.0
        else:
            sensor.n_unchanged = 0.0
        sensor.displacement = displacements[s]
        if samples_of_revolution > 0.0 and sensor.n_unchanged >= samples_of_revolution:
            n_suspect += 1
            if first == 0:
                first = s + 1
    return first if n_suspect < n_sensors else 0
