"""Parameters, inputs and outputs as kernels see them: single variables in a record, and all others in arrays."""

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
FACE_PARAMETERS, FACE_OUTPUTS = (SMALLEST.element_record(kind, "faces") for kind in ("parameter", "output"))
AXIAL_PARAMETERS, AXIAL_INPUTS, AXIAL_OUTPUTS = (
    SMALLEST.element_record(kind, "thrust") for kind in ("parameter", "input", "output")
)

N_PARAMETERS, N_INPUTS, N_OUTPUTS = size_of(PARAMETERS), size_of(INPUTS), size_of(OUTPUTS)
N_SITE_PARAMETERS, N_BEARING_PARAMETERS = size_of(SITE_PARAMETERS), size_of(BEARING_PARAMETERS)
N_AXIS, N_DISC, N_CORE, N_SITE_OUTPUTS = (size_of(r) for r in (AXIS_INPUTS, DISC_INPUTS, CORE_INPUTS, SITE_OUTPUTS))
N_SEAL_OUTPUTS, N_AXIAL_PARAMETERS, N_AXIAL_INPUTS, N_AXIAL_OUTPUTS, N_FACE_PARAMETERS = (
    size_of(r) for r in (SEAL_OUTPUTS, AXIAL_PARAMETERS, AXIAL_INPUTS, AXIAL_OUTPUTS, FACE_PARAMETERS)
)


class Parameters(NamedTuple):
    """Parameters as views."""

    scalars: Records  # single ones, of type `PARAMETERS`, in an array of length 1
    sites: Array  # as numbers, shape (n_sites, N_SITE_PARAMETERS)
    bearings: Records
    thrust: Records  # one of the motion along the shaft, or none
    faces: Array  # as numbers, shape (n_faces, N_FACE_PARAMETERS)


class Inputs(NamedTuple):
    """Inputs as views."""

    scalars: Records  # single ones, of type `INPUTS`, in an array of length 1
    axes: Records  # x and y of each bearing in turn
    discs: Records
    cores: Records  # of the bearings
    thrust: Records  # one of the motion along the shaft, or none


class Outputs(NamedTuple):
    """Outputs as views."""

    scalars: Records  # single ones, of type `OUTPUTS`, in an array of length 1
    displacements: Array  # at the axes (m)
    sensors: Array  # at the sensors (m)
    sites: Records
    seals: Records
    thrust: Records  # one of the motion along the shaft, or none
    faces: Records


@views
def n_parameters(structure: Structure) -> int:
    """Return the total number of parameters."""
    n_sites, n_bearings = structure.sites.shape[0], structure.bearings.shape[0]
    of_parts = n_sites * N_SITE_PARAMETERS + n_bearings * N_BEARING_PARAMETERS
    along = structure.n_thrust * N_AXIAL_PARAMETERS + structure.n_faces * N_FACE_PARAMETERS
    return N_PARAMETERS + of_parts + along


@views
def first_disc_input(structure: Structure) -> int:
    """Return the position of the input that follows the inputs of the bearings' axes."""
    return N_INPUTS + 2 * structure.bearings.shape[0] * N_AXIS


@views
def n_inputs(structure: Structure) -> int:
    """Return the total number of inputs."""
    n_discs = structure.B_disc.shape[0] // 2
    of_planes = n_discs * N_DISC + structure.bearings.shape[0] * N_CORE
    return first_disc_input(structure) + of_planes + structure.n_thrust * N_AXIAL_INPUTS


@views
def parameters_of(parameters: Array, structure: Structure) -> Parameters:
    """Return views into the parameters of a plant with this structure."""
    n_sites, n_bearings = structure.sites.shape[0], structure.bearings.shape[0]
    bearings = N_PARAMETERS + n_sites * N_SITE_PARAMETERS
    thrust = bearings + n_bearings * N_BEARING_PARAMETERS
    faces = thrust + structure.n_thrust * N_AXIAL_PARAMETERS
    return Parameters(
        part(parameters, 0, PARAMETERS, 1),
        part(parameters, N_PARAMETERS, REAL, (n_sites, N_SITE_PARAMETERS)),
        part(parameters, bearings, BEARING_PARAMETERS, n_bearings),
        part(parameters, thrust, AXIAL_PARAMETERS, structure.n_thrust),
        part(parameters, faces, REAL, (structure.n_faces, N_FACE_PARAMETERS)),
    )


@views
def inputs_of(inputs: Array, structure: Structure) -> Inputs:
    """Return views into the inputs of a plant with this structure."""
    n_bearings, n_discs = structure.bearings.shape[0], structure.B_disc.shape[0] // 2
    discs = first_disc_input(structure)
    cores = discs + n_discs * N_DISC
    return Inputs(
        part(inputs, 0, INPUTS, 1),
        part(inputs, N_INPUTS, AXIS_INPUTS, 2 * n_bearings),
        part(inputs, discs, DISC_INPUTS, n_discs),
        part(inputs, cores, CORE_INPUTS, n_bearings),
        part(inputs, cores + n_bearings * N_CORE, AXIAL_INPUTS, structure.n_thrust),
    )


@views
def outputs_of(outputs: Array, structure: Structure) -> Outputs:
    """Return views into the outputs of a plant with this structure."""
    n_axes, n_sensors = 2 * structure.bearings.shape[0], structure.sensors.shape[0]
    n_sites, n_seals = structure.sites.shape[0], structure.seals.records.shape[1]
    seals = N_OUTPUTS + n_axes + n_sensors + n_sites * N_SITE_OUTPUTS
    thrust = seals + n_seals * N_SEAL_OUTPUTS
    return Outputs(
        part(outputs, 0, OUTPUTS, 1),
        part(outputs, N_OUTPUTS, REAL, n_axes),
        part(outputs, N_OUTPUTS + n_axes, REAL, n_sensors),
        part(outputs, N_OUTPUTS + n_axes + n_sensors, SITE_OUTPUTS, n_sites),
        part(outputs, seals, SEAL_OUTPUTS, n_seals),
        part(outputs, thrust, AXIAL_OUTPUTS, structure.n_thrust),
        part(outputs, thrust + structure.n_thrust * N_AXIAL_OUTPUTS, FACE_OUTPUTS, structure.n_faces),
    )
