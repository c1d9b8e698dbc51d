"""The plant's outputs, from its state and the last contact forces."""

from __future__ import annotations

import numpy as np

from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rotor_contact.contact.bodies import is_beyond_limit, kinetic_energy, strain_energy
from rotor_contact.contact.compliant import is_compliant, stored_energy
from rotor_contact.contact.face_forces import stored_at_face, write_face
from rotor_contact.contact.faces import faces_of
from rotor_contact.contact.friction import is_below_slip_scale
from rotor_contact.contact.site import Site, locate_journal, slip_velocity, tangential_component
from rotor_contact.contact.site_totals import write_totals
from rotor_contact.contact.workspace import Workspace, energy_integrals
from rotor_contact.forces.passive_bearings import stored_in_bearing
from rotor_contact.layout import State
from rotor_contact.shaft.products import dot, quadratic_form
from rotor_contact.shaft.structure import Structure
from rotor_contact.variables.energies import write_heat_and_work
from rotor_contact.variables.enumerations import FREE, ROLLING, SLIDING
from rotor_contact.variables.signals import Outputs, Parameters

SMALLEST_ENERGY = 1e-9  # J, below which a balance is rounding


@kernel
def write_outputs(
    structure: Structure,
    parameters: Parameters,
    w: Workspace,
    x: State,
    Omega: float,
    step_size: float,
    outputs: Outputs,
) -> None:
    """Write all outputs from the state `x`; `Omega` (rad/s) is the present spin speed.

    `step_size` (s) is the length of the last step, or 0 at the start.
    """
    n, sites = w.n, w.sites
    q = x.z[:n]
    v = x.z[n : 2 * n]
    scalars, head = outputs.scalars[0], x.head[0]
    scalars.theta = head.theta
    scalars.speed = Omega
    is_free = parameters.scalars[0].spin.free != 0.0
    scalars.drive.at_limit = 1.0 if is_free and is_beyond_limit(w.spin[0], Omega) else 0.0
    scalars.solver.tolerance_missed = head.tolerance_missed
    scalars.solver.method = head.method
    for k in range(structure.bearings.shape[0]):
        row = int(structure.bearings[k])
        outputs.displacements[2 * k] = q[row]
        outputs.displacements[2 * k + 1] = q[row + 1]
    for i in range(outputs.sensors.shape[0]):
        outputs.sensors[i] = dot(structure.sensors[i], q[: structure.K.shape[0]])
    for k in range(sites.shape[0]):
        locate_journal(sites[k], q)
        _write_site(sites[k], v, Omega, outputs.sites[k])
        _write_retainer(sites[k], q, v, x.sites[k], structure.valid_to, outputs.sites[k])
    for k in range(outputs.seals.shape[0]):
        seal = structure.seals.records[0, k]
        outputs.seals[k].beyond_table = 1.0 if Omega < seal.lowest or Omega > seal.highest else 0.0
    for k in range(outputs.thrust.shape[0]):
        outputs.thrust[k].z, outputs.thrust[k].speed = x.axial[k].z, x.axial[k].speed
    for k in range(outputs.faces.shape[0]):
        write_face(w, k, q, v, x.axial[0].z, x.axial[0].speed, x.faces[k].heat, step_size, outputs.faces[k])
    scalars.contact_state = _contact_state(structure, w)
    mechanical = write_mechanical_energy(structure, parameters, w, x, scalars.energy)
    write_heat_and_work(energy_integrals(x.z, n), mechanical - head.initial_energy, scalars.energy)


@kernel
def energy_error(energy: np.record, head: np.record) -> float:
    """Return the error of the energy balance in the outputs `energy`, relative to the largest energy so far."""
    mechanical = energy.kinetic + energy.strain
    largest = max(max(head.largest_energy, mechanical), max(abs(energy.dissipated), abs(energy.work)))
    head.largest_energy = largest
    error: float = abs(energy.balance) / max(largest, SMALLEST_ENERGY)
    return error


@kernel
def _contact_state(structure: Structure, w: Workspace) -> float:
    """Return a bit mask (1, 2, 4, ...) of the bearings whose retainers the rotor touches, across or along the shaft."""
    state = 0.0
    for bearing in range(structure.bearings.shape[0]):
        touches = False
        for k in range(w.sites.shape[0]):
            touches = touches or (structure.site_bearings[k] == bearing and w.sites[k].mode != FREE)
        for face in faces_of(w.faces, w.Minv.shape[0]).records:
            if face.is_pressed != 0.0 and face.site >= 0.0:
                touches = touches or structure.site_bearings[int(face.site)] == bearing
        if touches:
            state += 2.0**bearing
    return state


@kernel
def _write_site(site: Site, v: Array, Omega: float, y: np.record) -> None:
    """Write the contact outputs of a site into `y`; its radius and normal must be up to date."""
    closed = site.mode != FREE
    slip = slip_velocity(site, v, Omega)
    y.x, y.y = site.radius * site.n_x, site.radius * site.n_y
    y.gap = site.clearance - site.radius
    y.mode = site.mode
    if is_compliant(site):
        if is_below_slip_scale(site, slip):
            y.mode = ROLLING
    elif closed:
        y.gap = 0.0
    y.f_n = site.f_n if closed else 0.0
    y.f_t = site.f_t if closed else 0.0
    write_totals(site, y)
    y.slip_velocity = slip
    y.friction_power = -site.f_t * slip if site.mode == SLIDING else 0.0
    y.whirl_speed = tangential_component(site, v) / site.radius if site.radius > 0.0 else 0.0


@kernel
def _write_retainer(site: Site, q: Array, v: Array, state: np.record, valid_to: float, y: np.record) -> None:
    """Write the retainer outputs of a site, and its warnings, into `y`."""
    y.housing_x = q[site.housing] if site.housing >= 0 else 0.0
    y.housing_y = q[site.housing + 1] if site.housing >= 0 else 0.0
    y.race_speed = v[site.race] if site.race >= 0 else 0.0
    y.heat = state.heat
    y.temperature = state.temperature
    y.passed = 1.0 if site.enabled == 0.0 and site.radius > site.clearance else 0.0
    y.beyond_reduction = 1.0 if site.mode != FREE and abs(y.whirl_speed) > valid_to else 0.0
    y.overheated = 1.0 if state.temperature > site.temperature_limit else 0.0


@inlined_kernel
def write_mechanical_energy(
    structure: Structure, parameters: Parameters, w: Workspace, x: State, energy: np.record
) -> float:
    """Write the kinetic and strain energy (J) of the state `x` to the outputs `energy`; return their sum."""
    n, sites = w.n, w.sites
    q = x.z[:n]
    v = x.z[n : 2 * n]
    kinetic = 0.5 * quadratic_form(structure.forms, v)
    strain = 0.5 * quadratic_form(structure.K, q)
    for k in range(parameters.bearings.shape[0]):
        row = int(structure.bearings[k])
        strain += stored_in_bearing(parameters.bearings[k], q[row], q[row + 1])
    for site in sites:
        if is_compliant(site):
            strain += stored_energy(site, max(locate_journal(site, q) - site.clearance, 0.0))
    if n > structure.K.shape[0]:
        kinetic += kinetic_energy(sites, v)
        strain += strain_energy(sites, q)
    if parameters.scalars[0].spin.free != 0.0:
        Omega = v[w.spin[0].row] if w.spin[0].row >= 0 else x.head[0].speed
        kinetic += 0.5 * w.spin[0].inertia * Omega * Omega + x.head[0].coupling
    for axial in x.axial:
        kinetic += 0.5 * structure.mass * axial.speed * axial.speed
    for k in range(structure.n_faces):
        strain += stored_at_face(w, k, q, x.axial[0].z)
    energy.kinetic = kinetic
    energy.strain = strain
    total: float = kinetic + strain
    return total
