"""The controller's memory: the record of its state, and the record of its work array."""

from __future__ import annotations

from fmi_export.model import Array
from fmi_export.records import record, size_of
from rolac_controller.fourier import WINDOW
from rolac_controller.identified_receptance import IDENTIFICATION_MEMORY
from rolac_controller.olac import OLAC_MEMORY
from rolac_controller.pid import PID_MEMORY
from rolac_controller.pseudo_inverse import SVD_WORK
from rolac_controller.receptance_table import table_size
from rolac_controller.rig_layout import N_AXES, N_BEARINGS, N_HARMONICS, N_SENSORS
from rolac_controller.sensor_check import CHECK_MEMORY
from rolac_controller.sensors import SENSOR_MEMORY

# The table in use follows the record in the state array; its size depends on the constants.
STATE = record(
    ("started", "f8"),  # 1 after the first sample
    ("current_limited", "f8"),  # 1 if a current was at its limit at the last sample
    ("axes", PID_MEMORY, (N_AXES,)),
    ("currents", "f8", (N_AXES,)),  # computed last (A)
    ("U", "c16", (N_HARMONICS, N_AXES)),  # synchronous forces (N)
    ("contact_shares", "f8", (N_BEARINGS,)),
    ("sensors", SENSOR_MEMORY),
    ("sensor_check", CHECK_MEMORY),
    ("olac", OLAC_MEMORY),
    ("identification", IDENTIFICATION_MEMORY),
    ("window", WINDOW),
)

WORK = record(
    # What was found at this sample; flags are 0 or 1.
    ("displacements", "f8", (N_SENSORS,)),  # measured (m)
    ("Q", "c16", (N_HARMONICS, N_SENSORS)),  # synchronous displacements (m)
    ("delta_theta", "f8"),  # angle since the sample before (rad)
    ("window_valid", "f8"),
    ("suspect_sensor", "f8"),
    ("in_contact", "f8"),
    ("status", "f8"),  # rolac_status
    ("extrapolated", "f8"),
    ("force_limited", "f8"),
    # Intermediate results.
    ("u", "f8", (N_AXES,)),  # synchronous forces and test force now (N)
    ("delta_U", "c16", (N_AXES,)),
    ("R", "c16", (N_SENSORS, N_AXES)),
    ("H", "c16", (N_AXES, N_SENSORS)),
    ("svd", SVD_WORK),
    ("inverse_S", "c16", (N_AXES, N_AXES)),  # of the notch
    ("E", "c16", (N_AXES,)),
)

STATE_SIZE, WORK_SIZE = size_of(STATE), size_of(WORK)


def n_state(constants: Array) -> int:
    """Return the size of the state of a controller with these constants."""
    return STATE_SIZE + table_size(constants)
