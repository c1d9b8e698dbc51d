"""The receptance from the mean displacements of the six slots of an identification (thesis 6.7).

    Q = Q_0 + R U:   R_i = (Q with a force U_i on axis i - Q without) / U_i

The slot before is the reference; the slot after shows whether the vibration without force has stayed the same.
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.records import record
from rolac_controller.complex_numbers import Complex, quotient
from rolac_controller.enumerations import ILL_CONDITIONED, N_SLOTS, NO_ERROR, TABLE_FULL, VIBRATION_CHANGED
from rolac_controller.excitation import force_component
from rolac_controller.pseudo_inverse import negative_pseudo_inverse
from rolac_controller.receptance_table import TableViews, store
from rolac_controller.rig_layout import N_AXES, N_HARMONICS, N_SENSORS

IDENTIFICATION_MEMORY = record(
    ("stage", "f8"),  # identification_state
    ("error", "f8"),  # identification_error
    ("requested", "f8"),  # the input identify at the sample before
    ("angle", "f8"),  # since the slot began (rad)
    ("speed", "f8"),  # at which the identification began (rad/s)
    ("force_scale", "f8"),
    ("n_revolutions", "f8"),  # of a slot
    ("n_samples", "f8"),  # in the mean of this slot so far
    ("completed_speed", "f8"),  # of the last identification that was completed (rad/s)
    ("conditions", "f8", (N_HARMONICS,)),
    ("Q", "c16", (N_SLOTS, N_HARMONICS, N_SENSORS)),  # mean of each slot, while it runs the sum (m)
    ("R", "c16", (N_HARMONICS, N_SENSORS, N_AXES)),  # last result (m/N)
)


@kernel
def excitation_component(parameters: np.record, memory: np.record, number: int) -> complex:
    """Return one harmonic of the test force (N)."""
    multi, frequency = parameters.identification.multi != 0.0, memory.speed / (2.0 * math.pi)
    return force_component(parameters.harmonics, number, multi, memory.force_scale, frequency)


@kernel
def evaluate(parameters: np.record, memory: np.record, work: np.record, table: TableViews) -> int:
    """Compute the receptances of all harmonics and store them in the table if all of them can be inverted.

    Parameters
    ----------
    parameters
        Record PARAMETERS.
    memory
        Record IDENTIFICATION_MEMORY with the means of all slots; receives R and the condition numbers.
    work
        Record WORK; its `H` and `svd` are overwritten.
    table
        Table in use; updated.

    Returns
    -------
    int
        Value of `identification_error`; NO_ERROR if the table was updated.
    """
    if vibration_changed(memory.Q, parameters.identification.max_drift):
        return VIBRATION_CHANGED
    memory.completed_speed = memory.speed
    error = NO_ERROR
    n_excited = 0
    for k in range(N_HARMONICS):
        memory.R[k][:] = 0.0
        memory.conditions[k] = 0.0
        if parameters.harmonics[k].order == 0.0 or (k > 0 and not parameters.identification.multi):
            continue
        n_excited = k + 1
        divide_by_force(memory.Q, k, excitation_component(parameters, memory, k), memory.R[k])
        memory.conditions[k] = negative_pseudo_inverse(memory.R[k], parameters.sensor_weights, work.H, work.svd)
        if memory.conditions[k] > parameters.identification.max_condition:
            error = ILL_CONDITIONED
    if error != NO_ERROR:
        return error
    for k in range(n_excited):
        negative_pseudo_inverse(memory.R[k], parameters.sensor_weights, work.H, work.svd)
        if not store(table, parameters.harmonics[k].order, memory.speed, memory.R[k], work.H):
            return TABLE_FULL
    return NO_ERROR


@kernel
def divide_by_force(Q: Complex, number: int, force: complex, R: Complex) -> None:
    """Compute R of one harmonic from the means of all slots, shape (N_SLOTS, N_HARMONICS, N_SENSORS) (6.7).

    The first slot and the last are without a test force; slot 1 + k has it on axis k.
    """
    if force == 0.0:
        return
    idle = Q[0, number]
    for axis in range(N_AXES):
        loaded = Q[1 + axis, number]
        for s in range(N_SENSORS):
            R[s, axis] = quotient(loaded[s] - idle[s], force)


@kernel
def vibration_changed(Q: Complex, limit: float) -> bool:
    """Return whether the vibration without force changed by more than a share of the largest response."""
    drift = response = 0.0
    before, after = Q[0], Q[N_SLOTS - 1]
    for k in range(N_HARMONICS):
        for s in range(N_SENSORS):
            drift = max(drift, abs(after[k, s] - before[k, s]))
            for axis in range(N_AXES):
                response = max(response, abs(Q[1 + axis, k, s] - before[k, s]))
    return drift > limit * response
