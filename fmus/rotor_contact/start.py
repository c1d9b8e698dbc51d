"""Where the rotor starts: at rest, or on the orbit that it would have without its retainers."""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact import can_touch, locate, put_on_circle, solve, stop_radially
from rotor_contact.dynamics import COSINE, SINE, STEADY, Motion
from rotor_contact.impact import begin_slip
from rotor_contact.interface import CLEARANCE, N_SITES

FURTHEST = 1.0  # m; an equilibrium further away is that of a rotor that nothing holds


@kernel
def start_on_orbit(m: Motion, equations: Array, q: Array, v: Array) -> bool:
    """Displacement and velocity of the steady motion q = q_s + Re(Q exp(i theta)) at theta = 0; False if there is none.

    K q_s = steady,  (K - Omega^2 + i Omega C) Q = Omega^2 (cosine - i sine)        (coefficients of `Motion`)

    Parameters
    ----------
    m
        The motion; its angle is taken as zero and its spin speed as constant.
    equations
        Scratch, shape (2 n, 2 n + 1).
    q, v
        Where the displacement (m) and velocity (m/s) go, shape (n,).
    """
    n = q.shape[0]
    c = m.coefficients
    square = m.Omega * m.Omega
    for i in range(n):
        for j in range(n):
            equations[i, j] = c[j, i]
        equations[i, 2 * n] = c[2 * n + STEADY, i]
    if not solve(equations, n, 2 * n):
        return False
    for i in range(n):
        q[i] = equations[i, 2 * n]
        if not abs(q[i]) < FURTHEST:
            return False
    for i in range(n):
        for j in range(n):
            elastic = c[j, i] - (square if i == j else 0.0)
            viscous = m.Omega * c[n + j, i]
            equations[i, j] = elastic
            equations[n + i, n + j] = elastic
            equations[i, n + j] = -viscous
            equations[n + i, j] = viscous
        equations[i, 2 * n] = square * c[2 * n + COSINE, i]
        equations[n + i, 2 * n] = -square * c[2 * n + SINE, i]
    if not solve(equations, 2 * n, 2 * n):
        return False
    for i in range(n):
        q[i] += equations[i, 2 * n]
        v[i] = -m.Omega * equations[n + i, 2 * n]
        if not abs(q[i]) < FURTHEST:
            return False
    return True


@kernel
def put_back(sites: Array, q: Array, v: Array, Omega: float) -> None:
    """Put journals that are beyond their retainer back onto it, sliding; the rest of the rotor stays where it is."""
    for k in range(N_SITES):
        if can_touch(sites, k) and locate(sites, k, q) > sites[k, CLEARANCE]:
            put_on_circle(sites, k, q)
            stop_radially(sites, k, v)
            begin_slip(sites, k, v, Omega)
