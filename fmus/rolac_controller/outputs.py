"""Writes the outputs of the controller from its state."""

from __future__ import annotations

import math

from fmi_export.jit import inlined_kernel, kernel
from fmi_export.parts import copy_all
from rolac_controller.complex_numbers import squared_magnitude
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.enumerations import ADAPTING
from rolac_controller.identification import progress
from rolac_controller.identified_receptance import IdentificationMemory
from rolac_controller.receptance_table import TableViews
from rolac_controller.records import Inputs, Outputs, Parameters
from rolac_controller.state import State, Work


@kernel
def polar(z: complex) -> tuple[float, float]:
    """Return the amplitude and phase (rad) of a component; both are zero if the component is zero."""
    if z.real == 0.0 and z.imag == 0.0:
        return 0.0, 0.0
    return math.sqrt(squared_magnitude(z)), math.atan2(z.imag, z.real)


@inlined_kernel
def write_synchronous(
    parameters: Parameters, inputs: Inputs, state: State, work: Work, table: TableViews, outputs: Outputs
) -> None:
    """Write the components, the forces and the status of the synchronous control."""
    harmonic = int(inputs.common[0].shown_harmonic) - 1
    n_axes, n_sensors = state.U.shape[1], work.Q.shape[1]
    for axis in range(n_axes):
        amplitude, phase = polar(state.U[harmonic, axis])
        outputs.axes[axis].force_amplitude = amplitude
        outputs.axes[axis].force_phase = phase
    for s in range(n_sensors):
        amplitude, phase = polar(work.Q[harmonic, s])
        outputs.sensors[s].amplitude = amplitude
        outputs.sensors[s].phase = phase
    for k in range(N_HARMONICS):
        displacement = force = 0.0
        if parameters.harmonics[k].order != 0.0:
            for s in range(n_sensors):
                displacement += squared_magnitude(work.Q[k, s])
            for axis in range(n_axes):
                force += squared_magnitude(state.U[k, axis])
        outputs.harmonics[k].displacement = math.sqrt(displacement)
        outputs.harmonics[k].force = math.sqrt(force)
    for bearing in range(state.contact_shares.shape[0]):
        outputs.contact_shares[bearing] = state.contact_shares[bearing]
    common, findings = outputs.common[0], work.findings[0]
    common.rolac_active = 1.0 if findings.status == ADAPTING else 0.0
    common.window_valid = findings.window_valid
    common.rolac_status = findings.status
    common.rolac_limited = findings.force_limited
    common.h_extrapolated = findings.extrapolated
    common.adc_limited = findings.adc_limited
    common.suspect_sensor = findings.suspect_sensor
    common.table_rows = table.n_rows[0]


@inlined_kernel
def write_identification(inputs: Inputs, memory: IdentificationMemory, outputs: Outputs) -> None:
    """Write the stage of the identification, and the last receptance."""
    harmonic = int(inputs.common[0].shown_harmonic) - 1
    common, course = outputs.common[0], memory.course[0]
    common.identification_state = course.stage
    common.identification_error = course.error
    common.identification_progress = progress(memory)
    common.identification_speed = course.completed_speed
    common.condition_number = course.conditions[harmonic]
    copy_all(memory.R[harmonic], outputs.receptance)
