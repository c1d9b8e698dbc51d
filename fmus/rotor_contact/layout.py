"""How the flat state and scratch arrays of the plant are laid out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.records import record, size_of
from rotor_contact.bodies import SPIN
from rotor_contact.contact import MAX_UNKNOWNS
from rotor_contact.dynamics import BEARING, N_ROWS, Bearings, Motion
from rotor_contact.linear_solver import Equations, equations_of
from rotor_contact.propagator import Key, Propagator, key_of, key_size, propagator_of, propagator_size
from rotor_contact.signals import Parameters
from rotor_contact.site import SITE, Sites
from rotor_contact.structure import Structure, structure_of
from rotor_contact.workspace import N_INTEGRALS, N_STAGES, Workspace, energy_integrals

# The state begins with this record, all float64, and goes on with the arrays of `State`.
HEAD = record(
    ("theta", np.float64),  # rotor angle (rad)
    ("initial_energy", np.float64),  # kinetic and strain energy at the start (J)
    ("n_halvings", np.float64),  # how often `events.advance` halves its substeps
    ("n_steps", np.float64),  # for how many steps the key of the propagator has not changed
    ("tolerance_missed", np.float64),  # whether a substep of the last step was less accurate than asked for
    ("coupling", np.float64),  # energy that shaft and free spin share by unbalance (J)
)
# Mode and direction of slip; temperature (K); heat so far (J).
SITE_STATE = record(("mode", np.float64), ("slip_sign", np.float64), ("temperature", np.float64), ("heat", np.float64))
N_HEAD, N_SITE_STATE = size_of(HEAD), size_of(SITE_STATE)

N_SITE, N_BEARING, N_SPIN = size_of(SITE), size_of(BEARING), size_of(SPIN)

Records = np.ndarray[tuple[int], np.dtype[np.record]]


class State(NamedTuple):
    """The state: record `HEAD`, in an array of one; the latest key; the sites; z = (q, v, energy integrals).

    z has room for all bodies; with those that there are it ends earlier.
    """

    head: Records
    key: Key
    sites: Records
    z: Array


class Scratch(NamedTuple):
    """The scratch array by its uses.

    propagator
        Kept from step to step as a cache; `propagator.is_built` revalidates it.
    spin, sites, equations
        As in `Workspace`.
    stages
        Memory of `Workspace.stages`.
    motion, bearings
        Memory of the motion: `Motion.rows`, `Motion.bearings`.
    site_rows
        The sites' records as numbers, shape (n_sites, N_SITE).
    orbit
        Equations of the steady orbit, shape (2 n, 2 n + 1).
    """

    spin: Records
    propagator: Propagator
    stages: Array
    sites: Sites
    equations: Equations
    motion: Array
    bearings: Bearings
    site_rows: Array
    orbit: Equations


@views
def most_degrees_of_freedom(structure: Structure) -> int:
    """Return the number of degrees of freedom with a housing and a race at every site, and a free spin."""
    return structure.K.shape[0] + 3 * structure.sites.shape[0] + 1


@views
def stage_size(n: int, n_sites: int) -> int:
    """Return the size of a row of `Workspace.stages`; an even one, since records are in it."""
    return 2 * n + N_INTEGRALS + n_sites + n_sites % 2


def n_state(constants: Array) -> int:
    """Return the size of the state for the rotor with these constants."""
    s = structure_of(constants)
    size = 2 * most_degrees_of_freedom(s) + N_INTEGRALS
    return N_HEAD + key_size(len(s.bearings)) + len(s.sites) * N_SITE_STATE + size


def n_work(constants: Array) -> int:
    """Return the size of the scratch array for the rotor with these constants."""
    s = structure_of(constants)
    n, n_bearings, n_sites = len(s.K), len(s.bearings), len(s.sites)
    n_unknowns = MAX_UNKNOWNS * n_sites
    return (
        N_SPIN
        + propagator_size(n, n_bearings, s.is_damped)
        + N_STAGES * stage_size(most_degrees_of_freedom(s), n_sites)
        + (2 * n + N_ROWS) * n
        + n_sites * N_SITE
        + n_unknowns * (n_unknowns + 1)
        + 2 * n * (2 * n + 1)
        + n_bearings * N_BEARING
    )


@views
def state_of(state: Array, structure: Structure) -> State:
    """Return views into the state of a rotor with this structure."""
    n_bearings, n_sites = structure.bearings.shape[0], structure.sites.shape[0]
    head, rest = state[:N_HEAD].view(HEAD), state[N_HEAD:]
    key, rest = key_of(rest, n_bearings), rest[key_size(n_bearings) :]
    sites, rest = rest[: n_sites * N_SITE_STATE].view(SITE_STATE), rest[n_sites * N_SITE_STATE :]
    return State(head, key, sites, rest[: 2 * most_degrees_of_freedom(structure) + N_INTEGRALS])


@views
def scratch_of(work: Array, structure: Structure) -> Scratch:
    """Return views into the scratch array of a rotor with this structure.

    What is read most comes first, at even places: kernels use vectors of two numbers.
    """
    n, n_bearings, n_sites = structure.K.shape[0], structure.bearings.shape[0], structure.sites.shape[0]
    spin, rest = work[:N_SPIN].view(SPIN), work[N_SPIN:]
    propagator = propagator_of(rest, n, n_bearings, structure.is_damped)
    rest = rest[propagator_size(n, n_bearings, structure.is_damped) :]
    size = N_STAGES * stage_size(most_degrees_of_freedom(structure), n_sites)
    stages, rest = rest[:size], rest[size:]
    size = (2 * n + N_ROWS) * n
    motion, rest = rest[:size].reshape(2 * n + N_ROWS, n), rest[size:]
    size = n_sites * N_SITE
    site_rows, sites, rest = rest[:size].reshape(n_sites, N_SITE), rest[:size].view(SITE), rest[size:]
    n_unknowns = MAX_UNKNOWNS * n_sites
    equations, rest = equations_of(rest, n_unknowns), rest[n_unknowns * (n_unknowns + 1) :]
    orbit, rest = equations_of(rest, 2 * n), rest[2 * n * (2 * n + 1) :]
    bearings = rest[: n_bearings * N_BEARING].view(BEARING)
    return Scratch(spin, propagator, stages, sites, equations, motion, bearings, site_rows, orbit)


@views
def workspace_of(structure: Structure, motion: Motion, scratch: Scratch, n: int) -> Workspace:
    """Return what the kernels of one step pass on together; n is the number of all degrees of freedom."""
    size = stage_size(n, structure.sites.shape[0])
    return Workspace(
        n,
        structure.forms,
        structure.Minv,
        motion,
        scratch.spin,
        scratch.sites,
        scratch.equations,
        scratch.stages[: N_STAGES * size].reshape(N_STAGES, size),
        structure.n_translations,
    )


@kernel
def load_sites(structure: Structure, parameters: Parameters, states: Records, scratch: Scratch) -> None:
    """Fill the sites' records from their parameters and states; what is no part of these becomes zero."""
    scratch.site_rows[:, :] = 0.0
    for k in range(structure.sites.shape[0]):
        copy(parameters.sites[k], scratch.site_rows[k])
        site = scratch.sites[k]
        site.row = int(structure.sites[k])
        site.mode = int(states[k].mode)
        site.slip_sign = states[k].slip_sign


@kernel
def store_sites(sites: Sites, states: Records, z: Array, n: int) -> None:
    """Store what a step must leave: modes and heat in the states, energies of impacts in the energy integrals of z.

    z is a row of `Workspace.stages`; the heat of friction in it is that of the step.
    """
    integrals, heat = energy_integrals(z, n), z[2 * n + N_INTEGRALS :]
    for k in range(sites.shape[0]):
        site = sites[k]
        states[k].mode = site.mode
        states[k].slip_sign = site.slip_sign
        heat[k] += site.impact_heat
        states[k].heat += heat[k]
        integrals.impact_heat += site.impact_heat
        integrals.work += site.drive_work
