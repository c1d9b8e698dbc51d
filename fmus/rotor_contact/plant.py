"""The plant's step: from the flat arrays of an FMU to the integration and back."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from rotor_contact.dynamics import collect_coefficients, collect_forces
from rotor_contact.events import FAULT_SINGULAR, FAULT_TOO_MANY_EVENTS, advance
from rotor_contact.free_flight import propagate
from rotor_contact.interface import INPUTS, INTERFACE, N_SITES, OUTPUTS, PARAMETERS, SITES
from rotor_contact.layout import load_sites, n_state, n_work, scratch_of, state_of, store_sites, workspace_of
from rotor_contact.modes import resolve_modes
from rotor_contact.outputs import write_mechanical_energy, write_outputs
from rotor_contact.propagator import build_propagator, is_built, is_time_invariant
from rotor_contact.start import clamp_to_clearance, start_on_orbit
from rotor_contact.structure import structure_of

FAULT_NO_ORBIT, FAULT_LONG_STEP = 3, 4
FAULT_OFFSET = 11  # plus the site

MAX_SUBSTEPS = 1e6  # of one step


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Set the rotor at angle zero, at rest in the centre or on its orbit; return a fault code.

    Sites are free unless the orbit passes them.
    """
    p, u, y = parameters.view(PARAMETERS)[0], inputs.view(INPUTS)[0], outputs.view(OUTPUTS)[0]
    structure = structure_of(constants)
    n = structure.M.shape[0]
    x, scratch = state_of(state, n), scratch_of(work, n)
    head, z, sites = x.head[0], x.z, scratch.sites
    load_sites(structure, parameters, head, scratch)
    for k in range(N_SITES):
        off_centre = math.hypot(sites[k].offset_x, sites[k].offset_y)
        if sites[k].enabled != 0.0 and off_centre >= sites[k].clearance:
            return FAULT_OFFSET + k
    if p.initial.orbit != 0.0:
        motion = collect_forces(structure, p, u, 0.0, scratch.motion)
        collect_coefficients(structure, motion)
        if not start_on_orbit(motion, scratch.orbit, z[:n], z[n : 2 * n]):
            return FAULT_NO_ORBIT
        clamp_to_clearance(sites, z[:n], z[n : 2 * n], u.Omega)
        copy(z, scratch.stages.z)
        if not resolve_modes(workspace_of(structure, motion, scratch), 0.0, 0.0):
            return FAULT_SINGULAR
        copy(scratch.stages.z, z)
        store_sites(sites, head, z, n)
    head.initial_energy = write_mechanical_energy(structure, p, sites, z, y.energy)
    write_outputs(structure, p, x, sites, u.Omega, y)
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
    """Advance the rotor by `step_size` (s) under constant inputs; return a fault code.

    Outputs are those at the end of the step.
    """
    p, u, y = parameters.view(PARAMETERS)[0], inputs.view(INPUTS)[0], outputs.view(OUTPUTS)[0]
    if step_size > MAX_SUBSTEPS * p.solver.max_substep:
        return FAULT_LONG_STEP
    structure = structure_of(constants)
    n = structure.M.shape[0]
    x, scratch = state_of(state, n), scratch_of(work, n)
    head = x.head[0]
    load_sites(structure, parameters, head, scratch)
    copy(x.z, scratch.stages.z)
    motion = collect_forces(structure, p, u, head.theta, scratch.motion)
    w = workspace_of(structure, motion, scratch)
    in_free_flight = False
    if is_time_invariant(motion, step_size, head.history) and p.solver.exact_flight != 0.0:
        if not is_built(scratch.propagator, head.history.key):
            collect_coefficients(structure, motion)
            build_propagator(structure.Minv, motion, head.history.key, scratch.propagator)
        in_free_flight = propagate(w, scratch.propagator, step_size)
    if not in_free_flight:
        collect_coefficients(structure, motion)
        fault = advance(w, p.solver, int(p.contact.impact_law), step_size, head)
        if fault != 0:
            return fault
    copy(scratch.stages.z, x.z)
    store_sites(scratch.sites, head, x.z, n)
    Omega = u.Omega + u.Omega_dot * step_size
    head.theta = (head.theta + 0.5 * (u.Omega + Omega) * step_size) % (2.0 * math.pi)
    write_outputs(structure, p, x, scratch.sites, Omega, y)
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
