"""Sequence that identifies the receptance of a running rotor (thesis 5.15 to 5.19, 6.3 to 6.7).

There is one slot of N_per revolutions for each axis, one slot before these, and one after them. The forces of ROLAC are
constant during the sequence. docs/theory/identification.md shows a sketch.

Q is averaged over the last revolutions of each slot, and `identified_receptance` computes R and H from the averages.
"""

from __future__ import annotations

import math

from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rolac_controller.complex_numbers import divided, phasor
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.enumerations import (
    CONTACT_OCCURRED,
    CURRENT_LIMITED,
    NO_ERROR,
    NOT_STARTED,
    SLOT_BEFORE,
    SPEED_CHANGED,
    SWITCHED_OFF,
    WAITING,
    WINDOW_LOST,
    last_stages,
)
from rolac_controller.excitation import periods
from rolac_controller.fourier import ANGLE_TOLERANCE
from rolac_controller.identified_receptance import IdentificationMemory, evaluate, excitation_component
from rolac_controller.receptance_table import TableViews
from rolac_controller.records import Inputs, Parameters
from rolac_controller.state import State, Work

SPEED_TOLERANCE = 0.01  # relative


@inlined_kernel
def is_running(memory: IdentificationMemory) -> bool:
    """Return whether a slot is in progress."""
    n_axes = memory.R.shape[2]
    return bool(SLOT_BEFORE <= memory.course[0].stage <= last_stages(n_axes).slot_after)


@inlined_kernel
def progress(memory: IdentificationMemory) -> float:
    """Return the completed fraction of the identification, 0 to 1."""
    course, n_axes = memory.course[0], memory.R.shape[2]
    if course.stage == last_stages(n_axes).done:
        return 1.0
    if not is_running(memory):
        return 0.0
    of_slot = course.angle / (2.0 * math.pi * course.n_revolutions)
    share: float = (course.stage - SLOT_BEFORE + min(max(of_slot, 0.0), 1.0)) / (n_axes + 2)
    return share


@inlined_kernel
def axis_under_test(memory: IdentificationMemory) -> int:
    """Return the axis to which the test force is applied, or -1 if no test force is applied."""
    axis = int(memory.course[0].stage) - SLOT_BEFORE - 1
    return axis if 0 <= axis < memory.R.shape[2] else -1


@inlined_kernel
def add_test_force(parameters: Parameters, memory: IdentificationMemory, theta: float, u: Array) -> None:
    """Add the test force at a rotor angle (rad) to the axis under test in the forces `u`, shape (n_axes,) (N)."""
    axis = axis_under_test(memory)
    if axis < 0:
        return
    for k in range(N_HARMONICS):
        rotation = phasor(parameters.harmonics[k].order * theta)
        u[axis] += (excitation_component(parameters, memory, k) * rotation).real


@inlined_kernel
def advance(parameters: Parameters, inputs: Inputs, state: State, work: Work, table: TableViews) -> None:
    """Advance the identification by a sample: it may start, average, go to the next slot, finish or fail.

    Parameters
    ----------
    state
        The field `identification` is updated.
    work
        Contains the findings of this sample and the components Q of all harmonics.
    table
        The table in use, which is updated when the identification succeeds.
    """
    memory, identify = state.identification, inputs.common[0].identify
    course = memory.course[0]
    rises = identify != 0.0 and course.requested == 0.0
    course.requested = identify
    if rises and not is_running(memory):
        course.stage = WAITING
        course.error = NO_ERROR
    if course.stage == WAITING:
        if not identify:
            course.stage = NOT_STARTED
        elif work.findings[0].window_valid:
            begin(parameters, inputs.common[0].Omega, memory)
        return
    if is_running(memory):
        error = cause_of_failure(inputs, state, work)
        if error == NO_ERROR:
            advance_slot(parameters, memory, work, table)
        else:
            course.stage = last_stages(memory.R.shape[2]).failed
            course.error = error


@kernel
def advance_slot(parameters: Parameters, memory: IdentificationMemory, work: Work, table: TableViews) -> None:
    """Advance a slot by a sample; the arguments are as in `advance`."""
    course, stages = memory.course[0], last_stages(memory.R.shape[2])
    course.angle += work.findings[0].delta_theta
    length = 2.0 * math.pi * course.n_revolutions
    slot = memory.Q[int(course.stage) - SLOT_BEFORE]
    if course.angle > length - 2.0 * math.pi * parameters.common[0].identification.average:
        for k in range(N_HARMONICS):
            for s in range(slot.shape[1]):
                slot[k, s] += work.Q[k, s]
        course.n_samples += 1.0
    if course.angle >= length - ANGLE_TOLERANCE:
        for k in range(N_HARMONICS):
            for s in range(slot.shape[1]):
                slot[k, s] = divided(slot[k, s], course.n_samples)
        course.angle -= length
        course.n_samples = 0.0
        if course.stage == stages.slot_after:
            course.error = evaluate(parameters, memory, work.H, work.svd, table)
            course.stage = stages.done if course.error == NO_ERROR else stages.failed
        else:
            course.stage += 1.0


@kernel
def begin(parameters: Parameters, Omega: float, memory: IdentificationMemory) -> None:
    """Start the first slot at a speed (rad/s)."""
    course = memory.course[0]
    course.stage = SLOT_BEFORE
    course.angle = 0.0
    course.n_samples = 0.0
    course.speed = Omega
    course.force_scale = parameters.common[0].identification.force_scale
    course.n_revolutions = periods(Omega / (2.0 * math.pi))
    memory.Q[:] = 0.0


@inlined_kernel
def cause_of_failure(inputs: Inputs, state: State, work: Work) -> int:
    """Return the reason why the identification fails at this sample, or NO_ERROR."""
    speed = state.identification.course[0].speed
    if not inputs.common[0].identify:
        return SWITCHED_OFF
    if not work.findings[0].window_valid:
        return WINDOW_LOST
    if abs(inputs.common[0].Omega - speed) > SPEED_TOLERANCE * speed:
        return SPEED_CHANGED
    if state.head[0].current_limited:  # at the sample before
        return CURRENT_LIMITED
    return CONTACT_OCCURRED if work.findings[0].in_contact else NO_ERROR
