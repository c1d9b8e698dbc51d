"""Identification of the receptance while the rotor runs (thesis 5.15 to 5.19, 6.3 to 6.7).

    Q = Q_0 + R U:   R_i = (Q with a force U_i on axis i - Q without) / U_i

Six slots of N_per revolutions each; the forces of ROLAC are held meanwhile:

    |  before  |  mb1.x   |  mb1.y   |  mb2.x   |  mb2.y   |  after   |
    |   idle   | A cos th | A cos th | A cos th | A cos th |   idle   |
    0         N_per                       ...               6 N_per   revolutions
         [avg]      [avg]      [avg]      [avg]      [avg]      [avg]

Q is the mean over the last revolutions of each slot. The slot before is the reference; the slot after tells whether the
vibration without force has stayed what it was.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.excitation import component, periods
from rolac_controller.fourier import N_Q, SLACK
from rolac_controller.interface import AVERAGE, FORCE_SCALE, MAX_CONDITION, MAX_DRIFT, MULTI, OMEGA, WEIGHT
from rolac_controller.inverse import N_MATRIX, invert
from rolac_controller.names import (
    ABORTED,
    AFTER,
    BEFORE,
    CONTACT,
    DONE,
    DRIFTED,
    FAILED,
    ILL_CONDITIONED,
    LIMITED,
    N_AXES,
    N_HARMONICS,
    N_SENSORS,
    N_SLOTS,
    NO_ERROR,
    NONE,
    SPEED_CHANGED,
    TABLE_FULL,
    WAITING,
    WINDOW_LOST,
)
from rolac_controller.stored import store

SPEED_TOLERANCE = 0.01  # relative

# Layout of the memory: where it stands, then sums of Q for each slot and harmonic, then the last result.
STAGE, REASON, ASKED, TURNED, SPEED, SCALE, REVOLUTIONS, COUNT, IDENTIFIED = range(9)
CONDITIONS = 9
SUMS = CONDITIONS + N_HARMONICS
N_SLOT = N_HARMONICS * N_Q
RESULT = SUMS + N_SLOTS * N_SLOT
N_MEMORY = RESULT + N_HARMONICS * N_MATRIX


@kernel
def running(memory: Array) -> bool:
    """Whether a slot is under way."""
    stage = memory[STAGE]
    return bool(BEFORE <= stage <= AFTER)


@kernel
def progress(memory: Array) -> float:
    """Share of the six slots that has passed."""
    if memory[STAGE] == DONE:
        return 1.0
    if not running(memory):
        return 0.0
    of_slot = memory[TURNED] / (2.0 * math.pi * memory[REVOLUTIONS])
    return (memory[STAGE] - BEFORE + min(max(of_slot, 0.0), 1.0)) / N_SLOTS


@kernel
def axis_under_test(memory: Array) -> int:
    """Axis that carries the test force now, or -1."""
    axis = int(memory[STAGE]) - BEFORE - 1
    return axis if 0 <= axis < N_AXES else -1


@kernel
def test_component(parameters: Array, orders: Array, powers: Array, memory: Array, number: int) -> tuple[float, float]:
    """Real and imaginary part of one harmonic of the test force (N)."""
    frequency = memory[SPEED] / (2.0 * math.pi)
    return component(orders, powers, number, parameters[MULTI] != 0.0, memory[SCALE], frequency)


@kernel
def add_test_force(parameters: Array, orders: Array, powers: Array, memory: Array, theta: float, u: Array) -> None:
    """Add the test force at a rotor angle (rad) to the force of the axis under test, shape (N_AXES,) (N)."""
    axis = axis_under_test(memory)
    if axis < 0:
        return
    for k in range(N_HARMONICS):
        re, im = test_component(parameters, orders, powers, memory, k)
        u[axis] += re * math.cos(orders[k] * theta) - im * math.sin(orders[k] * theta)


@kernel
def advance(
    parameters: Array,
    inputs: Array,
    orders: Array,
    powers: Array,
    asked: bool,
    valid: bool,
    limited: bool,
    contact: bool,
    turn: float,
    q: Array,
    memory: Array,
    table: Array,
    work: Array,
) -> None:
    """Take one sample further: start, average, change slots, finish or give up.

    Parameters
    ----------
    orders, powers
        Of the harmonics, shape (N_HARMONICS,).
    asked
        The input `identify`.
    valid, limited, contact
        Whether there are synchronous signals, a current was at its limit at the sample before, a journal touches.
    turn
        Angle since the sample before (rad).
    q
        Components of all harmonics, shape (N_HARMONICS N_Q,) (m).
    memory
        Shape (N_MEMORY,); all zeros is none yet.
    table
        Table of H in use; renewed when the identification succeeds.
    work
        Shape (N_MATRIX + N_SCRATCH,).
    """
    rises = asked and memory[ASKED] == 0.0
    memory[ASKED] = 1.0 if asked else 0.0
    if rises and not running(memory):
        memory[STAGE], memory[REASON] = WAITING, NO_ERROR
    if memory[STAGE] == WAITING:
        if not asked:
            memory[STAGE] = NONE
        elif valid:
            begin(parameters, inputs, memory)
        return
    if not running(memory):
        return
    reason = disturbance(inputs, asked, valid, limited, contact, memory)
    if reason != NO_ERROR:
        memory[STAGE], memory[REASON] = FAILED, reason
        return
    memory[TURNED] += turn
    whole = 2.0 * math.pi * memory[REVOLUTIONS]
    if memory[TURNED] > whole - 2.0 * math.pi * parameters[AVERAGE]:
        sums = SUMS + int(memory[STAGE] - BEFORE) * N_SLOT
        for i in range(N_SLOT):
            memory[sums + i] += q[i]
        memory[COUNT] += 1.0
    if memory[TURNED] >= whole - SLACK:
        sums = SUMS + int(memory[STAGE] - BEFORE) * N_SLOT
        for i in range(N_SLOT):
            memory[sums + i] /= memory[COUNT]
        memory[TURNED] -= whole
        memory[COUNT] = 0.0
        if memory[STAGE] == AFTER:
            finish(parameters, orders, powers, memory, table, work)
        else:
            memory[STAGE] += 1.0


@kernel
def begin(parameters: Array, inputs: Array, memory: Array) -> None:
    """Start the first slot."""
    memory[STAGE] = BEFORE
    memory[TURNED] = memory[COUNT] = 0.0
    memory[SPEED] = inputs[OMEGA]
    memory[SCALE] = parameters[FORCE_SCALE]
    memory[REVOLUTIONS] = periods(inputs[OMEGA] / (2.0 * math.pi))
    for i in range(SUMS, RESULT):
        memory[i] = 0.0


@kernel
def disturbance(inputs: Array, asked: bool, valid: bool, limited: bool, contact: bool, memory: Array) -> int:
    """Why the identification cannot go on, or NO_ERROR."""
    if not asked:
        return ABORTED
    if not valid:
        return WINDOW_LOST
    if abs(inputs[OMEGA] - memory[SPEED]) > SPEED_TOLERANCE * memory[SPEED]:
        return SPEED_CHANGED
    if limited:
        return LIMITED
    return CONTACT if contact else NO_ERROR


@kernel
def finish(parameters: Array, orders: Array, powers: Array, memory: Array, table: Array, work: Array) -> None:
    """Receptances from the means of the six slots (6.7); they go into the table if all of them can be inverted."""
    memory[STAGE], memory[REASON] = FAILED, NO_ERROR
    if drifted(parameters[MAX_DRIFT], memory):
        memory[REASON] = DRIFTED
        return
    memory[IDENTIFIED] = memory[SPEED]
    weights = parameters[WEIGHT : WEIGHT + N_SENSORS]
    excited = 0
    for k in range(N_HARMONICS):
        re, im = test_component(parameters, orders, powers, memory, k)
        size = re * re + im * im
        result = memory[RESULT + k * N_MATRIX : RESULT + (k + 1) * N_MATRIX]
        result[:] = 0.0
        memory[CONDITIONS + k] = 0.0
        if orders[k] == 0.0 or (k > 0 and parameters[MULTI] == 0.0):
            continue
        excited = k + 1
        for axis in range(N_AXES):
            loaded, idle = SUMS + (axis + 1) * N_SLOT + k * N_Q, SUMS + k * N_Q
            for s in range(N_SENSORS):
                change_re = memory[loaded + 2 * s] - memory[idle + 2 * s]
                change_im = memory[loaded + 2 * s + 1] - memory[idle + 2 * s + 1]
                at = 2 * (s * N_AXES + axis)
                if size > 0.0:
                    result[at] = (change_re * re + change_im * im) / size
                    result[at + 1] = (change_im * re - change_re * im) / size
        memory[CONDITIONS + k] = invert(result, weights, work[:N_MATRIX], work[N_MATRIX:])
        if memory[CONDITIONS + k] > parameters[MAX_CONDITION]:
            memory[REASON] = ILL_CONDITIONED
    if memory[REASON] != NO_ERROR:
        return
    for k in range(excited):
        result = memory[RESULT + k * N_MATRIX : RESULT + (k + 1) * N_MATRIX]
        invert(result, weights, work[:N_MATRIX], work[N_MATRIX:])
        if not store(table, orders[k], memory[SPEED], result, work[:N_MATRIX]):
            memory[REASON] = TABLE_FULL
            return
    memory[STAGE] = DONE


@kernel
def drifted(limit: float, memory: Array) -> bool:
    """Whether the vibration without force changed by more than a share of the largest response."""
    drift = response = 0.0
    last = SUMS + (N_SLOTS - 1) * N_SLOT
    for i in range(0, N_SLOT, 2):
        re, im = memory[SUMS + i], memory[SUMS + i + 1]
        drift = max(drift, math.hypot(memory[last + i] - re, memory[last + i + 1] - im))
        for axis in range(N_AXES):
            loaded = SUMS + (axis + 1) * N_SLOT + i
            response = max(response, math.hypot(memory[loaded] - re, memory[loaded + 1] - im))
    return drift > limit * response
