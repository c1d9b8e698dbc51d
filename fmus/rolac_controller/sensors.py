"""From the displacements of the rotor to what the controller reads.

displacement -> axial offset -> scale -> noise, faults -> anti-aliasing filter -> ADC -> measured
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fmi_export.jit import inlined_kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rolac_controller.chain import is_on
from rolac_controller.converters import quantised
from rolac_controller.lowpass import FILTER, coefficients, filter_sample, start_at_rest
from rolac_controller.noise import STREAM, normal_pair, start_stream
from rolac_controller.records import Inputs, Parameters, Records
from rolac_controller.sensor_faults import with_faults

SENSOR = record(("shown", "f8"), ("filter", FILTER))  # what the sensor showed at the last sample (m)
N_STREAM, N_SENSOR = size_of(STREAM), size_of(SENSOR)


class SensorMemory(NamedTuple):
    """Random numbers, record STREAM in an array of one, and records SENSOR."""

    random: Records
    each: Records


@views
def sensor_memory_size(n_sensors: int) -> int:
    """Return the size of the memory of so many sensors."""
    return N_STREAM + n_sensors * N_SENSOR


@views
def sensor_memory_of(array: Array, start: int, n_sensors: int) -> SensorMemory:
    """Return the memory of the sensors as views into an array from `start` on."""
    return SensorMemory(part(array, start, STREAM, 1), part(array, start + N_STREAM, SENSOR, n_sensors))


@inlined_kernel
def plane_weight(parameters: Parameters, plane: int, other: int) -> float:
    """Return the weight of the displacement of plane `other` in that of the sensors of `plane`.

    Sensors may sit beside their plane: Lagrange's polynomial through all planes interpolates the bent shaft there.
    """
    z = parameters.plane_positions[plane] + parameters.plane_offsets[plane]
    z_other = parameters.plane_positions[other]
    weight = 1.0
    for k in range(parameters.plane_positions.shape[0]):
        if k != other:
            z_k = parameters.plane_positions[k]
            weight *= (z - z_k) / (z_other - z_k)
    return weight


@inlined_kernel
def displacement_at(parameters: Parameters, inputs: Inputs, plane: int, axis: int) -> float:
    """Return the displacement of the rotor at a sensor (m), that of axis x (0) or y (1) of a plane."""
    if parameters.plane_offsets[plane] == 0.0:
        at_plane: float = inputs.displacements[2 * plane + axis]
        return at_plane
    total = 0.0
    for other in range(parameters.plane_positions.shape[0]):
        total += plane_weight(parameters, plane, other) * inputs.displacements[2 * other + axis]
    return total


@inlined_kernel
def show(inputs: Inputs, memory: SensorMemory, sensor: int, sound: float, started: bool) -> None:
    """Update what a sensor shows, from what it would show without faults (m); `started` as in `measure`."""
    shown = memory.each[sensor].shown
    memory.each[sensor].shown = with_faults(inputs.faults[sensor], sound, shown if started else sound)


@inlined_kernel
def update_shown(parameters: Parameters, inputs: Inputs, memory: SensorMemory, started: bool, sampling: bool) -> None:
    """Update what the sensors show; arguments as in `measure`. Random numbers come in pairs, for x and for y."""
    chain, scales = parameters.own[0].chain, parameters.sensor_scales
    deviation = chain.noise_rms if is_on(chain.preset, chain.noise) else 0.0
    for plane in range(parameters.plane_offsets.shape[0]):
        x, y = 2 * plane, 2 * plane + 1
        deviation_x = math.sqrt(deviation**2 + inputs.faults[x].noise ** 2)
        deviation_y = math.sqrt(deviation**2 + inputs.faults[y].noise ** 2)
        normal_x = normal_y = 0.0
        if sampling and deviation_x + deviation_y > 0.0:
            normal_x, normal_y = normal_pair(memory.random[0])
        sound_x = scales[x] * displacement_at(parameters, inputs, plane, 0) + deviation_x * normal_x
        sound_y = scales[y] * displacement_at(parameters, inputs, plane, 1) + deviation_y * normal_y
        show(inputs, memory, x, sound_x, started)
        show(inputs, memory, y, sound_y, started)


@inlined_kernel
def measure(
    parameters: Parameters, inputs: Inputs, memory: SensorMemory, started: bool, sampling: bool, measured: Array
) -> bool:
    """Compute what the controller reads of the sensors at this sample; return whether one is beyond the ADC range.

    Parameters
    ----------
    memory
        Changed.
    started
        Whether there was a sample before; filters begin at rest at the first one.
    sampling
        Whether this is a sample, and not the initialisation, which is without noise.
    measured
        Receives the displacements, shape (n_sensors,) (m).
    """
    chain = parameters.own[0].chain
    if not started:
        start_stream(memory.random[0], chain.seed)
    update_shown(parameters, inputs, memory, started, sampling)
    filtering = is_on(chain.preset, chain.filter)
    E, P = coefficients(chain.cutoff, parameters.own[0].sample_time) if filtering else (0.0, 0.0)
    for s in range(measured.shape[0]):
        sensor = memory.each[s]
        measured[s] = sensor.shown
        if filtering and started:
            measured[s] = filter_sample(sensor.filter, sensor.shown, E, P)
        elif filtering:
            start_at_rest(sensor.filter, sensor.shown)
    beyond_range = False
    if is_on(chain.preset, chain.adc):
        for s in range(measured.shape[0]):
            signal = chain.sensitivity * measured[s]
            beyond_range = beyond_range or abs(signal) > chain.adc_range
            measured[s] = quantised(signal, chain.adc_bits, chain.adc_range) / chain.sensitivity
    return beyond_range
