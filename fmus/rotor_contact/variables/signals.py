"""Parameters, inputs and outputs as kernels see them: a record of single variables, and arrays of the others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import size_of
from rotor_contact.shaft.structure import REAL, Structure
from rotor_contact.variables.interface import SMALLEST

Records = np.ndarray[tuple[int], np.dtype[np.record]]

PARAMETERS, INPUTS, OUTPUTS = (SMALLEST.common_record(kind) for kind in ("parameter", "input", "output"))
SITE_PARAMETERS = SMALLEST.element_record("parameter", "sites")
BEARING_PARAMETERS = SMALLEST.element_record("parameter", "bearings")
AXIS_INPUTS = SMALLEST.element_record("input", "axes")
DISC_INPUTS = SMALLEST.element_record("input", "discs")
CORE_INPUTS = SMALLEST.element_record("input", "cores")
SITE_OUTPUTS = SMALLEST.element_record("output", "sites")
SEAL_OUTPUTS = SMALLEST.element_record("output", "seals")

N_PARAMETERS, N_INPUTS, N_OUTPUTS = size_of(PARAMETERS), size_of(INPUTS), size_of(OUTPUTS)
N_SITE_PARAMETERS, N_BEARING_PARAMETERS = size_of(SITE_PARAMETERS), size_of(BEARING_PARAMETERS)
N_AXIS, N_DISC, N_CORE, N_SITE_OUTPUTS = (size_of(r) for r in (AXIS_INPUTS, DISC_INPUTS, CORE_INPUTS, SITE_OUTPUTS))


class Parameters(NamedTuple):
    """Single parameters as a record of type `PARAMETERS`, in an array of one, and those of the sites and the bearings.

    Site parameters are numbers, shape (n_sites, N_SITE_PARAMETERS).
    """

    scalars: Records
    sites: Array
    bearings: Records


class Inputs(NamedTuple):
    """Single inputs as a record of type `INPUTS`, in an array of one; records of axes, discs and cores of bearings.

    Axes alternate x and y of each bearing.
    """

    scalars: Records
    axes: Records
    discs: Records
    cores: Records


class Outputs(NamedTuple):
    """Single outputs as a record of type `OUTPUTS`, in an array of one; displacements (m) at axes and sensors; records
    of sites and seals."""

    scalars: Records
    displacements: Array
    sensors: Array
    sites: Records
    seals: Records


@views
def n_parameters(structure: Structure) -> int:
    """Return the number of all parameters."""
    n_sites, n_bearings = structure.sites.shape[0], structure.bearings.shape[0]
    return N_PARAMETERS + n_sites * N_SITE_PARAMETERS + n_bearings * N_BEARING_PARAMETERS


@views
def first_disc_input(structure: Structure) -> int:
    """Return the position of the inputs after those of the bearings' axes."""
    return N_INPUTS + 2 * structure.bearings.shape[0] * N_AXIS


@views
def n_inputs(structure: Structure) -> int:
    """Return the number of all inputs."""
    n_discs = structure.B_disc.shape[0] // 2
    return first_disc_input(structure) + n_discs * N_DISC + structure.bearings.shape[0] * N_CORE


@views
def parameters_of(parameters: Array, structure: Structure) -> Parameters:
    """Return views into the parameters of a plant with this structure."""
    n_sites, n_bearings = structure.sites.shape[0], structure.bearings.shape[0]
    return Parameters(
        part(parameters, 0, PARAMETERS, 1),
        part(parameters, N_PARAMETERS, REAL, (n_sites, N_SITE_PARAMETERS)),
        part(parameters, N_PARAMETERS + n_sites * N_SITE_PARAMETERS, BEARING_PARAMETERS, n_bearings),
    )


@views
def inputs_of(inputs: Array, structure: Structure) -> Inputs:
    """Return views into the inputs of a plant with this structure."""
    n_bearings, n_discs = structure.bearings.shape[0], structure.B_disc.shape[0] // 2
    discs = first_disc_input(structure)
    return Inputs(
        part(inputs, 0, INPUTS, 1),
        part(inputs, N_INPUTS, AXIS_INPUTS, 2 * n_bearings),
        part(inputs, discs, DISC_INPUTS, n_discs),
        part(inputs, discs + n_discs * N_DISC, CORE_INPUTS, n_bearings),
    )


@views
def outputs_of(outputs: Array, structure: Structure) -> Outputs:
    """Return views into the outputs of a plant with this structure."""
    n_axes, n_sensors = 2 * structure.bearings.shape[0], structure.sensors.shape[0]
    n_sites = structure.sites.shape[0]
    seals = N_OUTPUTS + n_axes + n_sensors + n_sites * N_SITE_OUTPUTS
    return Outputs(
        part(outputs, 0, OUTPUTS, 1),
        part(outputs, N_OUTPUTS, REAL, n_axes),
        part(outputs, N_OUTPUTS + n_axes, REAL, n_sensors),
        part(outputs, N_OUTPUTS + n_axes + n_sensors, SITE_OUTPUTS, n_sites),
        part(outputs, seals, SEAL_OUTPUTS, structure.seals.records.shape[1]),
    )
