"""Views of parameters, inputs and outputs for kernels: records of single variables, arrays of repeated variables."""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import size_of
from rolac_controller.complex_numbers import COMPLEX, REAL, Complex
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.inner_loop import InnerLoop, inner_loop_of
from rolac_controller.interface import SMALLEST
from rolac_controller.sizes import N_SIZES, Records, Sizes

PARAMETERS, INPUTS, OUTPUTS = (SMALLEST.common_record(kind) for kind in ("parameter", "input", "output"))
GAINS = SMALLEST.element_record("parameter", "axes")  # of the PID of an axis
HARMONIC = SMALLEST.element_record("parameter", "harmonics")  # order and power of a harmonic
SENSOR_FAULTS = SMALLEST.element_record("input", "faults")
AXIS_OUTPUTS = SMALLEST.element_record("output", "axes")
SENSOR_OUTPUTS = SMALLEST.element_record("output", "sensors")
HARMONIC_OUTPUTS = SMALLEST.element_record("output", "harmonics")

N_PARAMETERS, N_INPUTS, N_OUTPUTS = size_of(PARAMETERS), size_of(INPUTS), size_of(OUTPUTS)
N_GAINS = size_of(GAINS)
N_FAULTS, N_AXIS, N_SENSOR = size_of(SENSOR_FAULTS), size_of(AXIS_OUTPUTS), size_of(SENSOR_OUTPUTS)
N_ORDERS, N_HARMONIC = N_HARMONICS * size_of(HARMONIC), N_HARMONICS * size_of(HARMONIC_OUTPUTS)


class Parameters(NamedTuple):
    """The parameters of the controller, and those of its constants that are used with them.

    common
        Record `PARAMETERS`, in an array of length 1.
    axes
        Records `GAINS`, shape (n_axes,).
    harmonics
        Records `HARMONIC`, shape (N_HARMONICS,). The first order 0 ends the list of harmonics.
    sensor_weights, sensor_scales
        Weights and scales of the sensors, shape (n_sensors,).
    plane_positions, plane_offsets
        Axial positions of the planes, and offsets of their sensors, shape (n_planes,) (m).
    sensor_of_axis
        Index of the sensor that closes the loop of each axis, shape (n_axes,); from the constants.
    inner
        Response of the additional controller that closes the loop; from the constants.
    """

    common: Records
    axes: Records
    harmonics: Records
    sensor_weights: Array
    sensor_scales: Array
    plane_positions: Array
    plane_offsets: Array
    sensor_of_axis: Array
    inner: InnerLoop


class Inputs(NamedTuple):
    """The inputs of the controller.

    common
        Record `INPUTS`, in an array of length 1.
    displacements
        Displacements at the sensors, shape (n_sensors,) (m).
    setpoints
        Setpoints of the axes, shape (n_axes,) (m).
    faults
        Records `SENSOR_FAULTS`, shape (n_sensors,).
    """

    common: Records
    displacements: Array
    setpoints: Array
    faults: Records


class Outputs(NamedTuple):
    """The outputs of the controller.

    common
        Record `OUTPUTS`, in an array of length 1.
    axes
        Records `AXIS_OUTPUTS`, shape (n_axes,).
    sensors
        Records `SENSOR_OUTPUTS`, shape (n_sensors,).
    harmonics
        Records `HARMONIC_OUTPUTS`, shape (N_HARMONICS,).
    contact_shares
        Fraction of time in contact at each bearing, shape (n_bearings,).
    receptance
        Receptance R, shape (n_sensors, n_axes) (m/N).
    """

    common: Records
    axes: Records
    sensors: Records
    harmonics: Records
    contact_shares: Array
    receptance: Complex


@views
def parameters_of(parameters: Array, constants: Array, sizes: Sizes) -> Parameters:
    """Return views into the parameters and the constants of a controller with these sizes."""
    n_axes, n_sensors, n_planes = sizes.n_axes, sizes.n_sensors, sizes.n_sensors // 2
    axes = N_PARAMETERS
    harmonics = axes + n_axes * N_GAINS
    weights = harmonics + N_ORDERS
    scales = weights + n_sensors
    positions = scales + n_sensors
    return Parameters(
        part(parameters, 0, PARAMETERS, 1),
        part(parameters, axes, GAINS, n_axes),
        part(parameters, harmonics, HARMONIC, N_HARMONICS),
        part(parameters, weights, REAL, n_sensors),
        part(parameters, scales, REAL, n_sensors),
        part(parameters, positions, REAL, n_planes),
        part(parameters, positions + n_planes, REAL, n_planes),
        part(constants, N_SIZES, REAL, n_axes),
        inner_loop_of(constants, sizes),
    )


@views
def inputs_size(sizes: Sizes) -> int:
    """Return the number of inputs of a controller with these sizes."""
    return N_INPUTS + sizes.n_sensors + sizes.n_axes + sizes.n_sensors * N_FAULTS


@views
def inputs_of(inputs: Array, sizes: Sizes) -> Inputs:
    """Return views into the inputs of a controller with these sizes."""
    displacements = N_INPUTS
    setpoints = displacements + sizes.n_sensors
    return Inputs(
        part(inputs, 0, INPUTS, 1),
        part(inputs, displacements, REAL, sizes.n_sensors),
        part(inputs, setpoints, REAL, sizes.n_axes),
        part(inputs, setpoints + sizes.n_axes, SENSOR_FAULTS, sizes.n_sensors),
    )


@views
def outputs_of(outputs: Array, sizes: Sizes) -> Outputs:
    """Return views into the outputs of a controller with these sizes."""
    n_axes, n_sensors, n_bearings = sizes.n_axes, sizes.n_sensors, sizes.n_axes // 2
    axes = N_OUTPUTS
    sensors = axes + n_axes * N_AXIS
    harmonics = sensors + n_sensors * N_SENSOR
    shares = harmonics + N_HARMONIC
    return Outputs(
        part(outputs, 0, OUTPUTS, 1),
        part(outputs, axes, AXIS_OUTPUTS, n_axes),
        part(outputs, sensors, SENSOR_OUTPUTS, n_sensors),
        part(outputs, harmonics, HARMONIC_OUTPUTS, N_HARMONICS),
        part(outputs, shares, REAL, n_bearings),
        part(outputs, shares + n_bearings, COMPLEX, (n_sensors, n_axes)),
    )
