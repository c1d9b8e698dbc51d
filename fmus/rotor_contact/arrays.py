"""How the flat state and scratch arrays of the plant are laid out."""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import kernel, views
from fmi_export.model import Array
from rotor_contact import flight
from rotor_contact.contact import DRIVE, LOSS, MODE, PLANE, RHS, SIGN, SITE_COLUMNS
from rotor_contact.dynamics import BEARING_COLUMNS
from rotor_contact.flight import Flight, flight_of
from rotor_contact.integration import IMPACT_HEAT, RUNGE_ROWS, TALLIES, WORK_DONE
from rotor_contact.interface import N_BEARINGS, N_SITES, SITE, SITE_PARAMETERS
from rotor_contact.structure import Structure

# State: mode and sign of slip of each site, the rotor angle, the energy at the start, the pace of `events.advance`, the
# memory of `flight.steady`, then z (see `integration`).
SITE_STATE = 2
ANGLE = N_SITES * SITE_STATE
ENERGY_AT_START = ANGLE + 1
PACE = ANGLE + 2
MEMORY = ANGLE + 3
HEAD = MEMORY + flight.N_MEMORY


class Scratch(NamedTuple):
    """The scratch array by its uses: table of sites, contact equations, integration, motion, orbit, flight."""

    sites: Array
    equations: Array
    runge: Array
    coefficients: Array
    forces: Array
    bearings: Array
    orbit: Array
    flight: Flight


def n_state(constants: Array) -> int:
    """Size of the state for the rotor with these constants."""
    return HEAD + 2 * int(constants[0]) + TALLIES


def n_work(constants: Array) -> int:
    """Size of the scratch array for the rotor with these constants."""
    n = int(constants[0])
    return (
        N_SITES * SITE_COLUMNS
        + RHS * (RHS + 1)
        + RUNGE_ROWS * (2 * n + TALLIES)
        + (2 * n + 3) * n
        + 3 * n
        + N_BEARINGS * BEARING_COLUMNS
        + 2 * n * (2 * n + 1)
        + flight.size_of(n)
    )


@views
def scratch_of(work: Array, n: int) -> Scratch:
    """Views into the scratch array of a rotor with n degrees of freedom."""
    end = N_SITES * SITE_COLUMNS
    sites = work[:end].reshape(N_SITES, SITE_COLUMNS)
    start, end = end, end + RHS * (RHS + 1)
    equations = work[start:end].reshape(RHS, RHS + 1)
    start, end = end, end + RUNGE_ROWS * (2 * n + TALLIES)
    runge = work[start:end].reshape(RUNGE_ROWS, 2 * n + TALLIES)
    start, end = end, end + (2 * n + 3) * n
    coefficients = work[start:end].reshape(2 * n + 3, n)
    start, end = end, end + 3 * n
    forces = work[start:end].reshape(3, n)
    start, end = end, end + N_BEARINGS * BEARING_COLUMNS
    bearings = work[start:end].reshape(N_BEARINGS, BEARING_COLUMNS)
    start, end = end, end + 2 * n * (2 * n + 1)
    orbit = work[start:end].reshape(2 * n, 2 * n + 1)
    return Scratch(sites, equations, runge, coefficients, forces, bearings, orbit, flight_of(work[end:], n))


@kernel
def load_sites(s: Structure, parameters: Array, state: Array, sites: Array) -> None:
    """Fill the table of sites from parameters and state."""
    sites[:, :] = 0.0
    for k in range(N_SITES):
        for i in range(SITE_PARAMETERS):
            sites[k, i] = parameters[SITE + k * SITE_PARAMETERS + i]
        sites[k, PLANE] = s.sites[k]
        sites[k, MODE] = state[k * SITE_STATE]
        sites[k, SIGN] = state[k * SITE_STATE + 1]


@kernel
def store_sites(sites: Array, state: Array, z: Array) -> None:
    """Keep what the table of sites must remember: modes in the state, energies of impacts in the tallies of z."""
    tallies = z.shape[0] - TALLIES
    for k in range(N_SITES):
        state[k * SITE_STATE] = sites[k, MODE]
        state[k * SITE_STATE + 1] = sites[k, SIGN]
        z[tallies + IMPACT_HEAT] += sites[k, LOSS]
        z[tallies + WORK_DONE] += sites[k, DRIVE]
