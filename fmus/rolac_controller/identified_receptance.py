"""Computes the receptance from the mean displacements in the slots of an identification (thesis 5.16).

    Q = Q_0 + R U:   R_i = (Q with a force U_i on axis i - Q without) / U_i

The first slot is the reference, and the last shows whether the vibration without test force has changed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rolac_controller.complex_numbers import COMPLEX, Complex, quotient
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.enumerations import ILL_CONDITIONED, NO_ERROR, TABLE_FULL, VIBRATION_CHANGED
from rolac_controller.excitation import force_component
from rolac_controller.pseudo_inverse import SvdWork, negative_pseudo_inverse
from rolac_controller.receptance_table import TableViews, store
from rolac_controller.records import Parameters
from rolac_controller.sizes import Records, Sizes

COURSE = record(
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
)
N_COURSE = size_of(COURSE)


class IdentificationMemory(NamedTuple):
    """State and results of an identification.

    course
        Record COURSE, in an array of length 1.
    Q
        Mean Q of each slot (during the slot, the sum), shape (n_axes + 2, N_HARMONICS, n_sensors) (m).
    R
        Receptance R from the last identification, shape (N_HARMONICS, n_sensors, n_axes) (m/N).
    """

    course: Records
    Q: Complex
    R: Complex


@views
def identification_memory_size(sizes: Sizes) -> int:
    """Return the size of the memory of an identification."""
    return N_COURSE + 2 * N_HARMONICS * sizes.n_sensors * (2 * sizes.n_axes + 2)


@views
def identification_memory_of(array: Array, start: int, sizes: Sizes) -> IdentificationMemory:
    """Return the memory of an identification as views into an array, beginning at `start`."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    slots = start + N_COURSE
    return IdentificationMemory(
        part(array, start, COURSE, 1),
        part(array, slots, COMPLEX, (n_axes + 2, N_HARMONICS, n_sensors)),
        part(array, slots + 2 * (n_axes + 2) * N_HARMONICS * n_sensors, COMPLEX, (N_HARMONICS, n_sensors, n_axes)),
    )


@kernel
def excitation_component(parameters: Parameters, memory: IdentificationMemory, number: int) -> complex:
    """Return the complex amplitude of a harmonic of the test force (N)."""
    course = memory.course[0]
    multi, frequency = parameters.common[0].identification.multi != 0.0, course.speed / (2.0 * math.pi)
    return force_component(parameters.harmonics, number, multi, course.force_scale, frequency)


@kernel
def evaluate(parameters: Parameters, memory: IdentificationMemory, H: Complex, svd: SvdWork, table: TableViews) -> int:
    """Compute the receptances of all harmonics, and store them in the table if all are invertible.

    Parameters
    ----------
    memory
        Contains the means of all slots; receives R and the condition numbers.
    H, svd
        Overwritten; H has shape (n_axes, n_sensors).
    table
        Table in use; updated.

    Returns
    -------
    int
        Value of `identification_error`; NO_ERROR if the table was updated.
    """
    course, identification = memory.course[0], parameters.common[0].identification
    if vibration_changed(memory.Q, identification.max_drift):
        return VIBRATION_CHANGED
    course.completed_speed = course.speed
    error = NO_ERROR
    n_excited = 0
    for k in range(N_HARMONICS):
        memory.R[k][:] = 0.0
        course.conditions[k] = 0.0
        if parameters.harmonics[k].order == 0.0 or (k > 0 and not identification.multi):
            continue
        n_excited = k + 1
        divide_by_force(memory.Q, k, excitation_component(parameters, memory, k), memory.R[k])
        course.conditions[k] = negative_pseudo_inverse(memory.R[k], parameters.sensor_weights, H, svd)
        if course.conditions[k] > identification.max_condition:
            error = ILL_CONDITIONED
    if error != NO_ERROR:
        return error
    for k in range(n_excited):
        negative_pseudo_inverse(memory.R[k], parameters.sensor_weights, H, svd)
        if not store(table, parameters.harmonics[k].order, course.speed, memory.R[k], H):
            return TABLE_FULL
    return NO_ERROR


@kernel
def divide_by_force(Q: Complex, number: int, force: complex, R: Complex) -> None:
    """Compute R of a harmonic (6.7) from the slot means Q, shape (n_axes + 2, N_HARMONICS, n_sensors).

    The first and the last slot have no test force; in slot 1 + k the force acts on axis k.
    """
    if force == 0.0:
        return
    idle = Q[0, number]
    for axis in range(R.shape[1]):
        loaded = Q[1 + axis, number]
        for s in range(R.shape[0]):
            R[s, axis] = quotient(loaded[s] - idle[s], force)


@kernel
def vibration_changed(Q: Complex, limit: float) -> bool:
    """Return whether the vibration without test force changed by more than `limit` times the largest response."""
    drift = response = 0.0
    n_axes = Q.shape[0] - 2
    before, after = Q[0], Q[n_axes + 1]
    for k in range(N_HARMONICS):
        for s in range(Q.shape[2]):
            drift = max(drift, abs(after[k, s] - before[k, s]))
            for axis in range(n_axes):
                response = max(response, abs(Q[1 + axis, k, s] - before[k, s]))
    return drift > limit * response
