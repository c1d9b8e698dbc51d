"""What the controller shows of its state."""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from rolac_controller.complex_numbers import copy_matrix, squared_magnitude
from rolac_controller.enumerations import ADAPTING
from rolac_controller.identification import progress
from rolac_controller.receptance_table import TableViews
from rolac_controller.rig_layout import N_AXES, N_BEARINGS, N_HARMONICS, N_SENSORS


@kernel
def polar(z: complex) -> tuple[float, float]:
    """Return amplitude and phase (rad) of a component; both are zero where there is none."""
    if z.real == 0.0 and z.imag == 0.0:
        return 0.0, 0.0
    return math.sqrt(squared_magnitude(z)), math.atan2(z.imag, z.real)


@kernel
def write_synchronous(
    inputs: np.record, state: np.record, work: np.record, table: TableViews, outputs: np.record
) -> None:
    """Write components, forces and status of the synchronous control."""
    shown = int(inputs.shown_harmonic) - 1
    for axis in range(N_AXES):
        amplitude, phase = polar(state.U[shown, axis])
        outputs.axes[axis].force_amplitude = amplitude
        outputs.axes[axis].force_phase = phase
    for s in range(N_SENSORS):
        amplitude, phase = polar(work.Q[shown, s])
        outputs.sensors[s].amplitude = amplitude
        outputs.sensors[s].phase = phase
    for k in range(N_HARMONICS):
        squares = 0.0
        for s in range(N_SENSORS):
            squares += squared_magnitude(work.Q[k, s])
        outputs.harmonics[k].displacement = math.sqrt(squares)
        squares = 0.0
        for axis in range(N_AXES):
            squares += squared_magnitude(state.U[k, axis])
        outputs.harmonics[k].force = math.sqrt(squares)
    outputs.rolac_active = 1.0 if work.status == ADAPTING else 0.0
    outputs.window_valid = work.window_valid
    outputs.rolac_status = work.status
    outputs.rolac_limited = work.force_limited
    outputs.h_extrapolated = work.extrapolated
    outputs.suspect_sensor = work.suspect_sensor
    for bearing in range(N_BEARINGS):
        outputs.contact_shares[bearing] = state.contact_shares[bearing]
    outputs.table_rows = table.n_rows[0]


@kernel
def write_identification(inputs: np.record, memory: np.record, outputs: np.record) -> None:
    """Write the stage of the identification, and the last receptance."""
    shown = int(inputs.shown_harmonic) - 1
    outputs.identification_state = memory.stage
    outputs.identification_error = memory.error
    outputs.identification_progress = progress(memory)
    outputs.identification_speed = memory.completed_speed
    outputs.condition_number = memory.conditions[shown]
    copy_matrix(memory.R[shown], outputs.receptance)
