"""From the displacements of the rotor to what the controller reads.

displacement -> axial offset -> scale -> noise, faults -> anti-aliasing filter -> ADC -> measured
"""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.chain import is_on
from rolac_controller.converters import converted
from rolac_controller.faults import faulty
from rolac_controller.interface import (
    ADC,
    ADC_BITS,
    ADC_RANGE,
    BURST,
    CUTOFF,
    FAULT,
    FAULT_INPUTS,
    FILTER,
    NOISE,
    NOISE_RMS,
    PLANE_OFFSET,
    PLANE_Z,
    SAMPLE_TIME,
    SCALE,
    SEED,
    SENSITIVITY,
    SENSOR,
)
from rolac_controller.lowpass import N_FILTER, coefficients, filtered, settle
from rolac_controller.names import N_PLANES, N_SENSORS
from rolac_controller.noise import N_STREAM, normal_pair, seed

# Layout of the memory: random numbers, what each sensor last showed, filters.
STREAM = 0
SHOWN = STREAM + N_STREAM
FILTERS = SHOWN + N_SENSORS
N_MEMORY = FILTERS + N_SENSORS * N_FILTER


@kernel
def share_of_plane(parameters: Array, plane: int, other: int) -> float:
    """Share of the displacement of plane `other` in that of the sensors of `plane`, which may sit beside it.

    Lagrange's cubic through the four planes: the sensors are where the bent shaft is, to third order.
    """
    z = parameters[PLANE_Z + plane] + parameters[PLANE_OFFSET + plane]
    share = 1.0
    for k in range(N_PLANES):
        if k != other:
            z_k = parameters[PLANE_Z + k]
            share *= (z - z_k) / (parameters[PLANE_Z + other] - z_k)
    return share


@kernel
def displacement(parameters: Array, inputs: Array, sensor: int) -> float:
    """Displacement of the rotor at a sensor (m)."""
    plane, axis = sensor // 2, sensor % 2
    if parameters[PLANE_OFFSET + plane] == 0.0:
        at_plane: float = inputs[SENSOR + sensor]
        return at_plane
    total = 0.0
    for other in range(N_PLANES):
        total += share_of_plane(parameters, plane, other) * inputs[SENSOR + 2 * other + axis]
    return total


@kernel
def show(parameters: Array, inputs: Array, memory: Array, started: bool, sampling: bool) -> None:
    """Signals of the sensors themselves, faults included, into `memory`; arguments as of `measure`."""
    deviation = parameters[NOISE_RMS] if is_on(parameters, NOISE) else 0.0
    for pair in range(N_SENSORS // 2):
        noise_x = noise_y = 0.0
        fault_x = FAULT + 2 * pair * FAULT_INPUTS
        fault_y = fault_x + FAULT_INPUTS
        x, y = SHOWN + 2 * pair, SHOWN + 2 * pair + 1
        deviation_x = math.sqrt(deviation**2 + inputs[fault_x + BURST] ** 2)
        deviation_y = math.sqrt(deviation**2 + inputs[fault_y + BURST] ** 2)
        if sampling and deviation_x + deviation_y > 0.0:
            noise_x, noise_y = normal_pair(memory[STREAM : STREAM + N_STREAM])
        at_x = parameters[SCALE + 2 * pair] * displacement(parameters, inputs, 2 * pair) + deviation_x * noise_x
        at_y = parameters[SCALE + 2 * pair + 1] * displacement(parameters, inputs, 2 * pair + 1) + deviation_y * noise_y
        memory[x] = faulty(inputs[fault_x:fault_y], at_x, memory[x] if started else at_x)
        memory[y] = faulty(inputs[fault_y : fault_y + FAULT_INPUTS], at_y, memory[y] if started else at_y)


@kernel
def measure(parameters: Array, inputs: Array, memory: Array, started: bool, sampling: bool, measured: Array) -> None:
    """What the controller reads of the eight sensors at this sample.

    Parameters
    ----------
    memory
        Memory of the chain, shape (N_MEMORY,).
    started
        Whether there was a sample before; filters begin at rest at the first one.
    sampling
        Whether this is a sample, and not the initialisation, which is without noise.
    measured
        Receives the displacements, shape (N_SENSORS,) (m).
    """
    if not started:
        seed(memory[STREAM : STREAM + N_STREAM], parameters[SEED])
    show(parameters, inputs, memory, started, sampling)
    if is_on(parameters, FILTER):
        decay, new = coefficients(parameters[CUTOFF], parameters[SAMPLE_TIME])
        for s in range(N_SENSORS):
            of_sensor = memory[FILTERS + s * N_FILTER : FILTERS + (s + 1) * N_FILTER]
            if started:
                measured[s] = filtered(of_sensor, memory[SHOWN + s], decay, new)
            else:
                settle(of_sensor, memory[SHOWN + s])
                measured[s] = memory[SHOWN + s]
    else:
        copy(memory[SHOWN:FILTERS], measured)
    if is_on(parameters, ADC):
        volts_per_metre = parameters[SENSITIVITY]
        for s in range(N_SENSORS):
            volts = converted(volts_per_metre * measured[s], parameters[ADC_BITS], parameters[ADC_RANGE])
            measured[s] = volts / volts_per_metre
