"""Start of the rotor: at rest, or on the orbit that it would follow without retainers."""

from __future__ import annotations

import math

from fmi_export.jit import kernel
from fmi_export.model import Array
from rotor_contact.contact.friction import close_in_sliding
from rotor_contact.contact.site import Sites, can_touch, locate_journal, put_on_circle, remove_radial_velocity
from rotor_contact.forces.dynamics import Motion, accelerations, coefficients
from rotor_contact.shaft.linear_solver import Equations, solve

MAX_DEFLECTION = 1.0  # m; an equilibrium further away is that of a rotor without support


@kernel
def start_on_orbit(motion: Motion, equations: Equations, q: Array, v: Array) -> bool:
    """Compute the steady motion q = q_s + Re(Q exp(i theta)) at the start angle; return False if none exists.

    K q_s = steady,  (K - Omega^2 + i Omega C) Q = Omega^2 (cosine - i sine)        (coefficients of `Motion`)

    The angle theta of the motion is the start angle, and its spin speed is taken as constant. q (m) and v (m/s) are
    written here, shape (n,); `equations` is room for 2 n equations.
    """
    n = q.shape[0]
    A, b = equations
    K, C = coefficients(motion)
    steady, cosine, sine, _ = accelerations(motion)
    square = motion.Omega * motion.Omega
    for i in range(n):
        for j in range(n):
            A[i, j] = K[j, i]
        b[i] = steady[i]
    if not solve(equations, n):
        return False
    for i in range(n):
        q[i] = b[i]
    for i in range(n):
        for j in range(n):
            elastic = K[j, i] - (square if i == j else 0.0)
            viscous = motion.Omega * C[j, i]
            A[i, j] = elastic
            A[n + i, n + j] = elastic
            A[i, n + j] = -viscous
            A[n + i, j] = viscous
        b[i] = square * cosine[i]
        b[n + i] = -square * sine[i]
    if not solve(equations, 2 * n):
        return False
    direction_x, direction_y = math.cos(motion.theta), math.sin(motion.theta)
    for i in range(n):
        q[i] += direction_x * b[i] - direction_y * b[n + i]
        v[i] = -motion.Omega * (direction_y * b[i] + direction_x * b[n + i])
        if not abs(q[i]) < MAX_DEFLECTION:
            return False
    return True


@kernel
def clamp_to_clearance(sites: Sites, q: Array, v: Array, Omega: float) -> None:
    """Put each journal that is outside its retainer onto its circle, in sliding contact; other nodes do not move."""
    for site in sites:
        if can_touch(site) and locate_journal(site, q) > site.clearance:
            put_on_circle(site, q)
            remove_radial_velocity(site, v)
            close_in_sliding(site, v, Omega)
