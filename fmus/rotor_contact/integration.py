"""One substep of smooth motion by the classical fourth-order Runge-Kutta method, kept on the contact constraints."""

from __future__ import annotations

import math

from fmi_export.flat import copy
from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.compliant import apply_compliant, compliant_limit
from rotor_contact.contact import MODE, TANGENTIAL, apply_contact, held, project, slip_velocity, tangential
from rotor_contact.dynamics import Motion, damping_power, free_acceleration, input_power, spin, unbalance_direction
from rotor_contact.interface import CLEARANCE, FREE, JOURNAL_RADIUS, N_SITES, SLIDING

# A state z is (q, v, heat of damping, friction and impact, work); its last columns count from 2 n.
DAMPING_HEAT, FRICTION_HEAT, IMPACT_HEAT, WORK_DONE = range(4)
TALLIES = 4

# Rows of the array `r` of an integration, shape (RUNGE_ROWS, 2 n + TALLIES).
Z, Z_NEW = 0, 1  # at the beginning and at the end of a substep
K_1, K_NEW = 2, 3  # the derivatives there
STAGE, K_2, K_3, K_4 = 4, 5, 6, 7
BEFORE = 8  # scratch of impacts
RUNGE_ROWS = 9

MAX_TURN = 0.035  # rad that a closed site may whirl in a substep: rolling is fast, and the constraint turns with it
SHORTEST_TURN = 0.01  # of a substep; none shorter however fast the whirl, so that a step always ends


@kernel
def derivative(Minv: Array, m: Motion, sites: Array, equations: Array, tau: float, z: Array, dz: Array) -> bool:
    """d/dt of z at `tau` with contact; False if the contact equations are singular.

    Friction heat is -T v_slip; of it the drive's work is -T R_s Omega, also where nothing slips.
    """
    n = Minv.shape[0]
    q = z[:n]
    v = z[n : 2 * n]
    a = dz[n : 2 * n]
    copy(v, dz)
    Omega = spin(m, tau)
    along, across = unbalance_direction(m, tau)
    free_acceleration(m, tau, along, across, q, v, a)
    compression = apply_compliant(Minv, sites, q, v, Omega, a)
    solved = apply_contact(Minv, sites, equations, q, v, m.Omega_dot, a)
    friction = 0.0
    work = input_power(m, along, across, q, v)
    for k in range(N_SITES):
        if sites[k, MODE] != FREE:
            if sites[k, MODE] == SLIDING:
                friction -= sites[k, TANGENTIAL] * slip_velocity(sites, k, v, Omega)
            work -= sites[k, TANGENTIAL] * sites[k, JOURNAL_RADIUS] * Omega
    dz[2 * n + DAMPING_HEAT] = damping_power(m, v)
    dz[2 * n + FRICTION_HEAT] = friction
    dz[2 * n + IMPACT_HEAT] = compression
    dz[2 * n + WORK_DONE] = work
    return solved


@kernel
def substep(Minv: Array, m: Motion, sites: Array, equations: Array, r: Array, tau: float, dt: float) -> bool:
    """Advance z to z_new by `dt` (s) from `tau`, projected onto the constraints; leaves its derivative in k_new."""
    n = Minv.shape[0]
    size = 2 * n + TALLIES
    stage = r[STAGE]
    for i in range(size):
        stage[i] = r[Z, i] + 0.5 * dt * r[K_1, i]
    solved = derivative(Minv, m, sites, equations, tau + 0.5 * dt, stage, r[K_2])
    for i in range(size):
        stage[i] = r[Z, i] + 0.5 * dt * r[K_2, i]
    solved = derivative(Minv, m, sites, equations, tau + 0.5 * dt, stage, r[K_3]) and solved
    for i in range(size):
        stage[i] = r[Z, i] + dt * r[K_3, i]
    solved = derivative(Minv, m, sites, equations, tau + dt, stage, r[K_4]) and solved
    for i in range(size):
        r[Z_NEW, i] = r[Z, i] + dt / 6.0 * (r[K_1, i] + 2.0 * (r[K_2, i] + r[K_3, i]) + r[K_4, i])
    z = r[Z_NEW]
    solved = project(Minv, sites, equations, z[:n], z[n : 2 * n], spin(m, tau + dt)) and solved
    return derivative(Minv, m, sites, equations, tau + dt, z, r[K_NEW]) and solved


@kernel
def velocity_error(r: Array, dt: float) -> float:
    """Estimate of the error of the velocities (m/s) of the substep just taken, the largest of all master planes.

    A third-order formula is embedded that takes the derivative at the end in place of the last stage; the estimate is
    the difference, dt/6 (k_4 - k_new).
    """
    n = (r.shape[1] - TALLIES) // 2
    largest = 0.0
    for i in range(n, 2 * n, 2):
        along, across = r[K_4, i] - r[K_NEW, i], r[K_4, i + 1] - r[K_NEW, i + 1]
        largest = max(largest, along * along + across * across)
    return dt / 6.0 * math.sqrt(largest)


@kernel
def substep_limit(Minv: Array, sites: Array, v: Array, Omega: float, longest: float) -> float:
    """Length (s) of a substep that resolves every contact, at most `longest`.

    No held site whirls by more than `MAX_TURN` in it; of yielding contacts see `compliant_limit`.
    """
    limit = longest
    for k in range(N_SITES):
        if held(sites, k):
            whirl = abs(tangential(sites, k, v)) / sites[k, CLEARANCE]
            if whirl * limit > MAX_TURN:
                limit = MAX_TURN / whirl
    return compliant_limit(Minv, sites, v, Omega, max(limit, SHORTEST_TURN * longest))
