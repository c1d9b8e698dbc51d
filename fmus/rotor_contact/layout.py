"""How the flat state and scratch arrays of the plant are laid out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.flat import copy
from fmi_export.jit import kernel, views
from fmi_export.model import Array
from fmi_export.records import record, size_of
from rotor_contact.contact import MAX_UNKNOWNS
from rotor_contact.dynamics import BEARING, Bearings, Motion
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
)
SITE_STATE = record(("mode", np.float64), ("slip_sign", np.float64))
N_HEAD, N_SITE_STATE = size_of(HEAD), size_of(SITE_STATE)

N_SITE, N_BEARING = size_of(SITE), size_of(BEARING)

Records = np.ndarray[tuple[int], np.dtype[np.record]]


class State(NamedTuple):
    """The state: record `HEAD`, in an array of one; the latest key; the sites; z = (q, v, energy integrals)."""

    head: Records
    key: Key
    sites: Records
    z: Array


class Scratch(NamedTuple):
    """The scratch array by its uses.

    propagator
        Kept from step to step as a cache; `propagator.is_built` revalidates it.
    stages, sites, equations
        As in `Workspace`.
    motion, bearings
        Memory of the motion: `Motion.rows`, `Motion.bearings`.
    site_rows
        The sites' records as numbers, shape (n_sites, N_SITE).
    orbit
        Equations of the steady orbit, shape (2 n, 2 n + 1).
    """

    propagator: Propagator
    stages: Array
    sites: Sites
    equations: Equations
    motion: Array
    bearings: Bearings
    site_rows: Array
    orbit: Equations


def n_state(constants: Array) -> int:
    """Return the size of the state for the rotor with these constants."""
    s = structure_of(constants)
    return N_HEAD + key_size(len(s.bearings)) + len(s.sites) * N_SITE_STATE + 2 * len(s.M) + N_INTEGRALS


def n_work(constants: Array) -> int:
    """Return the size of the scratch array for the rotor with these constants."""
    s = structure_of(constants)
    n, n_bearings, n_sites = len(s.M), len(s.bearings), len(s.sites)
    n_unknowns = MAX_UNKNOWNS * n_sites
    return (
        propagator_size(n, n_bearings)
        + N_STAGES * (2 * n + N_INTEGRALS)
        + (2 * n + 6) * n
        + n_sites * N_SITE
        + n_unknowns * (n_unknowns + 1)
        + 2 * n * (2 * n + 1)
        + n_bearings * N_BEARING
    )


@views
def state_of(state: Array, structure: Structure) -> State:
    """Return views into the state of a rotor with this structure."""
    n, n_bearings, n_sites = structure.M.shape[0], structure.bearings.shape[0], structure.sites.shape[0]
    head, rest = state[:N_HEAD].view(HEAD), state[N_HEAD:]
    key, rest = key_of(rest, n_bearings), rest[key_size(n_bearings) :]
    sites, rest = rest[: n_sites * N_SITE_STATE].view(SITE_STATE), rest[n_sites * N_SITE_STATE :]
    return State(head, key, sites, rest[: 2 * n + N_INTEGRALS])


@views
def scratch_of(work: Array, structure: Structure) -> Scratch:
    """Return views into the scratch array of a rotor with this structure.

    What is read most comes first, at even places: kernels use vectors of two numbers.
    """
    n, n_bearings, n_sites = structure.M.shape[0], structure.bearings.shape[0], structure.sites.shape[0]
    propagator, rest = propagator_of(work, n, n_bearings), work[propagator_size(n, n_bearings) :]
    size = N_STAGES * (2 * n + N_INTEGRALS)
    stages, rest = rest[:size].reshape(N_STAGES, 2 * n + N_INTEGRALS), rest[size:]
    size = (2 * n + 6) * n
    motion, rest = rest[:size].reshape(2 * n + 6, n), rest[size:]
    size = n_sites * N_SITE
    site_rows, sites, rest = rest[:size].reshape(n_sites, N_SITE), rest[:size].view(SITE), rest[size:]
    n_unknowns = MAX_UNKNOWNS * n_sites
    equations, rest = equations_of(rest, n_unknowns), rest[n_unknowns * (n_unknowns + 1) :]
    orbit, rest = equations_of(rest, 2 * n), rest[2 * n * (2 * n + 1) :]
    bearings = rest[: n_bearings * N_BEARING].view(BEARING)
    return Scratch(propagator, stages, sites, equations, motion, bearings, site_rows, orbit)


@views
def workspace_of(structure: Structure, motion: Motion, scratch: Scratch) -> Workspace:
    """Return what the kernels of one step pass on together."""
    return Workspace(
        structure.M,
        structure.Minv,
        motion,
        scratch.sites,
        scratch.equations,
        scratch.stages,
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
    """Store what a step must leave: modes in the states, energies of impacts in the energy integrals of z."""
    integrals = energy_integrals(z, n)
    for k in range(sites.shape[0]):
        site = sites[k]
        states[k].mode = site.mode
        states[k].slip_sign = site.slip_sign
        integrals.impact_heat += site.impact_heat
        integrals.work += site.drive_work
