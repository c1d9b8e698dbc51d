"""How the flat state and scratch arrays of the plant are laid out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.records import record, size_of
from rotor_contact.contact import N_UNKNOWNS
from rotor_contact.dynamics import BEARING, Excitation, Motion, MotionArrays
from rotor_contact.interface import INTERFACE, N_BEARINGS, N_SITES, SITES
from rotor_contact.linear_solver import Equations, equations_of
from rotor_contact.propagator import HISTORY, Propagator, propagator_of, propagator_size
from rotor_contact.site import SITE, SITE_PARAMETERS, Sites
from rotor_contact.structure import Structure
from rotor_contact.workspace import N_INTEGRALS, N_STAGES, Stages, Workspace, energy_integrals

# The state begins with this record, all float64, and goes on with z (see `workspace`).
HEAD = record(
    ("sites", record(("mode", np.float64), ("slip_sign", np.float64)), (N_SITES,)),
    ("theta", np.float64),  # rotor angle (rad)
    ("initial_energy", np.float64),  # kinetic and strain energy at the start (J)
    ("n_halvings", np.float64),  # how often `events.advance` halves its substeps
    ("history", HISTORY),  # of `propagator.is_time_invariant`
)
N_HEAD = size_of(HEAD)

N_SITE = size_of(SITE)
N_SITE_PARAMETERS = size_of(SITE_PARAMETERS)
FIRST_SITE = INTERFACE.parameter_index(f"{SITES[0]}.enabled")  # where the sites' parameters begin
N_BEARING = size_of(BEARING)


class State(NamedTuple):
    """The state: a record of type `HEAD`, in an array of one, and z = (q, v, energy integrals)."""

    head: np.ndarray[tuple[int], np.dtype[np.record]]
    z: Array


class Scratch(NamedTuple):
    """The scratch array by its uses.

    site_rows
        The sites' records as numbers, shape (N_SITES, N_SITE).
    sites, equations, stages
        As in `Workspace`.
    motion
        Arrays of the motion.
    orbit
        Equations of the steady orbit, shape (2 n, 2 n + 1).
    propagator
        Kept from step to step as a cache; `propagator.is_built` revalidates it.
    """

    site_rows: Array
    sites: Sites
    equations: Equations
    stages: Stages
    motion: MotionArrays
    orbit: Equations
    propagator: Propagator


def n_state(constants: Array) -> int:
    """Return the size of the state for the rotor with these constants."""
    return N_HEAD + 2 * int(constants[0]) + N_INTEGRALS


def n_work(constants: Array) -> int:
    """Return the size of the scratch array for the rotor with these constants."""
    n = int(constants[0])
    return (
        N_SITES * N_SITE
        + N_UNKNOWNS * (N_UNKNOWNS + 1)
        + N_STAGES * (2 * n + N_INTEGRALS)
        + (2 * n + 6) * n
        + N_BEARINGS * N_BEARING
        + 2 * n * (2 * n + 1)
        + propagator_size(n)
    )


@views
def state_of(state: Array, n: int) -> State:
    """Return views into the state of a rotor with n degrees of freedom."""
    return State(state[:N_HEAD].view(HEAD), state[N_HEAD : N_HEAD + 2 * n + N_INTEGRALS])


@views
def scratch_of(work: Array, n: int) -> Scratch:
    """Return views into the scratch array of a rotor with n degrees of freedom."""
    size, rest = N_SITES * N_SITE, work
    site_rows, sites, rest = rest[:size].reshape(N_SITES, N_SITE), rest[:size].view(SITE), rest[size:]
    equations, rest = equations_of(rest, N_UNKNOWNS), rest[N_UNKNOWNS * (N_UNKNOWNS + 1) :]
    size = N_STAGES * (2 * n + N_INTEGRALS)
    r, rest = rest[:size].reshape(N_STAGES, 2 * n + N_INTEGRALS), rest[size:]
    stages = Stages(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8])
    K_columns, rest = rest[: n * n].reshape(n, n), rest[n * n :]
    C_columns, rest = rest[: n * n].reshape(n, n), rest[n * n :]
    r, rest = rest[: 6 * n].reshape(6, n), rest[6 * n :]
    accelerations, forces = Excitation(r[0], r[1], r[2]), Excitation(r[3], r[4], r[5])
    bearings, rest = rest[: N_BEARINGS * N_BEARING].view(BEARING), rest[N_BEARINGS * N_BEARING :]
    motion = MotionArrays(K_columns, C_columns, accelerations, forces, bearings)
    orbit, rest = equations_of(rest, 2 * n), rest[2 * n * (2 * n + 1) :]
    return Scratch(site_rows, sites, equations, stages, motion, orbit, propagator_of(rest, n))


@views
def workspace_of(structure: Structure, motion: Motion, scratch: Scratch) -> Workspace:
    """Return what the kernels of one step pass on together."""
    return Workspace(structure.M, structure.Minv, motion, scratch.sites, scratch.equations, scratch.stages)


@kernel
def load_sites(structure: Structure, parameters: Array, head: np.record, scratch: Scratch) -> None:
    """Fill the sites' records from the parameter array and the state; what is no part of these becomes zero."""
    scratch.site_rows[:, :] = 0.0
    for k in range(N_SITES):
        first = FIRST_SITE + k * N_SITE_PARAMETERS
        copy(parameters[first : first + N_SITE_PARAMETERS], scratch.site_rows[k])
        site = scratch.sites[k]
        site.row = int(structure.sites[k])
        site.mode = int(head.sites[k].mode)
        site.slip_sign = head.sites[k].slip_sign


@kernel
def store_sites(sites: Sites, head: np.record, z: Array, n: int) -> None:
    """Store what a step must leave: modes in the state, energies of impacts in the energy integrals of z."""
    integrals = energy_integrals(z, n)
    for k in range(N_SITES):
        site = sites[k]
        head.sites[k].mode = site.mode
        head.sites[k].slip_sign = site.slip_sign
        integrals.impact_heat += site.impact_heat
        integrals.work += site.drive_work
