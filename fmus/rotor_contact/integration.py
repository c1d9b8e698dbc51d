"""One substep of smooth motion by the classical fourth-order Runge-Kutta method, kept on the contact constraints."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact import MODE, TANGENTIAL, apply_contact, project, slip_velocity, tangential
from rotor_contact.dynamics import Motion, damping_power, free_acceleration
from rotor_contact.interface import CLEARANCE, FREE, N_SITES, SLIDING

# Rows of the array `r` of an integration, shape (RUNGE_ROWS, 2 n + 1). A state z is (q, v, heat).
Z, Z_NEW = 0, 1  # at the beginning and at the end of a substep
K_1, K_NEW = 2, 3  # the derivatives there
STAGE, K_2, K_3, K_4 = 4, 5, 6, 7
BEFORE = 8  # scratch of impacts
RUNGE_ROWS = 9

MAX_TURN = 0.1  # rad that a closed site may whirl in a substep: rolling is fast, and the constraint turns with it
SHORTEST_TURN = 0.01  # of a substep; none shorter however fast the whirl, so that a step always ends


@kernel
def derivative(Minv: Array, m: Motion, sites: Array, equations: Array, tau: float, z: Array, dz: Array) -> bool:
    """d/dt (q, v, heat) with contact; heat is the power of passive bearing damping and friction (W)."""
    n = Minv.shape[0]
    q = z[:n]
    v = z[n : 2 * n]
    a = dz[n : 2 * n]
    dz[:n] = v
    free_acceleration(m, tau, q, v, a)
    solved = apply_contact(Minv, sites, equations, q, v, a)
    heat = damping_power(m, v)
    for k in range(N_SITES):
        if sites[k, MODE] == SLIDING:
            heat -= sites[k, TANGENTIAL] * slip_velocity(sites, k, v, m.Omega)
    dz[2 * n] = heat
    return solved


@kernel
def substep(Minv: Array, m: Motion, sites: Array, equations: Array, r: Array, tau: float, dt: float) -> bool:
    """Advance z to z_new by `dt` (s) from `tau`, projected onto the constraints; leaves its derivative in k_new."""
    n = Minv.shape[0]
    stage = r[STAGE]
    for i in range(2 * n + 1):
        stage[i] = r[Z, i] + 0.5 * dt * r[K_1, i]
    solved = derivative(Minv, m, sites, equations, tau + 0.5 * dt, stage, r[K_2])
    for i in range(2 * n + 1):
        stage[i] = r[Z, i] + 0.5 * dt * r[K_2, i]
    solved = derivative(Minv, m, sites, equations, tau + 0.5 * dt, stage, r[K_3]) and solved
    for i in range(2 * n + 1):
        stage[i] = r[Z, i] + dt * r[K_3, i]
    solved = derivative(Minv, m, sites, equations, tau + dt, stage, r[K_4]) and solved
    for i in range(2 * n + 1):
        r[Z_NEW, i] = r[Z, i] + dt / 6.0 * (r[K_1, i] + 2.0 * (r[K_2, i] + r[K_3, i]) + r[K_4, i])
    z = r[Z_NEW]
    solved = project(Minv, sites, equations, z[:n], z[n : 2 * n], m.Omega) and solved
    return derivative(Minv, m, sites, equations, tau + dt, z, r[K_NEW]) and solved


@kernel
def substep_limit(sites: Array, v: Array, longest: float) -> float:
    """Length (s) of a substep in which no closed site whirls by more than `MAX_TURN`, at most `longest`."""
    limit = longest
    for k in range(N_SITES):
        if sites[k, MODE] != FREE:
            whirl = abs(tangential(sites, k, v)) / sites[k, CLEARANCE]
            if whirl * limit > MAX_TURN:
                limit = MAX_TURN / whirl
    return max(limit, SHORTEST_TURN * longest)
