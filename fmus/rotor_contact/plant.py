"""The plant's step: fourth-order substeps, located events, contact modes, outputs."""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from rotor_contact.constants import N_RIG, structure_of
from rotor_contact.contact import Sites, locate, slip_velocity, tangential
from rotor_contact.dynamics import prepare, quadratic_form
from rotor_contact.events import FAULT_SINGULAR, FAULT_TOO_MANY_EVENTS, Run, advance
from rotor_contact.interface import (
    BEARING,
    BEARING_PARAMETERS,
    CLEARANCE,
    CONTACT_STATE,
    DISPLACEMENT,
    DISSIPATED,
    FREE,
    GAP,
    IMPACT_LAW,
    IMPULSE,
    INTERFACE,
    JOURNAL_RADIUS,
    KINETIC,
    MAX_SUBSTEP,
    MODE,
    MU,
    N_BEARINGS,
    N_SENSORS,
    N_SITES,
    NORMAL,
    OFFSET_X,
    OFFSET_Y,
    OMEGA,
    RESTITUTION,
    SENSOR,
    SITE,
    SITE_OUTPUT,
    SITE_OUTPUTS,
    SITE_PARAMETERS,
    SITES,
    SLIP,
    STIFFNESS,
    STRAIN,
    TANGENTIAL,
    THETA,
    WHIRL,
)

FAULT_OFFSET = 11  # plus the site
SITE_WORK = 12 * N_SITES + 4 * N_SITES * N_SITES  # scratch of the sites


@kernel
def sites_of(parameters: Array, state: Array, work: Array) -> Sites:
    """Views of the contact sites.

    The state begins with q, v, heat, theta and ends with the energy lost in impacts, the modes and the signs of slip of
    the sites; a rotor of fewer degrees of freedom than `N_RIG` leaves a gap between.
    """
    n = N_SITES
    end = SITE + n * SITE_PARAMETERS
    last = state.shape[0]
    start = 10 * n
    return Sites(
        clearance=parameters[SITE + CLEARANCE : end : SITE_PARAMETERS],
        mu=parameters[SITE + MU : end : SITE_PARAMETERS],
        restitution=parameters[SITE + RESTITUTION : end : SITE_PARAMETERS],
        journal_radius=parameters[SITE + JOURNAL_RADIUS : end : SITE_PARAMETERS],
        offset_x=parameters[SITE + OFFSET_X : end : SITE_PARAMETERS],
        offset_y=parameters[SITE + OFFSET_Y : end : SITE_PARAMETERS],
        mode=state[last - 2 * n : last - n],
        sign=state[last - n : last],
        normal=work[:n],
        tangential=work[n : 2 * n],
        impulse=work[2 * n : 3 * n],
        normals=work[3 * n : 5 * n],
        P_n=work[5 * n : 6 * n],
        P_t=work[6 * n : 7 * n],
        mark=work[7 * n : 8 * n],
        mode_before=work[8 * n : 9 * n],
        rebound=work[9 * n : 10 * n],
        A=work[start : start + 4 * n * n].reshape(2 * n, 2 * n),
        b=work[start + 4 * n * n : start + 4 * n * n + 2 * n],
        loss=state[last - 2 * n - 1 : last - 2 * n],
    )


@kernel
def run_of(n: int, state: Array, work: Array) -> Run:
    """Views of the integration arrays: z is the head of the state, the rest scratch after that of the sites."""
    size = 2 * n + 1
    start = SITE_WORK
    return Run(
        z=state[:size],
        z_new=work[start : start + size],
        z_stage=work[start + size : start + 2 * size],
        k1=work[start + 2 * size : start + 3 * size],
        k2=work[start + 3 * size : start + 4 * size],
        k3=work[start + 4 * size : start + 5 * size],
        k4=work[start + 5 * size : start + 6 * size],
        k_new=work[start + 6 * size : start + 7 * size],
        before=work[start + 7 * size : start + 7 * size + n],
    )


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Rotor at rest in the centre at angle zero, all sites free."""
    sites = sites_of(parameters, state, work)
    for k in range(N_SITES):
        if math.hypot(sites.offset_x[k], sites.offset_y[k]) >= sites.clearance[k]:
            return FAULT_OFFSET + k
    work[:] = 0.0
    write_outputs(constants, parameters, inputs, state, work, outputs)
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
    sites = sites_of(parameters, state, work)
    run = run_of(n, state, work)
    start = SITE_WORK + 8 * (2 * n + 1)
    motion = prepare(
        s,
        parameters,
        inputs,
        state[2 * n + 1],
        work[start : start + n * n].reshape(n, n),
        work[start + n * n : start + 2 * n * n].reshape(n, n),
        work[start + 2 * n * n : start + 2 * n * n + n],
        work[start + 2 * n * n + n : start + 2 * n * n + 2 * n],
        work[start + 2 * n * n + 2 * n : start + 2 * n * n + 3 * n],
    )
    sites.impulse[:] = 0.0
    fault = advance(s, motion, sites, parameters, run, int(parameters[IMPACT_LAW]), step_size, parameters[MAX_SUBSTEP])
    if fault != 0:
        return fault
    state[2 * n + 1] = (state[2 * n + 1] + inputs[OMEGA] * step_size) % (2.0 * math.pi)
    write_outputs(constants, parameters, inputs, state, work, outputs)
    return 0


@kernel
def write_outputs(
    constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array
) -> None:
    """Everything the table lists, from the state and the last contact forces."""
    s = structure_of(constants)
    n = s.M.shape[0]
    sites = sites_of(parameters, state, work)
    q = state[:n]
    v = state[n : 2 * n]
    outputs[THETA] = state[2 * n + 1]
    for k in range(N_BEARINGS):
        row = int(s.rows[k])
        outputs[DISPLACEMENT + 2 * k] = q[row]
        outputs[DISPLACEMENT + 2 * k + 1] = q[row + 1]
    for i in range(N_SENSORS):
        total = 0.0
        for j in range(n):
            total += s.sensors[i, j] * q[j]
        outputs[SENSOR + i] = total
    contact_state = 0.0
    for k in range(N_SITES):
        y = outputs[SITE_OUTPUT + k * SITE_OUTPUTS : SITE_OUTPUT + (k + 1) * SITE_OUTPUTS]
        r = locate(s, sites, k, q)
        closed = sites.mode[k] != FREE
        y[GAP] = 0.0 if closed else sites.clearance[k] - r
        y[MODE] = sites.mode[k]
        y[NORMAL] = sites.normal[k] if closed else 0.0
        y[TANGENTIAL] = sites.tangential[k] if closed else 0.0
        y[IMPULSE] = sites.impulse[k]
        y[SLIP] = slip_velocity(s, sites, k, v, inputs[OMEGA])
        y[WHIRL] = tangential(s, sites, k, v) / r if r > 0.0 else 0.0
        if closed:
            contact_state += 2.0**k
    outputs[CONTACT_STATE] = contact_state
    strain = quadratic_form(s.K, q)
    for k in range(N_BEARINGS):
        row = int(s.rows[k])
        k_b = parameters[BEARING + k * BEARING_PARAMETERS + STIFFNESS]
        strain += k_b * (q[row] * q[row] + q[row + 1] * q[row + 1])
    outputs[KINETIC] = 0.5 * quadratic_form(s.M, v)
    outputs[STRAIN] = 0.5 * strain
    outputs[DISSIPATED] = state[2 * n] + sites.loss[0]


MODEL = Model(
    name="rotor_contact",
    description="Flexible rotor with unbalance that can touch its two retainer bearings",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=2 * N_RIG + 3 + 2 * N_SITES,
    n_work=SITE_WORK + 9 * (2 * N_RIG + 1) + 2 * N_RIG**2 + 3 * N_RIG,
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
