"""The plant's step: from the flat arrays of an FMU to the integration and back."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from rotor_contact.arrays import (
    ANGLE,
    ENERGY_AT_START,
    HEAD,
    MEMORY,
    PACE,
    load_sites,
    n_state,
    n_work,
    scratch_of,
    store_sites,
)
from rotor_contact.dynamics import collect_coefficients, collect_forces
from rotor_contact.events import FAULT_SINGULAR, FAULT_TOO_MANY_EVENTS, advance, settle
from rotor_contact.flight import fly, is_made, make, steady
from rotor_contact.integration import TALLIES, Z
from rotor_contact.interface import (
    CLEARANCE,
    ENABLED,
    EXACT_FLIGHT,
    IMPACT_LAW,
    INTERFACE,
    MAX_SUBSTEP,
    N_SITES,
    OFFSET_X,
    OFFSET_Y,
    OMEGA,
    OMEGA_DOT,
    ORBIT,
    SITES,
    TOLERANCE,
)
from rotor_contact.outputs import mechanical_energy, write_outputs
from rotor_contact.start import put_back, start_on_orbit
from rotor_contact.structure import structure_of

FAULT_NO_ORBIT, FAULT_LONG_STEP = 3, 4
FAULT_OFFSET = 11  # plus the site

MOST_SUBSTEPS = 1e6  # of one step


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Rotor at angle zero, at rest in the centre or on its orbit; sites are free unless the orbit passes them."""
    s = structure_of(constants)
    n = s.M.shape[0]
    x = scratch_of(work, n)
    load_sites(s, parameters, state, x.sites)
    for k in range(N_SITES):
        off_centre = math.hypot(x.sites[k, OFFSET_X], x.sites[k, OFFSET_Y])
        if x.sites[k, ENABLED] != 0.0 and off_centre >= x.sites[k, CLEARANCE]:
            return FAULT_OFFSET + k
    z = state[HEAD : HEAD + 2 * n + TALLIES]
    if parameters[ORBIT] != 0.0:
        motion = collect_forces(s, parameters, inputs, 0.0, x.coefficients, x.forces, x.bearings)
        collect_coefficients(s, motion)
        if not start_on_orbit(motion, x.orbit, z[:n], z[n : 2 * n]):
            return FAULT_NO_ORBIT
        put_back(x.sites, z[:n], z[n : 2 * n], inputs[OMEGA])
        copy(z, x.runge[Z])
        if not settle(s.Minv, motion, x.sites, x.equations, x.runge, 0.0, 0.0):
            return FAULT_SINGULAR
        copy(x.runge[Z], z)
        store_sites(x.sites, state, z)
    state[ENERGY_AT_START] = mechanical_energy(s, parameters, x.sites, z[:n], z[n : 2 * n], outputs)
    write_outputs(s, parameters, state, x.sites, inputs[OMEGA], outputs)
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
    if step_size > MOST_SUBSTEPS * parameters[MAX_SUBSTEP]:
        return FAULT_LONG_STEP
    s = structure_of(constants)
    n = s.M.shape[0]
    x = scratch_of(work, n)
    z = state[HEAD : HEAD + 2 * n + TALLIES]
    load_sites(s, parameters, state, x.sites)
    copy(z, x.runge[Z])
    motion = collect_forces(s, parameters, inputs, state[ANGLE], x.coefficients, x.forces, x.bearings)
    memory = state[MEMORY:HEAD]
    flown = False
    if steady(motion, step_size, memory) and parameters[EXACT_FLIGHT] != 0.0:
        if not is_made(x.flight, memory):
            collect_coefficients(s, motion)
            make(s.Minv, motion, memory, x.flight)
        flown = fly(motion, x.sites, x.runge, x.flight, step_size)
    if not flown:
        collect_coefficients(s, motion)
        law = int(parameters[IMPACT_LAW])
        fault = advance(
            s.M,
            s.Minv,
            motion,
            x.sites,
            x.equations,
            x.runge,
            law,
            step_size,
            parameters[MAX_SUBSTEP],
            parameters[TOLERANCE],
            state[PACE:MEMORY],
        )
        if fault != 0:
            return fault
    copy(x.runge[Z], z)
    store_sites(x.sites, state, z)
    Omega = inputs[OMEGA] + inputs[OMEGA_DOT] * step_size
    state[ANGLE] = (state[ANGLE] + 0.5 * (inputs[OMEGA] + Omega) * step_size) % (2.0 * math.pi)
    write_outputs(s, parameters, state, x.sites, Omega, outputs)
    return 0


MODEL = Model(
    name="rotor_contact",
    description="Flexible rotor with unbalance that can touch its retainer bearings and end bushes",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=n_state,
    n_work=n_work,
    packages=("rotor_contact", "fmi_export"),
    faults={
        FAULT_TOO_MANY_EVENTS: "too many contact events in one step to follow them; shorten the communication step",
        FAULT_SINGULAR: "the contact equations have no unique solution; lower the coefficients of friction",
        FAULT_NO_ORBIT: "initial.orbit = {initial.orbit} is not allowed; there must be passive bearings with stiffness "
        "that hold the rotor, mb1.k_b = {mb1.k_b} N/m, mb2.k_b = {mb2.k_b} N/m",
        FAULT_LONG_STEP: "the communication step is too long; it must be at most a million times solver.max_substep = "
        "{solver.max_substep} s",
        **{
            FAULT_OFFSET
            + k: f"{site}.offset_x = {{{site}.offset_x}} m, {site}.offset_y = {{{site}.offset_y}} m is not "
            f"allowed; the distance must be < {{{site}.clearance}} m, the clearance, for the rotor to start free"
            for k, site in enumerate(SITES)
        },
    },
)
