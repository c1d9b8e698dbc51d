"""Layout of the plant's flat state and scratch arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.flat import copy, same_bits
from fmi_export.jit import kernel, noinline_kernel, views
from fmi_export.linear_state import LinearState
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rotor_contact.contact.bodies import SPIN, place_bodies
from rotor_contact.contact.constraints import MAX_UNKNOWNS
from rotor_contact.contact.faces import (
    FACE_COLLECTED_FROM,
    FACE_COLLECTED_TO,
    FACE_STATE,
    N_FACE,
    N_FACE_INTEGRALS,
    N_FACE_STATE,
    faces_of,
    faces_size,
    place_faces,
)
from rotor_contact.contact.site import COLLECTED_FROM, COLLECTED_TO, SITE, Sites
from rotor_contact.contact.site_totals import SITE_STATE, begin_step, end_step
from rotor_contact.contact.workspace import (
    N_INTEGRALS,
    N_SITE_INTEGRALS,
    N_STAGES,
    Workspace,
    energy_integrals,
    face_integrals,
    site_integrals,
)
from rotor_contact.forces.axial_motion import AXIAL
from rotor_contact.forces.dynamics import N_ROWS, Motion
from rotor_contact.forces.passive_bearings import BEARING, N_BEARING, Bearings
from rotor_contact.matrices.matrix_sizes import matrices_key_size, places_of_matrices
from rotor_contact.matrices.step_matrices import MatricesKey, StepMatrices, matrices_key_of, step_matrices_of
from rotor_contact.shaft.linear_solver import Equations, equations_of
from rotor_contact.shaft.structure import REAL, Structure, structure_of
from rotor_contact.variables.signals import N_INPUTS, Inputs, Parameters, first_disc_input, n_inputs, n_parameters
from rotor_contact.whole_steps.constant_speed import ConstantSpeed, constant_speed_of, constant_speed_size

# The state begins with this record, all float64, and goes on with the arrays of `State`.
HEAD = record(
    ("theta", np.float64),  # rotor angle (rad)
    ("initial_energy", np.float64),  # kinetic and strain energy at the start (J)
    ("n_halvings", np.float64),  # how often `substeps.advance` halves its substeps
    ("tolerance_missed", np.float64),  # whether a substep of the last step was less accurate than requested
    ("coupling", np.float64),  # energy that shaft and free spin share by unbalance (J)
    ("largest_energy", np.float64),  # of mechanical energy, heat and work so far (J)
    ("level", np.float64),  # of the matrices, for the next piece
    ("n_matrix_steps", np.float64),  # for how many steps the key of the matrices has not changed
    ("place", np.float64),  # of the speed on the grid of the matrices
    ("has_matrices", np.float64),  # whether they have computed a step of this run
    ("method", np.float64),  # how the last step was computed, see `METHOD`
    ("is_held", np.float64),  # whether an ideal drive holds a free spin, which is then no degree of freedom
    ("speed", np.float64),  # spin speed (rad/s)
)
N_HEAD, N_SITE_STATE = (size_of(HEAD) + 1) // 2 * 2, size_of(SITE_STATE)

N_SITE, N_SPIN = size_of(SITE), size_of(SPIN)

N_AXIAL = size_of(AXIAL)

Records = np.ndarray[tuple[int], np.dtype[np.record]]


class State(NamedTuple):
    """The state as views."""

    head: Records  # of type `HEAD`, in an array of length 1
    matrices_key: MatricesKey  # of the last step
    constant: ConstantSpeed
    sites: Records  # of type `SITE_STATE`
    axial: Records  # one of type `AXIAL` if the rotor has a thrust disc, else none
    faces: Records  # of type `FACE_STATE`
    z: Array  # (q, v, integrals), with room for all possible bodies; with fewer, only the first part is used


class StepCache(NamedTuple):
    """Parameters and inputs of the last step, on which its records of sites and bodies and its forces depend.

    The forces are those without the magnets'. If any number differs in a single bit, all is computed again.
    """

    n: Array  # total number of degrees of freedom, in an array of length 2
    parameters: Array
    inputs: Array


class Scratch(NamedTuple):
    """The scratch array as views; `spin`, `sites`, `equations` and `faces` are those of `Workspace`."""

    spin: Records
    matrices: StepMatrices  # kept from step to step; `is_for` and `is_complete` check whether they are still valid
    stages: Array  # memory of `Workspace.stages`
    sites: Sites
    equations: Equations
    motion: Array  # memory of `Motion.rows`
    bearings: Bearings  # memory of `Motion.bearings`
    site_rows: Array  # the sites' records as numbers, shape (n_sites, N_SITE)
    orbit: Equations  # of the steady orbit, shape (2 n, 2 n + 1)
    step_cache: StepCache
    faces: Array


@views
def most_degrees_of_freedom(structure: Structure) -> int:
    """Return the number of degrees of freedom if every site has a housing and a race, and the spin is free."""
    return structure.K.shape[0] + 3 * structure.sites.shape[0] + 1


@views
def stage_size(n: int, n_sites: int, n_faces: int) -> int:
    """Return the size of a row of `Workspace.stages`, an even number."""
    size = 2 * n + N_INTEGRALS + N_SITE_INTEGRALS * n_sites + N_FACE_INTEGRALS * n_faces
    return size + size % 2


@views
def places_in_state(structure: Structure) -> tuple[int, int, int, int, int]:
    """Return the positions in the state of constant speed, sites, axial motion, faces and z, which follow the key."""
    n_bearings, n_sites = structure.bearings.shape[0], structure.sites.shape[0]
    constant = N_HEAD + matrices_key_size(n_bearings, n_sites)
    sites = constant + constant_speed_size(n_bearings)
    axial = sites + n_sites * N_SITE_STATE
    faces = axial + structure.n_thrust * N_AXIAL
    return constant, sites, axial, faces, faces + structure.n_faces * N_FACE_STATE


@views
def places_in_work(structure: Structure) -> tuple[int, ...]:
    """Return the positions in the scratch array of its parts after the spin.

    Parts that are read frequently come first. Their offsets are even, because kernels process vectors of two numbers.
    """
    n, n_sites, n_unknowns = structure.K.shape[0], structure.sites.shape[0], MAX_UNKNOWNS * structure.sites.shape[0]
    motion = N_SPIN + N_STAGES * stage_size(most_degrees_of_freedom(structure), n_sites, structure.n_faces)
    sites = motion + (2 * n + N_ROWS) * n
    equations = sites + n_sites * N_SITE
    orbit = equations + n_unknowns * (n_unknowns + 1)
    bearings = orbit + 2 * n * (2 * n + 1)
    step_cache = bearings + structure.bearings.shape[0] * N_BEARING
    faces = step_cache + 2 + (n_parameters(structure) + n_inputs(structure) + 1) // 2 * 2
    return motion, sites, equations, orbit, bearings, step_cache, faces, faces + faces_size(structure.n_faces, n)


def n_state(constants: Array) -> int:
    """Return the size of the state for the rotor with these constants."""
    structure = structure_of(constants)
    return places_in_state(structure)[-1] + 2 * most_degrees_of_freedom(structure) + N_INTEGRALS


def n_work(constants: Array) -> int:
    """Return the size of the scratch array for the rotor with these constants."""
    structure = structure_of(constants)
    return places_in_work(structure)[-1] + places_of_matrices(structure)[-1]


def linear_state(constants: Array) -> LinearState:
    """Return the positions of the linear motion, the angle and the energies in the state (see `LinearState`).

    This part of the state moves linearly while the rotor touches nothing.
    """
    structure, names = structure_of(constants), HEAD.names or ()
    _, _, axial, _, z = places_in_state(structure)
    energy = names.index("initial_energy"), names.index("largest_energy")
    unless = "spin.free", "*.housing_mass", "*.race_inertia", "*.mode"
    along = ((axial, z),) if structure.n_thrust else ()
    return LinearState((*along, (z, z + 2 * len(structure.K))), names.index("theta"), energy, unless)


@views
def state_of(state: Array, structure: Structure) -> State:
    """Return views into the state of a rotor with this structure."""
    n_bearings, n_sites = structure.bearings.shape[0], structure.sites.shape[0]
    constant, sites, axial, faces, z = places_in_state(structure)
    return State(
        part(state, 0, HEAD, 1),
        matrices_key_of(state, N_HEAD, n_bearings, n_sites),
        constant_speed_of(state, constant, n_bearings),
        part(state, sites, SITE_STATE, n_sites),
        part(state, axial, AXIAL, structure.n_thrust),
        part(state, faces, FACE_STATE, structure.n_faces),
        part(state, z, REAL, 2 * most_degrees_of_freedom(structure) + N_INTEGRALS),
    )


@views
def scratch_of(work: Array, structure: Structure) -> Scratch:
    """Return views into the scratch array of a rotor with this structure."""
    n, n_bearings, n_sites = structure.K.shape[0], structure.bearings.shape[0], structure.sites.shape[0]
    motion, sites, equations, orbit, bearings, step_cache, faces, matrices = places_in_work(structure)
    n_given = n_parameters(structure)
    return Scratch(
        part(work, 0, SPIN, 1),
        step_matrices_of(work, matrices, structure),
        part(work, N_SPIN, REAL, motion - N_SPIN),
        part(work, sites, SITE, n_sites),
        equations_of(work, equations, MAX_UNKNOWNS * n_sites),
        part(work, motion, REAL, (2 * n + N_ROWS, n)),
        part(work, bearings, BEARING, n_bearings),
        part(work, sites, REAL, (n_sites, N_SITE)),
        equations_of(work, orbit, 2 * n),
        StepCache(
            part(work, step_cache, REAL, 2),
            part(work, step_cache + 2, REAL, n_given),
            part(work, step_cache + 2 + n_given, REAL, n_inputs(structure)),
        ),
        part(work, faces, REAL, matrices - faces),
    )


@views
def workspace_of(structure: Structure, motion: Motion, scratch: Scratch, n: int) -> Workspace:
    """Return the workspace of a step; n is the total number of degrees of freedom."""
    size = stage_size(n, structure.sites.shape[0], structure.n_faces)
    return Workspace(
        n,
        structure.forms,
        structure.Minv,
        motion,
        scratch.spin,
        scratch.sites,
        scratch.equations,
        part(scratch.stages, 0, REAL, (N_STAGES, size)),
        structure.n_translations,
        scratch.faces,
    )


@kernel
def is_cached(cache: StepCache, structure: Structure, parameters: Array, inputs: Array) -> bool:
    """Return whether everything except the magnets' forces is unchanged since the last call of `store_in_cache`."""
    discs = first_disc_input(structure)
    return (
        same_bits(parameters, cache.parameters)
        and same_bits(inputs[:N_INPUTS], cache.inputs[:N_INPUTS])
        and same_bits(inputs[discs:], cache.inputs[discs:])
    )


@kernel
def store_in_cache(cache: StepCache, parameters: Array, inputs: Array, n: int) -> None:
    """Store the parameters, the inputs and the resulting total number of degrees of freedom."""
    copy(parameters, cache.parameters)
    copy(inputs, cache.inputs)
    cache.n[0] = n


@noinline_kernel
def place_sites(structure: Structure, parameters: Parameters, inputs: Inputs, scratch: Scratch) -> int:
    """Fill the records of the sites, the faces and the spin; return the total number of degrees of freedom.

    Fields of a site that are not parameters are set to zero.
    """
    for k in range(structure.sites.shape[0]):
        copy(parameters.sites[k], scratch.site_rows[k])
        scratch.site_rows[k, parameters.sites.shape[1] :] = 0.0
        scratch.sites[k].row = int(structure.sites[k])
    if structure.n_faces > 0:
        place_faces(structure, parameters.faces, scratch.faces)
    return place_bodies(parameters, inputs, scratch.sites, scratch.spin[0], structure.K.shape[0])


@noinline_kernel
def release_spin(head: np.record, z: Array, n: int) -> None:
    """Make a held spin the last of n degrees of freedom in z, with its angle and speed."""
    for i in range(N_INTEGRALS - 1, -1, -1):
        z[2 * n + i] = z[2 * n - 2 + i]
    for i in range(n - 2, -1, -1):
        z[n + i] = z[n - 1 + i]
    z[n - 1], z[2 * n - 1] = head.theta, head.speed


@noinline_kernel
def hold_spin(z: Array, n: int) -> None:
    """Remove the spin, which is the last degree of freedom, from z; n other degrees of freedom remain."""
    for i in range(n):
        z[n + i] = z[n + 1 + i]
    for i in range(N_INTEGRALS):
        z[2 * n + i] = z[2 * n + 2 + i]


@kernel
def load_sites(states: Records, scratch: Scratch) -> None:
    """Set the modes of the sites from their states, and reset everything that is collected over a step."""
    for k in range(states.shape[0]):
        scratch.site_rows[k, COLLECTED_FROM:COLLECTED_TO] = 0.0
        begin_step(scratch.sites[k], states[k])


@kernel
def store_sites(sites: Sites, states: Records, z: Array, n: int) -> None:
    """Store the results of a step: modes and heat in the states, and impact energies in the energy integrals of z.

    z is a row of `Workspace.stages`; it contains the site integrals of the step.
    """
    integrals = energy_integrals(z, n)
    for k in range(sites.shape[0]):
        site = sites[k]
        end_step(site, states[k], site_integrals(z, n, k))
        integrals.impact_heat += site.impact_heat
        integrals.work += site.drive_work


@kernel
def load_faces(states: Records, w: Workspace) -> None:
    """Set whether each face is pressed, as stored in its state, and reset everything that is collected over a step."""
    records = faces_of(w.faces, w.Minv.shape[0]).records
    numbers = part(w.faces, 0, REAL, (records.shape[0], N_FACE))
    for k in range(records.shape[0]):
        numbers[k, FACE_COLLECTED_FROM:FACE_COLLECTED_TO] = 0.0
        records[k].is_pressed = states[k].is_pressed


@kernel
def store_faces(w: Workspace, states: Records, z: Array) -> None:
    """Store in the state of each face whether it is pressed, and its heat; for z see `store_sites`."""
    records = faces_of(w.faces, w.Minv.shape[0]).records
    for k in range(records.shape[0]):
        states[k].is_pressed = records[k].is_pressed
        states[k].heat += face_integrals(z, w.n, w.sites.shape[0], k).heat
