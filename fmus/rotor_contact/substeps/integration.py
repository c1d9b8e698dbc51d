"""One substep of smooth motion by the classical fourth-order Runge-Kutta method, kept on the contact constraints."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rotor_contact.contact.bodies import accelerate_bodies, body_limit, mount_heat, power_on_bodies, race_drag
from rotor_contact.contact.compliant import apply_compliant, compliant_limit, compression_heat, is_compliant
from rotor_contact.contact.constraints import apply_contact, project
from rotor_contact.contact.face_forces import apply_faces, face_limit, write_face_rates
from rotor_contact.contact.site import is_constrained, race_radius, slip_velocity, tangential_component
from rotor_contact.contact.site_totals import collect_substep, set_rates
from rotor_contact.contact.workspace import Workspace, energy_integrals, site_integrals, stages_of
from rotor_contact.forces.dynamics import (
    damping_power,
    free_acceleration,
    input_power,
    shaft_damping,
    unbalance_direction,
)
from rotor_contact.forces.passive_bearings import passive_limit
from rotor_contact.shaft.seals import add_change_of_seals, seal_power
from rotor_contact.variables.enumerations import FREE, SLIDING

MAX_WHIRL_ANGLE = 0.035  # rad that a closed site may whirl in a substep: rolling is fast, the constraint turns with it
MIN_SUBSTEP = 0.01  # of the longest substep; none is shorter however fast the whirl, so that a step always ends


@kernel
def spin_speed(w: Workspace, tau: float, z: Array) -> float:
    """Return the spin speed (rad/s) at `tau` (s) into the step: prescribed, or part of the state z."""
    row = w.spin[0].row
    if row >= 0:
        speed: float = z[w.n + row]
        return speed
    return w.motion.Omega + w.motion.Omega_dot * tau


@inlined_kernel
def derivative(w: Workspace, tau: float, z: Array, dz: Array) -> bool:
    """Write the rate of z at `tau` (s), with contact, into `dz`; return False if the contact equations are singular.

    Friction heat is -T v_slip. If the speed is prescribed, the drive supplies the power -T R_s Omega, even without
    slip.
    """
    n = w.n
    motion, spin = w.motion, w.spin[0]
    q = z[:n]
    v = z[n : 2 * n]
    a = dz[n : 2 * n]
    copy(v, dz)
    Omega = spin_speed(w, tau, z)
    theta = motion.theta + 0.5 * (motion.Omega + Omega) * tau
    speed_gain = motion.Omega_dot * tau
    if spin.row >= 0:
        theta, speed_gain = q[spin.row], Omega - motion.Omega
    unbalance = unbalance_direction(theta, Omega, motion.Omega_dot)
    free_acceleration(motion, speed_gain, unbalance, q, v, a)
    if speed_gain != 0.0:
        add_change_of_seals(motion.seals, motion.Omega, motion.Omega + speed_gain, q, v, a)
    shaft_heat = damping_torque = 0.0
    if motion.is_damped:
        shaft_heat, damping_torque = shaft_damping(w.forms, Omega, q, v)
    if n > w.Minv.shape[0]:
        accelerate_bodies(w, q, v, damping_torque, a)
    apply_compliant(w, z, Omega, a)
    apply_faces(w, z, Omega, a)
    solved = apply_contact(w, q, v, Omega, a)
    _write_rates(w, Omega, unbalance, shaft_heat, damping_torque, z, dz)
    return solved


@inlined_kernel
def _write_rates(
    w: Workspace, Omega: float, unbalance: complex, shaft_heat: float, damping_torque: float, z: Array, dz: Array
) -> None:
    """Write the rates of all integrals at z into `dz`.

    `shaft_heat` (W) and `damping_torque` (N m) come from `shaft_damping`.
    """
    n = w.n
    spin = w.spin[0]
    q = z[:n]
    v = z[n : 2 * n]
    heat_in_seals, power_of_seals, _ = seal_power(w.motion.seals, Omega, q, v)
    damping = damping_power(w.motion, v) + shaft_heat + heat_in_seals
    friction = compression = 0.0
    work = input_power(w.motion, unbalance if spin.row < 0 else 0j, q, v) + power_of_seals
    if spin.row < 0:
        work -= Omega * damping_torque
    for k in range(w.sites.shape[0]):
        site, rate = w.sites[k], site_integrals(dz, n, k)
        heat = 0.0
        if site.mode != FREE:
            if site.mode == SLIDING:
                heat = -(site.f_t * slip_velocity(site, v, Omega))
            if spin.row < 0:
                work -= site.f_t * site.journal_radius * Omega
        if site.race >= 0:
            heat += race_drag(site, v[site.race]) * v[site.race]
        friction += heat
        if is_compliant(site):
            compressed = compression_heat(site, v)
            compression += compressed
            heat += compressed
        set_rates(site, heat, rate)
    if n > w.Minv.shape[0]:
        damping += mount_heat(w.sites, spin, v)
        work += power_on_bodies(w.sites, spin, v)
    rates = energy_integrals(dz, n)
    rates.damping_heat = damping
    rates.friction_heat = friction
    rates.impact_heat = compression
    rates.work = work
    write_face_rates(w, Omega, dz)


@kernel
def substep(w: Workspace, tau: float, dt: float) -> bool:
    """Advance z to z_new by `dt` (s) from `tau`, projected onto the constraints; store the derivative in k_new."""
    n = w.n
    stages = stages_of(w.stages)
    z, z_new, trial = stages.z, stages.z_new, stages.trial
    k_1, k_2, k_3, k_4 = stages.k_1, stages.k_2, stages.k_3, stages.k_4
    size = z.shape[0]
    solved = True
    for k, k_next, share in ((k_1, k_2, 0.5), (k_2, k_3, 0.5), (k_3, k_4, 1.0)):
        for i in range(size):
            trial[i] = z[i] + share * dt * k[i]
        solved = derivative(w, tau + share * dt, trial, k_next) and solved
    for i in range(size):
        z_new[i] = z[i] + dt / 6.0 * (k_1[i] + 2.0 * (k_2[i] + k_3[i]) + k_4[i])
    solved = project(w, z_new[:n], z_new[n : 2 * n], spin_speed(w, tau + dt, z_new)) and solved
    return derivative(w, tau + dt, z_new, stages.k_new) and solved


@kernel
def collect_last_substep(w: Workspace) -> None:
    """Add the last substep to the totals of each site."""
    n, stages = w.n, stages_of(w.stages)
    for k in range(w.sites.shape[0]):
        begin, end = site_integrals(stages.k_1, n, k), site_integrals(stages.k_new, n, k)
        second, third = site_integrals(stages.k_2, n, k), site_integrals(stages.k_3, n, k)
        collect_substep(w.sites[k], begin, second, third, end)


@kernel
def velocity_error(w: Workspace, dt: float) -> float:
    """Estimate the velocity error (m/s) of the last substep: the largest error among all planes and bodies.

    An embedded third-order formula uses the derivative at the end instead of the last stage; the estimate is the
    difference, dt/6 (k_4 - k_new).
    """
    n = w.n
    stages = stages_of(w.stages)
    largest = 0.0
    for i in range(n, n + w.n_translations, 2):
        e_x, e_y = stages.k_4[i] - stages.k_new[i], stages.k_4[i + 1] - stages.k_new[i + 1]
        largest = max(largest, e_x * e_x + e_y * e_y)
    if n > w.Minv.shape[0]:
        largest = max(largest, _body_error(w, stages.k_4[n:], stages.k_new[n:]))
    return dt / 6.0 * math.sqrt(largest)


@kernel
def _body_error(w: Workspace, a: Array, a_new: Array) -> float:
    """Return the largest squared difference (m^2/s^4) of two accelerations of housing, race or journal surface."""
    largest = 0.0
    for site in w.sites:
        if site.housing >= 0:
            x, y = site.housing, site.housing + 1
            largest = max(largest, (a[x] - a_new[x]) ** 2 + (a[y] - a_new[y]) ** 2)
        if site.race >= 0:
            largest = max(largest, (race_radius(site) * (a[site.race] - a_new[site.race])) ** 2)
        if site.spin >= 0:
            largest = max(largest, (site.journal_radius * (a[site.spin] - a_new[site.spin])) ** 2)
    return largest


@kernel
def substep_limit(w: Workspace, Omega: float, longest: float) -> float:
    """Return a substep length (s), at most `longest`, that resolves the bearings and every contact at z.

    Constrained sites whirl by at most `MAX_WHIRL_ANGLE` in a substep; see also `passive_limit`, `body_limit` and
    `compliant_limit`.
    """
    n = w.n
    v = stages_of(w.stages).z[n : 2 * n]
    limit = longest
    for site in w.sites:
        if is_constrained(site):
            whirl = abs(tangential_component(site, v)) / site.clearance
            if whirl * limit > MAX_WHIRL_ANGLE:
                limit = MAX_WHIRL_ANGLE / whirl
    limit = passive_limit(w.Minv, w.motion.bearings, max(limit, MIN_SUBSTEP * longest))
    if n > w.Minv.shape[0]:
        limit = min(limit, body_limit(w.sites, w.spin[0]))
    limit = compliant_limit(w.Minv, w.sites, v, Omega, limit)
    return face_limit(w, Omega, limit) if w.faces.shape[0] > 0 else limit
