"""Synchronous control: whether it may adapt now, and the forces of all harmonics by the law of `rolac.mode`."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import kernel
from rolac_controller.adaptation import integral_step, limit_forces
from rolac_controller.contact import turn_against_displacement
from rolac_controller.enumerations import (
    ADAPTING,
    FORCE_FREE,
    IDENTIFYING,
    NO_H,
    NO_WINDOW,
    NOTCH,
    OFF,
    OLAC,
    ROLAC,
    SENSOR_SUSPECT,
    TOO_SLOW,
)
from rolac_controller.identification import is_running
from rolac_controller.notch import reject_synchronous
from rolac_controller.olac import update_is_due
from rolac_controller.receptance_table import BEYOND, MISSING, Bracket, TableViews, find_bracket, interpolate
from rolac_controller.rig_layout import N_AXES, N_BEARINGS, N_HARMONICS


@kernel
def permitted_status(parameters: np.record, inputs: np.record, state: np.record, work: np.record) -> int:
    """Return the status of the synchronous control as far as it does not depend on the table."""
    if not inputs.rolac_enable:
        return OFF
    if inputs.Omega < parameters.rolac.min_speed:
        return TOO_SLOW
    if not work.window_valid:
        return NO_WINDOW
    if parameters.rolac.check_sensors and work.suspect_sensor > 0:
        return SENSOR_SUSPECT
    return IDENTIFYING if is_running(state.identification) else ADAPTING


@kernel
def update_forces(
    parameters: np.record, inputs: np.record, state: np.record, work: np.record, table: TableViews
) -> None:
    """Advance the synchronous forces U by one sample.

    They change under ADAPTING alone, stay under IDENTIFYING, and are zero under any other status.

    Parameters
    ----------
    parameters, inputs
        Records PARAMETERS and INPUTS.
    state
        Record STATE; `U` and `olac` are changed.
    work
        Record WORK. `status` is that of `permitted_status`; it becomes NO_H where H is missing for a harmonic.
        Receives `extrapolated`, whether H is that of the nearest speed, and `force_limited`.
    table
        Table in use.
    """
    work.extrapolated = 0.0
    work.force_limited = 0.0
    if work.status == ADAPTING:
        adapt(parameters, inputs, state, work, table)
    if work.status in (ADAPTING, IDENTIFYING):
        work.force_limited = limit_forces(state.U, parameters.rolac.force_limit)
    else:
        work.extrapolated = 0.0
        state.U[:] = 0.0
        state.olac.angle = 0.0
        state.olac.n_revolutions = 0.0
        state.olac.n_updates = 0.0
        state.olac.previous_Q[:] = 0.0


@kernel
def adapt(parameters: np.record, inputs: np.record, state: np.record, work: np.record, table: TableViews) -> None:
    """Change the forces of all harmonics by one step of the law; arguments as in `update_forces`."""
    mode = parameters.rolac.mode
    due = mode != OLAC or update_is_due(parameters.olac, work.delta_theta, work.Q, state.olac)
    for k in range(N_HARMONICS):
        order = parameters.harmonics[k].order
        if order == 0.0:
            break
        bracket = find_bracket(table, order, inputs.Omega)
        if bracket.coverage == BEYOND:
            work.extrapolated = 1.0
        if bracket.coverage == MISSING or (bracket.coverage == BEYOND and not parameters.rolac.extrapolate):
            work.status = NO_H
        elif due:
            interpolate_matrix(table, bracket, mode, work)
            step_harmonic(parameters, order * inputs.Omega, state, work, k)


@kernel
def interpolate_matrix(table: TableViews, bracket: Bracket, mode: float, work: np.record) -> None:
    """Interpolate the matrix that the law of this mode needs, R or H, between the rows of the table."""
    lower, upper = table.rows[bracket.lower], table.rows[bracket.upper]
    if mode in (NOTCH, FORCE_FREE):
        interpolate(lower.R, upper.R, bracket.weight, work.R)
    else:
        interpolate(lower.H, upper.H, bracket.weight, work.H)


@kernel
def step_harmonic(parameters: np.record, omega: float, state: np.record, work: np.record, number: int) -> None:
    """Change the forces of one harmonic, at the frequency omega (rad/s), by one step of the law."""
    mode = parameters.rolac.mode
    Q, U = work.Q[number], state.U[number]
    if mode in (NOTCH, FORCE_FREE):
        reject_synchronous(parameters, omega, Q, U, work)
        return
    gain = parameters.rolac.alpha * parameters.sample_time if mode == ROLAC else 1.0
    integral_step(work.H, gain, Q, work.delta_U)
    if mode == ROLAC and parameters.contact.aware:
        for bearing in range(N_BEARINGS):
            share = state.contact_shares[bearing]
            turn_against_displacement(share, parameters.contact.lead, Q, work.delta_U, bearing)
    for axis in range(N_AXES):
        U[axis] += work.delta_U[axis]
