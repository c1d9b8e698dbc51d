"""Response of the controller's sensors and filter to a vibration in the sampled loop."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

from amb_cosim.model_constants.controller_data import no_table
from array_types import Array, Complex
from rolac_controller.control_loop import ControlLoop
from rolac_controller.interface import interface_of
from rolac_controller.records import Parameters, parameters_of
from rolac_controller.sensors import plane_weight
from rolac_controller.sizes import sizes_of
from signal_chain.lowpass import coefficients
from signal_chain.presets import is_on

table_of = cache(interface_of)  # one search for gains reads it hundreds of times


def parameters_of_loop(loop: ControlLoop, parameters: Mapping[str, float]) -> Parameters:
    """Return the parameters of a controller as a kernel record: the given values, and start values for the rest.

    Raises
    ------
    ValueError
        If the controller has no parameter of a given name.
    """
    table, constants = table_of(loop), no_table(loop)
    values: Array = table.start[: table.n_parameters].copy()
    for name, value in parameters.items():
        values[table.index("parameter", name)] = value
    return parameters_of(values, constants, sizes_of(constants))


def filter_response(cutoff: float, omega: float, sample_time: float) -> complex:
    """Return the response of the anti-aliasing filter to samples of a vibration at omega (rad/s)."""
    decay, new = coefficients(cutoff, sample_time)
    z = np.exp(1j * omega * sample_time)
    return complex((1.0 - decay - new + new * z) / (z - decay))


def sensor_matrix(parameters: Parameters) -> Array:
    """Return the matrix from displacements in the sensor planes to sensor readings (1), shape (n_sensors, n_sensors).

    Each sensor has a scale. A sensor that is off its plane also responds to the displacements in the other planes
    (`sensors.plane_weight`).
    """
    planes = range(len(parameters.plane_positions))
    weights = np.array([[plane_weight(parameters, p, q) for q in planes] for p in planes])
    return np.asarray(parameters.sensor_scales[:, np.newaxis] * np.kron(weights, np.eye(2)), dtype=np.float64)


def axis_matrix(parameters: Parameters) -> Array:
    """Return the matrix from displacements in all planes to sensor readings of axes (1), shape (n_axes, n_sensors)."""
    return sensor_matrix(parameters)[np.asarray(parameters.sensor_of_axis, dtype=np.intp)]


def sensor_response(parameters: Parameters, omega: float) -> Complex:
    """Return F, the ratio of measured to true vibration at omega (rad/s), shape (n_sensors, n_sensors)."""
    common, filtered = parameters.common[0], 1.0 + 0j
    if is_on(common.chain.preset, common.chain.filter):
        filtered = filter_response(common.chain.cutoff, omega, common.sample_time)
    return np.asarray(sensor_matrix(parameters) * filtered, dtype=np.complex128)
