"""The plant's step: from the FMU's flat arrays to the integration and back."""

from __future__ import annotations

import math

import numpy as np

from fmi_export.flat import copy, is_near
from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from rotor_contact.contact.bodies import (
    SHORTEST_SUBSTEP,
    body_limit,
    couple_spin,
    coupling_energy,
    drive_limit,
    kinetic_energy,
    least_inertia,
)
from rotor_contact.contact.compliant import is_any_compliant
from rotor_contact.contact.constraints import project
from rotor_contact.contact.site import Sites
from rotor_contact.contact.site_totals import advance_temperature, average
from rotor_contact.contact.workspace import (
    N_INTEGRALS,
    Workspace,
    energy_integrals,
    site_integrals,
    stages_of,
    with_motion,
)
from rotor_contact.face_step import advance_on_faces, is_near_faces
from rotor_contact.forces.axial_motion import move_along
from rotor_contact.forces.dynamics import ROUNDING as UNCHANGED
from rotor_contact.forces.dynamics import add_magnetic_forces, collect_coefficients, motion_at, motion_of, set_bearings
from rotor_contact.forces.excitation import collect_amplitudes, collect_forces
from rotor_contact.initial_orbit import clamp_to_clearance, start_on_orbit
from rotor_contact.layout import (
    Scratch,
    hold_spin,
    is_cached,
    linear_state,
    load_faces,
    load_sites,
    n_state,
    n_work,
    place_sites,
    release_spin,
    scratch_of,
    state_of,
    store_faces,
    store_in_cache,
    store_sites,
    workspace_of,
)
from rotor_contact.matrix_step import NO_MATRICES_YET, advance_by_matrices, angle_and_speed_after
from rotor_contact.outputs import energy_error, write_mechanical_energy, write_outputs
from rotor_contact.shaft.products import quadratic_form
from rotor_contact.shaft.structure import Structure, structure_of
from rotor_contact.substeps.contact_modes import FAULT_MODES, FAULT_SINGULAR, resolve_modes
from rotor_contact.substeps.substeps import FAULT_TOO_MANY_EVENTS, FAULT_TOO_STIFF, MAX_SUBSTEPS, advance
from rotor_contact.variables.enumerations import COMPLIANT, EXACT, INTEGRATED, NO_MATRICES, NODAL, PIECES, ROLLING
from rotor_contact.variables.interface import interface_of
from rotor_contact.variables.planes import Planes
from rotor_contact.variables.signals import inputs_of, outputs_of, parameters_of

FAULT_NO_ORBIT, FAULT_LONG_STEP, FAULT_INERTIA, FAULT_NODAL, FAULT_FAST = 3, 4, 5, 6, 7
FAULT_ENERGY = 9
FAULT_OFFSET = 11  # plus the site
MAX_SITES = 99 - FAULT_OFFSET + 1

ROUNDING = 1e-9  # of the speed, by which the end of a speed ramp may differ from the speed after it
STABLE = 2.5  # times the start value of solver.max_substep: Runge-Kutta's method is stable up to 2.8 rad of a mode
TURN = 2.0 * math.pi


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Set the rotor to its initial angle, at rest in the centre or on its orbit; return a fault code.

    Sites are free unless the orbit exceeds their clearance. Housings and races are at rest. The orbit is computed for
    the passive bearings only, because magnetic forces would in turn depend on the orbit.
    """
    structure = structure_of(constants)
    p, u, y = parameters_of(parameters, structure), inputs_of(inputs, structure), outputs_of(outputs, structure)
    x, scratch = state_of(state, structure), scratch_of(work, structure)
    z, sites, spin, head = x.z, scratch.sites, scratch.spin[0], x.head[0]
    n = _prepare(structure, parameters, inputs, scratch)
    load_sites(x.sites, scratch)
    for k in range(sites.shape[0]):
        off_centre = math.hypot(sites[k].offset_x, sites[k].offset_y)
        if sites[k].enabled != 0.0 and off_centre >= sites[k].clearance:
            return FAULT_OFFSET + k
        if sites[k].housing >= 0 and p.scalars[0].contact.impact_law == NODAL:
            return FAULT_NODAL
        x.sites[k].temperature = p.scalars[0].ambient_temperature
    for axial in x.axial:
        axial.z = axial.speed = 0.0
    for face in x.faces:
        face.is_pressed = face.heat = 0.0
    Omega, theta = u.scalars[0].Omega, p.scalars[0].initial.angle
    head.theta = theta if 0.0 <= theta < TURN else theta % TURN
    motion = motion_of(structure, scratch.motion, scratch.bearings, head.theta, Omega, 0.0)
    set_bearings(p, motion)
    collect_coefficients(structure, motion)
    w = workspace_of(structure, motion, scratch, n)
    load_faces(x.faces, w)
    is_free = p.scalars[0].spin.free != 0.0
    head.is_held, head.speed = 1.0 if is_free and spin.row < 0 else 0.0, Omega
    if is_free:
        if spin.inertia <= least_inertia(motion):
            return FAULT_INERTIA
        couple_spin(motion, spin, head.theta)
        if drive_limit(spin) < SHORTEST_SUBSTEP:
            return FAULT_FAST
    if spin.row >= 0:
        z[spin.row], z[n + spin.row] = head.theta, Omega
    head.coupling = coupling_energy(motion, spin, head.theta, z[n : 2 * n])
    if n > structure.K.shape[0] and body_limit(sites, spin) < SHORTEST_SUBSTEP:
        return FAULT_FAST
    if p.scalars[0].initial.orbit != 0.0:
        m = structure.K.shape[0]
        if not start_on_orbit(motion, scratch.orbit, z[:m], z[n : n + m]):
            return FAULT_NO_ORBIT
        clamp_to_clearance(sites, z[:n], z[n : 2 * n], Omega)
        add_magnetic_forces(u, motion)
        collect_coefficients(structure, motion)
        start = stages_of(w.stages).z
        copy(z[: 2 * n + N_INTEGRALS], start)
        start[2 * n + N_INTEGRALS :] = 0.0
        fault = resolve_modes(w, 0.0, 0.0)
        if fault != 0:
            return fault
        copy(start[: 2 * n + N_INTEGRALS], z)
        store_sites(sites, x.sites, start, n)
    head.coupling = coupling_energy(motion, spin, head.theta, z[n : 2 * n])
    head.initial_energy = write_mechanical_energy(structure, p, w, x, y.scalars[0].energy)
    write_outputs(structure, p, w, x, Omega, 0.0, y)
    y.scalars[0].solver.energy_missed = y.scalars[0].drive.at_limit = 0.0
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

    Outputs describe the end of the step.
    """
    structure = structure_of(constants)
    p, u, y = parameters_of(parameters, structure), inputs_of(inputs, structure), outputs_of(outputs, structure)
    settings, solver = p.scalars[0], p.scalars[0].solver
    if step_size > MAX_SUBSTEPS * solver.max_substep:
        return FAULT_LONG_STEP
    x, scratch = state_of(state, structure), scratch_of(work, structure)
    head, spin = x.head[0], scratch.spin[0]
    n = _prepare(structure, parameters, inputs, scratch)
    load_sites(x.sites, scratch)
    Omega, Omega_dot = u.scalars[0].Omega, u.scalars[0].Omega_dot
    is_held = settings.spin.free != 0.0 and spin.row < 0
    if head.is_held != 0.0 and not is_held:
        release_spin(head, x.z, n)
    if head.is_held == 0.0 and is_held:
        hold_spin(x.z, n)
        energy_integrals(x.z, n).work -= head.coupling
        head.coupling = 0.0
    if spin.row >= 0:
        x.z[spin.row] = head.theta
        Omega, Omega_dot = x.z[n + spin.row], 0.0
    motion = motion_of(structure, scratch.motion, scratch.bearings, head.theta, Omega, Omega_dot)
    set_bearings(p, motion)
    add_magnetic_forces(u, motion)
    if spin.row >= 0:
        if spin.inertia <= least_inertia(motion):
            return FAULT_INERTIA
        # a change of the unbalance, or a release, changes the kinetic energy at the same velocities
        energy_integrals(x.z, n).work += coupling_energy(motion, spin, head.theta, x.z[n : 2 * n]) - head.coupling
    w = workspace_of(structure, motion, scratch, n)
    z = stages_of(w.stages).z
    head.tolerance_missed = 0.0
    copy(x.z[: 2 * n + N_INTEGRALS], z)
    z[2 * n + N_INTEGRALS :] = 0.0
    load_faces(x.faces, w)
    touches = structure.n_faces > 0 and is_near_faces(structure, p, u, w, x, step_size)
    if structure.n_thrust > 0 and not touches:
        along = move_along(structure.mass, settings.gravity, p.thrust[0], u.thrust[0], x.axial[0], step_size)
        energy_integrals(z, n).work += along
    if spin.row < 0 and abs(Omega - head.speed) > ROUNDING * abs(Omega):
        energy_integrals(z, n).work += _work_of_jump(w, Omega)
    fault = NO_MATRICES_YET
    is_exact = solver.exact_motion != 0.0
    if is_exact and spin.row < 0 and is_near(motion.Omega, x.constant.speed[0].Omega, UNCHANGED):
        motion = motion_at(motion, head.theta, x.constant.speed[0].Omega)
        w = with_motion(w, motion)
    if touches:
        head.method = _method(solver, scratch.sites)
        fault = advance_on_faces(structure, p, u, w, x, scratch.matrices, step_size)
    elif is_exact:
        fault = advance_by_matrices(structure, w, scratch.matrices, x, settings, step_size)
    if fault == NO_MATRICES_YET:
        head.method = _method(solver, scratch.sites)
        collect_coefficients(structure, motion)
        fault = advance(w, settings, step_size, head)
    if fault != 0:
        return fault
    if head.method == EXACT or head.method == PIECES:
        head.has_matrices = 1.0
    store_sites(scratch.sites, x.sites, z, n)
    store_faces(w, x.faces, z)
    copy(z[: 2 * n + N_INTEGRALS], x.z)
    theta, Omega = angle_and_speed_after(w, x.z, head.theta, motion.Omega, step_size)
    if is_held:
        energy_integrals(x.z, n).work += 0.5 * spin.inertia * (Omega * Omega - head.speed * head.speed)
    head.is_held, head.speed = 1.0 if is_held else 0.0, Omega
    head.coupling = coupling_energy(motion, spin, theta, x.z[n : 2 * n])
    head.theta = theta if 0.0 <= theta < TURN else theta % TURN
    for k in range(scratch.sites.shape[0]):
        site, of_site = scratch.sites[k], site_integrals(z, n, k)
        average(site, of_site, step_size)
        advance_temperature(site, x.sites[k], of_site.heat, settings.ambient_temperature, step_size)
    write_outputs(structure, p, w, x, Omega, step_size, y)
    error = energy_error(y.scalars[0].energy, head)
    y.scalars[0].solver.energy_missed = 1.0 if error > 0.1 * solver.energy_limit else 0.0
    return FAULT_ENERGY if error > solver.energy_limit else 0


@kernel
def _method(solver: np.record, sites: Sites) -> float:
    """Return the reason why a whole step is integrated."""
    if solver.exact_motion == 0.0:
        return float(INTEGRATED)
    if is_any_compliant(sites):
        return float(COMPLIANT)
    return float(NO_MATRICES)


@kernel
def _work_of_jump(w: Workspace, Omega: float) -> float:
    """Return the work (J) of an ideal drive that changes the spin speed at once to `Omega` (rad/s).

    The drive then also accelerates everything that rolls on the rotor. Because there is no slip and hence no heat, the
    work is the gain of kinetic energy.
    """
    rolls = False
    for site in w.sites:
        rolls = rolls or site.mode == ROLLING
    if not rolls:
        return 0.0
    z = stages_of(w.stages).z
    q, v = z[: w.n], z[w.n : 2 * w.n]
    before = 0.5 * quadratic_form(w.forms, v) + kinetic_energy(w.sites, v)
    project(w, q, v, Omega)
    gain: float = 0.5 * quadratic_form(w.forms, v) + kinetic_energy(w.sites, v) - before
    return gain


@kernel
def _prepare(structure: Structure, parameters: Array, inputs: Array, scratch: Scratch) -> int:
    """Compute everything that does not depend on state or magnets; return the total number of degrees of freedom."""
    cache = scratch.step_cache
    if not is_cached(cache, structure, parameters, inputs):
        p, u = parameters_of(parameters, structure), inputs_of(inputs, structure)
        motion = motion_of(structure, scratch.motion, scratch.bearings, 0.0, 0.0, 0.0)
        sizes = scratch.matrices.sizes[0]
        if collect_amplitudes(p, u, scratch.matrices.amplitudes) or sizes.inputs == 0.0:
            sizes.inputs += 1.0
            collect_forces(structure, scratch.matrices.amplitudes, motion)
        store_in_cache(cache, parameters, inputs, place_sites(structure, p, u, scratch))
    return int(cache.n[0])


def model_for(planes: Planes) -> Model:
    """Return the plant for a rotor with these planes; the model's constants are laid out as in `structure`.

    Raises
    ------
    ValueError
        If the rotor has more sites than there are fault codes.
    """
    if len(planes.sites) > MAX_SITES:
        raise ValueError(f"{len(planes.sites)} contact sites is not allowed; it must be at most {MAX_SITES}")
    return Model(
        name="rotor_contact",
        description="Flexible rotor with unbalance that can touch its retainer bearings and other sites",
        author="The amb-cosim authors",
        interface=interface_of(planes),
        initialise=initialise,
        step=step,
        n_state=n_state,
        n_work=n_work,
        packages=("rotor_contact", "fmi_export"),
        faults=_faults(planes),
        layout=planes.layout(),
        linear_state=linear_state,
    )


def _stable(planes: Planes) -> str:
    """Return advice for a rotor whose modes require shorter substeps than usual; empty for other rotors."""
    if planes.max_substep >= Planes.max_substep:
        return ""
    return (
        f"its fastest mode requires solver.max_substep <= {STABLE * planes.max_substep:.3g} s, but it is "
        "{solver.max_substep} s: lower it, or retain fewer modes or planes; otherwise "
    )


def _faults(planes: Planes) -> dict[int, str]:
    stiffness = ", ".join(f"{bearing}.k_b = {{{bearing}.k_b}} N/m" for bearing in planes.bearings)
    return {
        FAULT_TOO_MANY_EVENTS: f"too many contact events in one step; {_stable(planes)}shorten the communication step",
        FAULT_SINGULAR: f"the contact equations have no unique solution; {_stable(planes)}lower the coefficients of "
        "friction",
        FAULT_MODES: "no combination of stick, slip and opening of the sites in contact is consistent with the "
        "forces; lower the coefficients of friction",
        FAULT_NO_ORBIT: "initial.orbit = {initial.orbit} is not allowed; it requires passive bearings with enough "
        f"stiffness to support the rotor, {stiffness}",
        FAULT_LONG_STEP: "step size = {step_size} s is not allowed; it must be at most 100000 times "
        "solver.max_substep = {solver.max_substep} s",
        FAULT_ENERGY: "energy is not conserved: energy.balance = {energy.balance} J is more than solver.energy_limit = "
        "{solver.energy_limit} times the largest energy so far; lower solver.max_substep or, in contact, the contact "
        "stiffness or the friction",
        FAULT_TOO_STIFF: "a contact or a bearing is too stiff: it requires more than 100000 substeps in one "
        "communication step; lower its stiffness or damping, raise delta_c, or shorten the step",
        FAULT_INERTIA: "spin.inertia = {spin.inertia} kg.m2 is not allowed with a free spin and this unbalance; "
        "it must be the polar moment of inertia of the rotor and its drive, which exceeds that of the unbalance itself",
        FAULT_FAST: "a housing, a race or the spin changes too fast; the time constants of housing_mass with "
        "mount_stiffness and mount_damping, of race_inertia with its drag, and of spin.inertia with drive.gain must be "
        "at least 0.5 us",
        FAULT_NODAL: "contact.impact_law = 0 (nodal) is not allowed if a housing can move; it must be 1 (newton), "
        "which conserves momentum",
        **{
            FAULT_OFFSET
            + k: f"{site}.offset_x = {{{site}.offset_x}} m, {site}.offset_y = {{{site}.offset_y}} m is not "
            f"allowed; their distance from the centre must be < the clearance, {{{site}.clearance}} m, so that the "
            f"rotor starts free"
            for k, site in enumerate(site.name for site in planes.sites)
        },
    }
