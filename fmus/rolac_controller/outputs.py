"""What the controller shows of its state."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller import identification
from rolac_controller.adaptation import N_U
from rolac_controller.arrays import Scratch, State
from rolac_controller.fourier import N_Q
from rolac_controller.interface import (
    ACTIVE,
    AMPLITUDE,
    AXIS_OUTPUTS,
    CONDITION,
    CONTACT_SHARE,
    DISPLACEMENTS,
    ERROR,
    EXTRAPOLATED,
    FORCE,
    FORCE_LIMITED,
    FORCE_PHASE,
    FORCES,
    IDENTIFIED_SPEED,
    PHASE,
    PROGRESS,
    RECEPTANCE,
    SHOWN_HARMONIC,
    STAGE,
    STATUS,
    SUSPECT_SENSOR,
    TABLE_ROWS,
    VALID,
)
from rolac_controller.inverse import N_MATRIX
from rolac_controller.names import ADAPTING, N_AXES, N_BEARINGS, N_HARMONICS, N_SENSORS


@kernel
def polar(re: float, im: float) -> tuple[float, float]:
    """Amplitude and phase (rad) of a component; both are zero where there is none."""
    if re == 0.0 and im == 0.0:
        return 0.0, 0.0
    return math.sqrt(re * re + im * im), math.atan2(im, re)


@kernel
def show_synchronous(
    inputs: Array,
    s: State,
    x: Scratch,
    valid: bool,
    status: int,
    extrapolated: bool,
    limited: bool,
    suspect: int,
    outputs: Array,
) -> None:
    """Components, forces and status of the synchronous control."""
    shown = int(inputs[SHOWN_HARMONIC]) - 1
    for a in range(N_AXES):
        re, im = s.forces[shown * N_U + 2 * a], s.forces[shown * N_U + 2 * a + 1]
        outputs[a * AXIS_OUTPUTS + FORCE], outputs[a * AXIS_OUTPUTS + FORCE_PHASE] = polar(re, im)
    for k in range(N_SENSORS):
        re, im = x.q[shown * N_Q + 2 * k], x.q[shown * N_Q + 2 * k + 1]
        outputs[AMPLITUDE + 2 * k], outputs[PHASE + 2 * k] = polar(re, im)
    for k in range(N_HARMONICS):
        squares = 0.0
        for i in range(N_Q):
            squares += x.q[k * N_Q + i] ** 2
        outputs[DISPLACEMENTS + 2 * k] = math.sqrt(squares)
        squares = 0.0
        for i in range(N_U):
            squares += s.forces[k * N_U + i] ** 2
        outputs[FORCES + 2 * k] = math.sqrt(squares)
    outputs[ACTIVE] = 1.0 if status == ADAPTING else 0.0
    outputs[VALID] = 1.0 if valid else 0.0
    outputs[STATUS] = status
    outputs[FORCE_LIMITED] = 1.0 if limited else 0.0
    outputs[EXTRAPOLATED] = 1.0 if extrapolated else 0.0
    outputs[SUSPECT_SENSOR] = suspect
    for bearing in range(N_BEARINGS):
        outputs[CONTACT_SHARE + bearing] = s.contact[bearing]
    outputs[TABLE_ROWS] = s.table[0]


@kernel
def show_identification(inputs: Array, s: State, outputs: Array) -> None:
    """Where the identification stands, and the last receptance."""
    memory = s.identification
    shown = int(inputs[SHOWN_HARMONIC]) - 1
    outputs[STAGE] = memory[identification.STAGE]
    outputs[ERROR] = memory[identification.REASON]
    outputs[PROGRESS] = identification.progress(memory)
    outputs[IDENTIFIED_SPEED] = memory[identification.IDENTIFIED]
    outputs[CONDITION] = memory[identification.CONDITIONS + shown]
    result = identification.RESULT + shown * N_MATRIX
    copy(memory[result : result + N_MATRIX], outputs[RECEPTANCE:])
