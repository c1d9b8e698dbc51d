"""The plant's step: from the flat arrays of an FMU to the integration and back."""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from rotor_contact.constants import N_RIG, Structure, structure_of
from rotor_contact.contact import (
    IMPULSE,
    LOSS,
    MODE,
    NORMAL,
    PLANE,
    RHS,
    SIGN,
    SITE_COLUMNS,
    TANGENTIAL,
    locate,
    slip_velocity,
    tangential,
)
from rotor_contact.dynamics import prepare, quadratic_form
from rotor_contact.events import FAULT_SINGULAR, FAULT_TOO_MANY_EVENTS, advance
from rotor_contact.integration import RUNGE_ROWS, Z
from rotor_contact.interface import (
    BEARING,
    BEARING_PARAMETERS,
    CLEARANCE,
    CONTACT_STATE,
    DISPLACEMENT,
    DISSIPATED,
    FREE,
    IMPACT_LAW,
    INTERFACE,
    KINETIC,
    MAX_SUBSTEP,
    N_BEARINGS,
    N_SENSORS,
    N_SITES,
    OFFSET_X,
    OFFSET_Y,
    OMEGA,
    SENSOR,
    SITE,
    SITE_OUTPUT,
    SITE_OUTPUTS,
    SITE_PARAMETERS,
    SITES,
    STIFFNESS,
    STRAIN,
    THETA,
    Y_GAP,
    Y_IMPULSE,
    Y_MODE,
    Y_NORMAL,
    Y_SLIP,
    Y_TANGENTIAL,
    Y_WHIRL,
)

FAULT_OFFSET = 11  # plus the site

# State: mode, sign of slip and energy lost in impacts of each site, the rotor angle, then z = (q, v, heat).
SITE_STATE = 3
ANGLE = N_SITES * SITE_STATE
HEAD = ANGLE + 1


@kernel
def load_sites(s: Structure, parameters: Array, state: Array, sites: Array) -> None:
    """Fill the table of sites from parameters and state."""
    sites[:, :] = 0.0
    for k in range(N_SITES):
        for i in range(SITE_PARAMETERS):
            sites[k, i] = parameters[SITE + k * SITE_PARAMETERS + i]
        sites[k, PLANE] = s.rows[k]
        sites[k, MODE] = state[k * SITE_STATE]
        sites[k, SIGN] = state[k * SITE_STATE + 1]
        sites[k, LOSS] = state[k * SITE_STATE + 2]


@kernel
def store_sites(sites: Array, state: Array) -> None:
    """Keep in the state what the table of sites must remember."""
    for k in range(N_SITES):
        state[k * SITE_STATE] = sites[k, MODE]
        state[k * SITE_STATE + 1] = sites[k, SIGN]
        state[k * SITE_STATE + 2] = sites[k, LOSS]


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Rotor at rest in the centre at angle zero, all sites free."""
    s = structure_of(constants)
    sites = work[: N_SITES * SITE_COLUMNS].reshape(N_SITES, SITE_COLUMNS)
    load_sites(s, parameters, state, sites)
    for k in range(N_SITES):
        if math.hypot(sites[k, OFFSET_X], sites[k, OFFSET_Y]) >= sites[k, CLEARANCE]:
            return FAULT_OFFSET + k
    write_outputs(s, parameters, inputs, state, sites, outputs)
    return 0


@kernel
def step(
    constants: Array,
    parameters: Array,
    inputs: Array,
    state: Array,
    work: Array,
    outputs: Array,
    time: float,
    step_size: float,
) -> int:
    """Advance the rotor by `step_size` (s) under constant inputs; outputs are those at the end of the step."""
    s = structure_of(constants)
    n = s.M.shape[0]
    end = N_SITES * SITE_COLUMNS
    sites = work[:end].reshape(N_SITES, SITE_COLUMNS)
    start, end = end, end + RHS * (RHS + 1)
    equations = work[start:end].reshape(RHS, RHS + 1)
    start, end = end, end + RUNGE_ROWS * (2 * n + 1)
    r = work[start:end].reshape(RUNGE_ROWS, 2 * n + 1)
    start, end = end, end + (2 * n + 3) * n
    coefficients = work[start:end].reshape(2 * n + 3, n)
    start, end = end, end + 2 * N_BEARINGS
    bearings = work[start:end].reshape(N_BEARINGS, 2)

    z = state[HEAD : HEAD + 2 * n + 1]
    load_sites(s, parameters, state, sites)
    r[Z] = z
    motion = prepare(s, parameters, inputs, state[ANGLE], coefficients, bearings)
    law = int(parameters[IMPACT_LAW])
    fault = advance(s.M, s.Minv, motion, sites, equations, r, law, step_size, parameters[MAX_SUBSTEP])
    if fault != 0:
        return fault
    z[:] = r[Z]
    store_sites(sites, state)
    state[ANGLE] = (state[ANGLE] + inputs[OMEGA] * step_size) % (2.0 * math.pi)
    write_outputs(s, parameters, inputs, state, sites, outputs)
    return 0


@kernel
def write_outputs(s: Structure, parameters: Array, inputs: Array, state: Array, sites: Array, outputs: Array) -> None:
    """Everything the table lists, from the state and the last contact forces."""
    n = s.M.shape[0]
    q = state[HEAD : HEAD + n]
    v = state[HEAD + n : HEAD + 2 * n]
    outputs[THETA] = state[ANGLE]
    outputs[KINETIC] = 0.5 * quadratic_form(s.M, v)
    strain = quadratic_form(s.K, q)
    for k in range(N_BEARINGS):
        row = int(s.rows[k])
        outputs[DISPLACEMENT + 2 * k] = q[row]
        outputs[DISPLACEMENT + 2 * k + 1] = q[row + 1]
        k_b = parameters[BEARING + k * BEARING_PARAMETERS + STIFFNESS]
        strain += k_b * (q[row] * q[row] + q[row + 1] * q[row + 1])
    outputs[STRAIN] = 0.5 * strain
    for i in range(N_SENSORS):
        total = 0.0
        for j in range(n):
            total += s.sensors[i, j] * q[j]
        outputs[SENSOR + i] = total
    contact_state = 0.0
    dissipated = state[HEAD + 2 * n]
    for k in range(N_SITES):
        at = SITE_OUTPUT + k * SITE_OUTPUTS
        r = locate(sites, k, q)
        closed = sites[k, MODE] != FREE
        outputs[at + Y_GAP] = 0.0 if closed else sites[k, CLEARANCE] - r
        outputs[at + Y_MODE] = sites[k, MODE]
        outputs[at + Y_NORMAL] = sites[k, NORMAL] if closed else 0.0
        outputs[at + Y_TANGENTIAL] = sites[k, TANGENTIAL] if closed else 0.0
        outputs[at + Y_IMPULSE] = sites[k, IMPULSE]
        outputs[at + Y_SLIP] = slip_velocity(sites, k, v, inputs[OMEGA])
        outputs[at + Y_WHIRL] = tangential(sites, k, v) / r if r > 0.0 else 0.0
        dissipated += sites[k, LOSS]
        if closed:
            contact_state += 2.0**k
    outputs[CONTACT_STATE] = contact_state
    outputs[DISSIPATED] = dissipated


MODEL = Model(
    name="rotor_contact",
    description="Flexible rotor with unbalance that can touch its two retainer bearings",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=HEAD + 2 * N_RIG + 1,
    n_work=N_SITES * SITE_COLUMNS
    + RHS * (RHS + 1)
    + RUNGE_ROWS * (2 * N_RIG + 1)
    + (2 * N_RIG + 3) * N_RIG
    + 2 * N_BEARINGS,
    packages=("rotor_contact", "fmi_export"),
    faults={
        FAULT_TOO_MANY_EVENTS: "more than 500 contact events in one step; shorten the communication step",
        FAULT_SINGULAR: "the contact equations have no unique solution; lower the coefficients of friction",
        **{
            FAULT_OFFSET
            + k: f"{site}.offset_x = {{{site}.offset_x}} m, {site}.offset_y = {{{site}.offset_y}} m is not "
            f"allowed; the distance must be < {{{site}.clearance}} m, the clearance, for the rotor to start free"
            for k, site in enumerate(SITES)
        },
    },
)
