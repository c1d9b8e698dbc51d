"""Identification of the receptance while the rotor runs (thesis 5.15 to 5.19, 6.3 to 6.7): its course.

Six slots of N_per revolutions each; the forces of ROLAC do not change meanwhile:

    |  before  |  mb1.x   |  mb1.y   |  mb2.x   |  mb2.y   |  after   |
    |   idle   | A cos th | A cos th | A cos th | A cos th |   idle   |
    0         N_per                       ...               6 N_per   revolutions
         [avg]      [avg]      [avg]      [avg]      [avg]      [avg]

Q is averaged over the last revolutions of each slot; `identified_receptance` makes R and H of the means.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.complex_numbers import divided, phasor
from rolac_controller.enumerations import (
    CONTACT_OCCURRED,
    CURRENT_LIMITED,
    DONE,
    FAILED,
    N_SLOTS,
    NO_ERROR,
    NOT_STARTED,
    SLOT_AFTER,
    SLOT_BEFORE,
    SPEED_CHANGED,
    SWITCHED_OFF,
    WAITING,
    WINDOW_LOST,
)
from rolac_controller.excitation import periods
from rolac_controller.fourier import ANGLE_TOLERANCE
from rolac_controller.identified_receptance import evaluate, excitation_component
from rolac_controller.receptance_table import TableViews
from rolac_controller.rig_layout import N_AXES, N_HARMONICS, N_SENSORS

SPEED_TOLERANCE = 0.01  # relative


@kernel
def is_running(memory: np.record) -> bool:
    """Return whether one of the six slots is in progress."""
    return bool(SLOT_BEFORE <= memory.stage <= SLOT_AFTER)


@kernel
def progress(memory: np.record) -> float:
    """Return the share of the six slots that has passed."""
    if memory.stage == DONE:
        return 1.0
    if not is_running(memory):
        return 0.0
    of_slot = memory.angle / (2.0 * math.pi * memory.n_revolutions)
    share: float = (memory.stage - SLOT_BEFORE + min(max(of_slot, 0.0), 1.0)) / N_SLOTS
    return share


@kernel
def axis_under_test(memory: np.record) -> int:
    """Return the axis that carries the test force now, or -1."""
    axis = int(memory.stage) - SLOT_BEFORE - 1
    return axis if 0 <= axis < N_AXES else -1


@kernel
def add_test_force(parameters: np.record, memory: np.record, theta: float, u: Array) -> None:
    """Add the test force at a rotor angle (rad) to the force of the axis under test, shape (N_AXES,) (N)."""
    axis = axis_under_test(memory)
    if axis < 0:
        return
    for k in range(N_HARMONICS):
        rotation = phasor(parameters.harmonics[k].order * theta)
        u[axis] += (excitation_component(parameters, memory, k) * rotation).real


@kernel
def advance(parameters: np.record, inputs: np.record, state: np.record, work: np.record, table: TableViews) -> None:
    """Advance the identification by one sample: start, average, change slots, finish or fail.

    Parameters
    ----------
    parameters, inputs
        Records PARAMETERS and INPUTS.
    state
        Record STATE; its `identification` is changed.
    work
        Record WORK with the findings of this sample and the components Q of all harmonics.
    table
        Table in use; updated when the identification succeeds.
    """
    memory = state.identification
    rises = inputs.identify != 0.0 and memory.requested == 0.0
    memory.requested = inputs.identify
    if rises and not is_running(memory):
        memory.stage = WAITING
        memory.error = NO_ERROR
    if memory.stage == WAITING:
        if not inputs.identify:
            memory.stage = NOT_STARTED
        elif work.window_valid:
            begin(parameters, inputs.Omega, memory)
        return
    if not is_running(memory):
        return
    error = cause_of_failure(inputs, state, work)
    if error != NO_ERROR:
        memory.stage = FAILED
        memory.error = error
        return
    memory.angle += work.delta_theta
    length = 2.0 * math.pi * memory.n_revolutions
    slot = memory.Q[int(memory.stage) - SLOT_BEFORE]
    if memory.angle > length - 2.0 * math.pi * parameters.identification.average:
        for k in range(N_HARMONICS):
            for s in range(N_SENSORS):
                slot[k, s] += work.Q[k, s]
        memory.n_samples += 1.0
    if memory.angle >= length - ANGLE_TOLERANCE:
        for k in range(N_HARMONICS):
            for s in range(N_SENSORS):
                slot[k, s] = divided(slot[k, s], memory.n_samples)
        memory.angle -= length
        memory.n_samples = 0.0
        if memory.stage == SLOT_AFTER:
            memory.error = evaluate(parameters, memory, work, table)
            memory.stage = DONE if memory.error == NO_ERROR else FAILED
        else:
            memory.stage += 1.0


@kernel
def begin(parameters: np.record, Omega: float, memory: np.record) -> None:
    """Start the first slot at a speed (rad/s)."""
    memory.stage = SLOT_BEFORE
    memory.angle = 0.0
    memory.n_samples = 0.0
    memory.speed = Omega
    memory.force_scale = parameters.identification.force_scale
    memory.n_revolutions = periods(Omega / (2.0 * math.pi))
    memory.Q[:] = 0.0


@kernel
def cause_of_failure(inputs: np.record, state: np.record, work: np.record) -> int:
    """Return why the identification cannot go on, or NO_ERROR."""
    speed = state.identification.speed
    if not inputs.identify:
        return SWITCHED_OFF
    if not work.window_valid:
        return WINDOW_LOST
    if abs(inputs.Omega - speed) > SPEED_TOLERANCE * speed:
        return SPEED_CHANGED
    if state.current_limited:  # at the sample before
        return CURRENT_LIMITED
    return CONTACT_OCCURRED if work.in_contact else NO_ERROR
