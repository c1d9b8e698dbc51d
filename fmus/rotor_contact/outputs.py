"""The plant's outputs, from its state and the last contact forces."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.arrays import ANGLE, ENERGY_AT_START, HEAD
from rotor_contact.compliant import SLIP_SCALE, stored_energy, yields
from rotor_contact.contact import IMPULSE, MODE, NORMAL, RADIUS, TANGENTIAL, locate, slip_velocity, tangential
from rotor_contact.dynamics import quadratic_form
from rotor_contact.integration import DAMPING_HEAT, FRICTION_HEAT, IMPACT_HEAT, WORK_DONE
from rotor_contact.interface import (
    BALANCE,
    BEARING,
    BEARING_PARAMETERS,
    CLEARANCE,
    CONTACT_STATE,
    DISPLACEMENT,
    DISSIPATED,
    FREE,
    HEAT,
    KINETIC,
    MU,
    N_BEARINGS,
    N_SENSORS,
    N_SITES,
    RETAINERS,
    ROLLING,
    SENSOR,
    SITE_OUTPUT,
    SITE_OUTPUTS,
    STIFFNESS,
    STRAIN,
    THETA,
    WORK,
    Y_GAP,
    Y_IMPULSE,
    Y_MODE,
    Y_NORMAL,
    Y_SLIP,
    Y_TANGENTIAL,
    Y_WHIRL,
)
from rotor_contact.structure import Structure

N_RETAINERS = len(RETAINERS)


@kernel
def write_outputs(s: Structure, parameters: Array, state: Array, sites: Array, Omega: float, outputs: Array) -> None:
    """Everything the table lists; `Omega` (rad/s) is the spin speed that holds now."""
    n = s.M.shape[0]
    q = state[HEAD : HEAD + n]
    v = state[HEAD + n : HEAD + 2 * n]
    outputs[THETA] = state[ANGLE]
    for k in range(N_BEARINGS):
        row = int(s.bearings[k])
        outputs[DISPLACEMENT + 2 * k] = q[row]
        outputs[DISPLACEMENT + 2 * k + 1] = q[row + 1]
    for i in range(N_SENSORS):
        outputs[SENSOR + i] = 0.0
    for j in range(n):
        for i in range(N_SENSORS):
            outputs[SENSOR + i] += s.sensors[i, j] * q[j]
    contact_state = 0.0
    for k in range(N_SITES):
        locate(sites, k, q)
        _write_site(sites, k, v, Omega, outputs[SITE_OUTPUT + k * SITE_OUTPUTS :])
        if k < N_RETAINERS and sites[k, MODE] != FREE:
            contact_state += 2.0**k
    outputs[CONTACT_STATE] = contact_state
    _write_energies(s, state, mechanical_energy(s, parameters, sites, q, v, outputs), outputs)


@kernel
def _write_site(sites: Array, k: int, v: Array, Omega: float, y: Array) -> None:
    """Outputs of site k (its radius and normal must be up to date) into `y`."""
    closed = sites[k, MODE] != FREE
    slip = slip_velocity(sites, k, v, Omega)
    y[Y_GAP] = sites[k, CLEARANCE] - sites[k, RADIUS]
    y[Y_MODE] = sites[k, MODE]
    if yields(sites, k):
        if sites[k, MU] > 0.0 and abs(slip) < SLIP_SCALE:
            y[Y_MODE] = ROLLING
    elif closed:
        y[Y_GAP] = 0.0
    y[Y_NORMAL] = sites[k, NORMAL] if closed else 0.0
    y[Y_TANGENTIAL] = sites[k, TANGENTIAL] if closed else 0.0
    y[Y_IMPULSE] = sites[k, IMPULSE]
    y[Y_SLIP] = slip
    y[Y_WHIRL] = tangential(sites, k, v) / sites[k, RADIUS] if sites[k, RADIUS] > 0.0 else 0.0


@kernel
def mechanical_energy(s: Structure, parameters: Array, sites: Array, q: Array, v: Array, outputs: Array) -> float:
    """Kinetic and strain energy (J), both written to the outputs; returns their sum."""
    outputs[KINETIC] = 0.5 * quadratic_form(s.M, v)
    strain = 0.5 * quadratic_form(s.K, q)
    for k in range(N_BEARINGS):
        row = int(s.bearings[k])
        k_b = parameters[BEARING + k * BEARING_PARAMETERS + STIFFNESS]
        strain += 0.5 * k_b * (q[row] * q[row] + q[row + 1] * q[row + 1])
    for k in range(N_SITES):
        if yields(sites, k):
            strain += stored_energy(sites, k, max(locate(sites, k, q) - sites[k, CLEARANCE], 0.0))
    outputs[STRAIN] = strain
    total: float = outputs[KINETIC] + strain
    return total


@kernel
def _write_energies(s: Structure, state: Array, mechanical: float, outputs: Array) -> None:
    tallies = HEAD + 2 * s.M.shape[0]
    outputs[HEAT] = state[tallies + DAMPING_HEAT]
    outputs[HEAT + 1] = state[tallies + FRICTION_HEAT]
    outputs[HEAT + 2] = state[tallies + IMPACT_HEAT]
    outputs[DISSIPATED] = outputs[HEAT] + outputs[HEAT + 1] + outputs[HEAT + 2]
    outputs[WORK] = state[tallies + WORK_DONE]
    outputs[BALANCE] = mechanical - state[ENERGY_AT_START] + outputs[DISSIPATED] - outputs[WORK]
