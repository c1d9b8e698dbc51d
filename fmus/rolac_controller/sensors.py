"""From the displacements of the rotor to what the controller reads.

displacement -> axial offset -> scale -> noise, faults -> anti-aliasing filter -> ADC -> measured
"""

from __future__ import annotations

import math

import numpy as np

from fmi_export.jit import kernel
from fmi_export.model import Array
from fmi_export.records import record
from rolac_controller.chain import is_on
from rolac_controller.converters import quantised
from rolac_controller.faults import with_faults
from rolac_controller.lowpass import FILTER, coefficients, filter_sample, start_at_rest
from rolac_controller.noise import STREAM, normal_pair, start_stream
from rolac_controller.rig_layout import N_PLANES, N_SENSORS

SENSOR_MEMORY = record(
    ("random", STREAM),
    ("shown", "f8", (N_SENSORS,)),  # by each sensor at the last sample (m)
    ("filters", FILTER, (N_SENSORS,)),
)


@kernel
def plane_weight(parameters: np.record, plane: int, other: int) -> float:
    """Return the weight of the displacement of plane `other` in that of the sensors of `plane`.

    Sensors may sit beside their plane: Lagrange's cubic through the four planes interpolates the bent shaft there.
    """
    z = parameters.plane_positions[plane] + parameters.plane_offsets[plane]
    z_other = parameters.plane_positions[other]
    weight = 1.0
    for k in range(N_PLANES):
        if k != other:
            z_k = parameters.plane_positions[k]
            weight *= (z - z_k) / (z_other - z_k)
    return weight


@kernel
def displacement_at(parameters: np.record, inputs: np.record, sensor: int) -> float:
    """Return the displacement of the rotor at a sensor (m)."""
    plane, axis = sensor // 2, sensor % 2
    if parameters.plane_offsets[plane] == 0.0:
        at_plane: float = inputs.displacements[sensor]
        return at_plane
    total = 0.0
    for other in range(N_PLANES):
        total += plane_weight(parameters, plane, other) * inputs.displacements[2 * other + axis]
    return total


@kernel
def shown_signal(
    parameters: np.record, inputs: np.record, memory: np.record, sensor: int, noise: float, started: bool
) -> float:
    """Return what a sensor shows, faults and noise (m) included; `started` as in `measure`."""
    sound = parameters.sensor_scales[sensor] * displacement_at(parameters, inputs, sensor) + noise
    return with_faults(inputs.faults[sensor], sound, memory.shown[sensor] if started else sound)


@kernel
def update_shown(parameters: np.record, inputs: np.record, memory: np.record, started: bool, sampling: bool) -> None:
    """Update what the sensors show; arguments as in `measure`. Random numbers come in pairs, for x and for y."""
    chain = parameters.chain
    deviation = chain.noise_rms if is_on(chain.preset, chain.noise) else 0.0
    for x in range(0, N_SENSORS, 2):
        y = x + 1
        deviation_x = math.sqrt(deviation**2 + inputs.faults[x].noise ** 2)
        deviation_y = math.sqrt(deviation**2 + inputs.faults[y].noise ** 2)
        normal_x = normal_y = 0.0
        if sampling and deviation_x + deviation_y > 0.0:
            normal_x, normal_y = normal_pair(memory.random)
        memory.shown[x] = shown_signal(parameters, inputs, memory, x, deviation_x * normal_x, started)
        memory.shown[y] = shown_signal(parameters, inputs, memory, y, deviation_y * normal_y, started)


@kernel
def measure(
    parameters: np.record, inputs: np.record, memory: np.record, started: bool, sampling: bool, measured: Array
) -> None:
    """Compute what the controller reads of the eight sensors at this sample.

    Parameters
    ----------
    parameters, inputs
        Records PARAMETERS and INPUTS.
    memory
        Record SENSOR_MEMORY; changed.
    started
        Whether there was a sample before; filters begin at rest at the first one.
    sampling
        Whether this is a sample, and not the initialisation, which is without noise.
    measured
        Receives the displacements, shape (N_SENSORS,) (m).
    """
    chain = parameters.chain
    if not started:
        start_stream(memory.random, chain.seed)
    update_shown(parameters, inputs, memory, started, sampling)
    filtering = is_on(chain.preset, chain.filter)
    E, P = coefficients(chain.cutoff, parameters.sample_time) if filtering else (0.0, 0.0)
    for s in range(N_SENSORS):
        measured[s] = memory.shown[s]
        if filtering and started:
            measured[s] = filter_sample(memory.filters[s], memory.shown[s], E, P)
        elif filtering:
            start_at_rest(memory.filters[s], memory.shown[s])
    if is_on(chain.preset, chain.adc):
        for s in range(N_SENSORS):
            volts = quantised(chain.sensitivity * measured[s], chain.adc_bits, chain.adc_range)
            measured[s] = volts / chain.sensitivity
