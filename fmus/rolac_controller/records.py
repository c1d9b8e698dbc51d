"""How kernels see parameters, inputs and outputs: a record of those that stand alone, and arrays of the rest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.records import size_of
from rolac_controller.complex_numbers import Complex
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.interface import SMALLEST
from rolac_controller.sizes import N_SIZES, Sizes

Records = np.ndarray[tuple[int], np.dtype[np.record]]

PARAMETERS, INPUTS, OUTPUTS = (SMALLEST.own_record(kind) for kind in ("parameter", "input", "output"))
GAINS = SMALLEST.element_record("parameter", "axes")  # of the PID of one axis
HARMONIC = SMALLEST.element_record("parameter", "harmonics")  # order and power of one harmonic
SENSOR_FAULTS = SMALLEST.element_record("input", "faults")
AXIS_OUTPUTS = SMALLEST.element_record("output", "axes")
SENSOR_OUTPUTS = SMALLEST.element_record("output", "sensors")
HARMONIC_OUTPUTS = SMALLEST.element_record("output", "harmonics")

N_PARAMETERS, N_INPUTS, N_OUTPUTS = size_of(PARAMETERS), size_of(INPUTS), size_of(OUTPUTS)
N_GAINS, N_FAULTS = size_of(GAINS), size_of(SENSOR_FAULTS)
N_AXIS, N_SENSOR = size_of(AXIS_OUTPUTS), size_of(SENSOR_OUTPUTS)
N_ORDERS, N_HARMONIC = N_HARMONICS * size_of(HARMONIC), N_HARMONICS * size_of(HARMONIC_OUTPUTS)


class Parameters(NamedTuple):
    """Record of type `PARAMETERS`, in an array of one, and the parameters of axes, harmonics, sensors and planes.

    axes, harmonics
        Records `GAINS`, shape (n_axes,), and `HARMONIC`, shape (N_HARMONICS,); the first order 0 ends them.
    sensor_weights, sensor_scales
        Shape (n_sensors,).
    plane_positions, plane_offsets
        Shape (n_planes,) (m).
    sensor_of_axis
        From the constants: number of the sensor that closes the loop of each axis, shape (n_axes,).
    """

    own: Records
    axes: Records
    harmonics: Records
    sensor_weights: Array
    sensor_scales: Array
    plane_positions: Array
    plane_offsets: Array
    sensor_of_axis: Array


class Inputs(NamedTuple):
    """Record of type `INPUTS`, in an array of one; displacements (m), setpoints (m); records `SENSOR_FAULTS`."""

    own: Records
    displacements: Array
    setpoints: Array
    faults: Records


class Outputs(NamedTuple):
    """Record of type `OUTPUTS`, in an array of one; records of axes, sensors, harmonics; shares of contact; R (m/N)."""

    own: Records
    axes: Records
    sensors: Records
    harmonics: Records
    contact_shares: Array
    receptance: Complex


@views
def parameters_of(parameters: Array, constants: Array, sizes: Sizes) -> Parameters:
    """Return views into the parameters, and into the constants, of a controller of these sizes."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    own, rest = parameters[:N_PARAMETERS].view(PARAMETERS), parameters[N_PARAMETERS:]
    axes, rest = rest[: n_axes * N_GAINS].view(GAINS), rest[n_axes * N_GAINS :]
    harmonics, rest = rest[:N_ORDERS].view(HARMONIC), rest[N_ORDERS:]
    weights, rest = rest[:n_sensors], rest[n_sensors:]
    scales, rest = rest[:n_sensors], rest[n_sensors:]
    n_planes = n_sensors // 2
    feedback = constants[N_SIZES : N_SIZES + n_axes]
    return Parameters(own, axes, harmonics, weights, scales, rest[:n_planes], rest[n_planes : 2 * n_planes], feedback)


@views
def inputs_of(inputs: Array, sizes: Sizes) -> Inputs:
    """Return views into the inputs of a controller of these sizes."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    own, rest = inputs[:N_INPUTS].view(INPUTS), inputs[N_INPUTS:]
    displacements, rest = rest[:n_sensors], rest[n_sensors:]
    setpoints, rest = rest[:n_axes], rest[n_axes:]
    return Inputs(own, displacements, setpoints, rest[: n_sensors * N_FAULTS].view(SENSOR_FAULTS))


@views
def outputs_of(outputs: Array, sizes: Sizes) -> Outputs:
    """Return views into the outputs of a controller of these sizes."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    own, rest = outputs[:N_OUTPUTS].view(OUTPUTS), outputs[N_OUTPUTS:]
    axes, rest = rest[: n_axes * N_AXIS].view(AXIS_OUTPUTS), rest[n_axes * N_AXIS :]
    sensors, rest = rest[: n_sensors * N_SENSOR].view(SENSOR_OUTPUTS), rest[n_sensors * N_SENSOR :]
    harmonics, rest = rest[:N_HARMONIC].view(HARMONIC_OUTPUTS), rest[N_HARMONIC:]
    shares, rest = rest[: n_axes // 2], rest[n_axes // 2 :]
    receptance = rest[: 2 * n_sensors * n_axes].view(np.complex128).reshape(n_sensors, n_axes)
    return Outputs(own, axes, sensors, harmonics, shares, receptance)
