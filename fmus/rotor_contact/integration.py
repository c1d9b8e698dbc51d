"""One substep of smooth motion by the classical fourth-order Runge-Kutta method, kept on the contact constraints."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import inlined_kernel, kernel
from fmi_export.model import Array
from rotor_contact.compliant import apply_compliant, compliant_limit
from rotor_contact.contact import apply_contact, project
from rotor_contact.dynamics import damping_power, free_acceleration, input_power, spin_speed, unbalance_direction
from rotor_contact.interface import FREE, SLIDING
from rotor_contact.site import is_constrained, slip_velocity, tangential_component
from rotor_contact.workspace import Workspace, energy_integrals, stages_of

MAX_WHIRL_ANGLE = 0.035  # rad that a closed site may whirl in a substep: rolling is fast, the constraint turns with it
MIN_SUBSTEP = 0.01  # of the longest substep; none is shorter however fast the whirl, so that a step always ends


@inlined_kernel
def derivative(w: Workspace, tau: float, z: Array, dz: Array) -> bool:
    """Write d/dt of z at `tau` (s) with contact into `dz`; return False if the contact equations are singular.

    Friction heat is -T v_slip; of it the drive's work is -T R_s Omega, also where nothing slips.
    """
    n = w.Minv.shape[0]
    q = z[:n]
    v = z[n : 2 * n]
    a = dz[n : 2 * n]
    copy(v, dz)
    Omega = spin_speed(w.motion, tau)
    unbalance = unbalance_direction(w.motion, tau)
    free_acceleration(w.motion, tau, unbalance, q, v, a)
    compression = apply_compliant(w.Minv, w.sites, z, Omega, a)
    solved = apply_contact(w, q, v, Omega, a)
    friction = 0.0
    work = input_power(w.motion, unbalance, q, v)
    for site in w.sites:
        if site.mode != FREE:
            if site.mode == SLIDING:
                friction -= site.f_t * slip_velocity(site, v, Omega)
            work -= site.f_t * site.journal_radius * Omega
    rates = energy_integrals(dz, n)
    rates.damping_heat = damping_power(w.motion, v)
    rates.friction_heat = friction
    rates.impact_heat = compression
    rates.work = work
    return solved


@kernel
def substep(w: Workspace, tau: float, dt: float) -> bool:
    """Advance z to z_new by `dt` (s) from `tau`, projected onto the constraints; leave its derivative in k_new."""
    n = w.Minv.shape[0]
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
    solved = project(w, z_new[:n], z_new[n : 2 * n], spin_speed(w.motion, tau + dt)) and solved
    return derivative(w, tau + dt, z_new, stages.k_new) and solved


@kernel
def velocity_error(w: Workspace, dt: float) -> float:
    """Estimate the error of the velocities (m/s) of the last substep, the largest of all master planes.

    A third-order formula is embedded that takes the derivative at the end in place of the last stage; the estimate is
    the difference, dt/6 (k_4 - k_new).
    """
    n = w.Minv.shape[0]
    stages = stages_of(w.stages)
    largest = 0.0
    for i in range(n, n + w.n_translations, 2):
        e_x, e_y = stages.k_4[i] - stages.k_new[i], stages.k_4[i + 1] - stages.k_new[i + 1]
        largest = max(largest, e_x * e_x + e_y * e_y)
    return dt / 6.0 * math.sqrt(largest)


@kernel
def substep_limit(w: Workspace, Omega: float, longest: float) -> float:
    """Return the length (s) of a substep that resolves every contact at z, at most `longest`.

    No constrained site whirls by more than `MAX_WHIRL_ANGLE` in it; for compliant contacts see `compliant_limit`.
    """
    n = w.Minv.shape[0]
    v = stages_of(w.stages).z[n : 2 * n]
    limit = longest
    for site in w.sites:
        if is_constrained(site):
            whirl = abs(tangential_component(site, v)) / site.clearance
            if whirl * limit > MAX_WHIRL_ANGLE:
                limit = MAX_WHIRL_ANGLE / whirl
    return compliant_limit(w.Minv, w.sites, v, Omega, max(limit, MIN_SUBSTEP * longest))
