"""Turns sensor signals into the readings of a controller.

ideal signal -> noise, faults -> anti-aliasing filter -> ADC -> reading

An ideal signal is the signal of a sensor without noise and faults: the measured value times the sensor's scale.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fmi_export.jit import inlined_kernel, views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from signal_chain.converters import converter_of, quantised
from signal_chain.lowpass import FILTER, coefficients, filter_sample, start_at_rest
from signal_chain.noise import STREAM, normal_pair, start_stream
from signal_chain.presets import is_on
from signal_chain.sensor_faults import with_faults

Records = np.ndarray[tuple[int], np.dtype[np.record]]

SENSOR = record(("signal", "f8"), ("filter", FILTER))  # the sensor's signal at the last sample
N_STREAM, N_SENSOR = size_of(STREAM), size_of(SENSOR)


class SensorMemory(NamedTuple):
    """State of the random numbers, record STREAM in an array of length 1, and records SENSOR of the sensors."""

    random: Records
    sensors: Records


@views
def sensor_memory_size(n_sensors: int) -> int:
    """Return the size of the memory for `n_sensors` sensors."""
    return N_STREAM + n_sensors * N_SENSOR


@views
def sensor_memory_of(array: Array, start: int, n_sensors: int) -> SensorMemory:
    """Return the memory of the sensors as views into an array, beginning at `start`."""
    return SensorMemory(part(array, start, STREAM, 1), part(array, start + N_STREAM, SENSOR, n_sensors))


@inlined_kernel
def add_noise(deviation: float, faults: Records, random: Records, signals: Array) -> None:
    """Add noise with this standard deviation, and the noise of faults; random numbers are generated in pairs."""
    n = signals.shape[0]
    for x in range(0, n, 2):
        y = min(x + 1, n - 1)
        deviation_x = math.sqrt(deviation**2 + faults[x].noise ** 2)
        deviation_y = math.sqrt(deviation**2 + faults[y].noise ** 2)
        if deviation_x + deviation_y > 0.0:
            normal_x, normal_y = normal_pair(random[0])
            signals[x] += deviation_x * normal_x
            if y > x:
                signals[y] += deviation_y * normal_y


@inlined_kernel
def read(p: np.record, faults: Records, memory: SensorMemory, started: bool, sampling: bool, signals: Array) -> bool:
    """Turn ideal signals into the controller's readings; return whether a signal is beyond the range of the ADC.

    Parameters
    ----------
    p
        The controller's parameters: `sample_time` (s) and the record `chain`.
    faults
        Fault inputs of the sensors.
    memory
        Memory of the sensors; changed.
    started
        Whether there was an earlier sample; at the first sample, filters are at rest.
    sampling
        Whether this is a sample; false at initialisation, when no noise is added.
    signals
        Ideal signals, shape (n_sensors,); receives the readings.
    """
    chain = p.chain
    if not started:
        start_stream(memory.random[0], chain.seed)
    if sampling:
        add_noise(chain.noise_rms if is_on(chain.preset, chain.noise) else 0.0, faults, memory.random, signals)
    filtering = is_on(chain.preset, chain.filter)
    E, P = coefficients(chain.cutoff, p.sample_time) if filtering else (0.0, 0.0)
    for s in range(signals.shape[0]):
        sensor = memory.sensors[s]
        signal = with_faults(faults[s], signals[s], sensor.signal if started else signals[s])
        sensor.signal = signal
        signals[s] = signal
        if filtering and started:
            signals[s] = filter_sample(sensor.filter, signal, E, P)
        elif filtering:
            start_at_rest(sensor.filter, signal)
    beyond_range = False
    if is_on(chain.preset, chain.adc):
        adc = converter_of(chain.adc_bits, chain.adc_range)
        for s in range(signals.shape[0]):
            volts = chain.sensitivity * signals[s]
            beyond_range = beyond_range or abs(volts) > chain.adc_range
            signals[s] = quantised(volts, adc) / chain.sensitivity
    return beyond_range
