"""Synchronous control: conditions for adaptation, and forces of all harmonics according to `rolac.mode`."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import inlined_kernel
from rolac_controller.adaptation import fade_forces, integral_step, limit_forces
from rolac_controller.contact import turn_against_displacement
from rolac_controller.control_loop import N_HARMONICS
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
from rolac_controller.olac import forget, update_is_due
from rolac_controller.receptance_table import BEYOND, MISSING, Bracket, TableViews, find_bracket, interpolate
from rolac_controller.records import Inputs, Parameters
from rolac_controller.state import State, Work


@inlined_kernel
def permitted_status(parameters: Parameters, inputs: Inputs, state: State, work: Work) -> int:
    """Return the status of the synchronous control before the table is checked."""
    rolac, findings = parameters.common[0].rolac, work.findings[0]
    if not inputs.common[0].rolac_enable:
        return OFF
    if inputs.common[0].Omega < rolac.min_speed:
        return TOO_SLOW
    if not findings.window_valid:
        return NO_WINDOW
    if rolac.check_sensors and findings.suspect_sensor > 0:
        return SENSOR_SUSPECT
    return IDENTIFYING if is_running(state.identification) else ADAPTING


@inlined_kernel
def update_forces(parameters: Parameters, inputs: Inputs, state: State, work: Work, table: TableViews) -> None:
    """Advance the synchronous forces U by a sample.

    They adapt only in the status ADAPTING, are constant in IDENTIFYING, and fade to zero in any other status.

    Parameters
    ----------
    state
        `U` and `olac` are changed.
    work
        The `status` in its findings is the result of `permitted_status`; it becomes NO_H if H is missing for a
        harmonic. The findings receive `extrapolated`, which says whether the H of the nearest speed is used, and
        `force_limited`.
    table
        Table in use.
    """
    findings = work.findings[0]
    findings.extrapolated = 0.0
    findings.force_limited = 0.0
    if findings.status == ADAPTING and not is_covered(parameters, inputs, table, findings):
        findings.status = NO_H
    if findings.status == ADAPTING:
        adapt(parameters, inputs, state, work, table)
    if findings.status in (ADAPTING, IDENTIFYING):
        findings.force_limited = limit_forces(state.U, parameters.harmonics, parameters.common[0].rolac.force_limit)
    else:
        common = parameters.common[0]
        fade_forces(state.U, min(common.rolac.fade * common.sample_time, 1.0))
        forget(state.olac)


@inlined_kernel
def is_covered(parameters: Parameters, inputs: Inputs, table: TableViews, findings: np.record) -> bool:
    """Return whether the table contains H of all harmonics for this speed; set `extrapolated` in `findings`."""
    extrapolated = 0.0
    for k in range(N_HARMONICS):
        order = parameters.harmonics[k].order
        if order == 0.0:
            break
        coverage = find_bracket(table, order, inputs.common[0].Omega).coverage
        if coverage == MISSING or (coverage == BEYOND and not parameters.common[0].rolac.extrapolate):
            return False
        if coverage == BEYOND:
            extrapolated = 1.0
    findings.extrapolated = extrapolated
    return True


@inlined_kernel
def adapt(parameters: Parameters, inputs: Inputs, state: State, work: Work, table: TableViews) -> None:
    """Change the forces of all harmonics by a step of the law; the arguments are as in `update_forces`."""
    common, Omega = parameters.common[0], inputs.common[0].Omega
    mode = common.rolac.mode
    if mode == OLAC and not update_is_due(common.olac, work.findings[0].delta_theta, work.Q, state.olac):
        return
    for k in range(N_HARMONICS):
        order = parameters.harmonics[k].order
        if order == 0.0:
            break
        interpolate_matrix(table, find_bracket(table, order, Omega), mode, work)
        step_harmonic(parameters, order, Omega, state, work, k)


@inlined_kernel
def interpolate_matrix(table: TableViews, bracket: Bracket, mode: float, work: Work) -> None:
    """Interpolate the matrix that the law of this mode requires (R or H) between the rows of the table."""
    if mode in (NOTCH, FORCE_FREE):
        interpolate(table.R[bracket.lower], table.R[bracket.upper], bracket.weight, work.R)
    else:
        interpolate(table.H[bracket.lower], table.H[bracket.upper], bracket.weight, work.H)


@inlined_kernel
def step_harmonic(parameters: Parameters, order: float, Omega: float, state: State, work: Work, number: int) -> None:
    """Change the forces of the harmonic with this order by a step of the law at a speed (rad/s)."""
    common = parameters.common[0]
    mode = common.rolac.mode
    Q, U = work.Q[number], state.U[number]
    if mode in (NOTCH, FORCE_FREE):
        reject_synchronous(parameters, order, Omega, Q, U, work)
        return
    gain = common.rolac.alpha * common.sample_time if mode == ROLAC else 1.0
    integral_step(work.H, gain, Q, work.delta_U)
    if mode == ROLAC and common.contact.aware:
        for bearing in range(state.contact_shares.shape[0]):
            turn_against_displacement(parameters, state.contact_shares[bearing], Q, work.delta_U, bearing)
    for axis in range(U.shape[0]):
        U[axis] += work.delta_U[axis]
