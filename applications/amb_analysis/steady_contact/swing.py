"""Swing: the smallest friction that turns a fall of journals in their retainers into backward whirl.

Journals fall by h c from their levitated position to the lowest point, where h = 1 if they levitate at the centre of
the retainers. In the worst case, all of their speed becomes motion along the circle, against the spin. Friction then
drives them up the other side, against weight and damping. With the angle theta from the lowest point and u = theta'^2,

    (M c/2) du/dtheta = mu (N + W cos theta) - W sin theta - L,    u(0) = 2 g h/c - h^2 k/M             (1)
    N + i L = sum_j c_j (-E c)_j/c,    E = (R + H)^-1,    M = (N + k c)/(c omega^2)                     (2)

where N and L are the normal force and the retarding force of a whirl at omega = -sqrt(u) without weight, R + H are the
receptances of `unpowered`, and c is the mean clearance. k = -N(0)/c is the stiffness of seals, which the fall deflects
by h c. M is evaluated at sqrt(g/c). The journals whirl if u and N + W cos theta are positive up to the top, theta = pi.
Two journals are assumed to swing side by side, as they fall. On opposite sides, gyroscopic moments would make N large,
but a fall would not give the journals the speed and the effect of weight that (1) assumes. Races are assumed to be at
rest, although a turning race would reduce friction.

For a rigid rotor in rigid retainers, N = m c u and L = 0, and (1) has a closed-form solution. At the top, N + W cos
theta is W (2 (h (1 + 4 mu^2) - 1 + 2 mu^2) exp(2 pi mu) - 3)/(1 + 4 mu^2). The rotor therefore whirls after a fall from
the centre if

    12 mu^2 exp(2 pi mu) > 3,    mu > 0.2373                                                            (3)

for any mass, clearance and speed. The outcomes of landings scatter because of bounces and bending. In simulations, some
rotors whirl by chance with less friction than (1) requires, but none whirls with less than half of this friction.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from amb_analysis.steady_contact.forward_loop import Complex
from array_types import Array, Bools

STEPS = 100  # of the angle from the lowest point to the top
FREQUENCIES, SLOWEST, FASTEST = 160, 0.02, 6.0  # of (2), and their range over sqrt(g/c)
AT_REST = 1e-3  # frequency of k over sqrt(g/c)
MOST = 2.0  # largest searched friction coefficient
ROUNDS, TRIALS = 4, 17  # of the search, and friction coefficients in each


@dataclass(frozen=True, eq=False)
class WhirlForces:
    """The forces (2) of journals that whirl backward.

    c
        Mean clearance (m).
    omega, N, L
        Whirl frequencies (rad/s), ascending, and the forces (N), shape (n,).
    k
        Stiffness (N/m) that pulls journals towards the centre while they do not whirl.
    """

    c: float
    omega: Array
    N: Array
    L: Array
    k: float = 0.0

    def at(self, u: Array) -> tuple[Array, Array]:
        """Return N and L at squared frequencies (rad^2/s^2)."""
        omega = np.sqrt(np.maximum(u, 0.0))
        return np.interp(omega, self.omega, self.N), np.interp(omega, self.omega, self.L)


def whirl_forces(
    relative: Callable[[float], Complex], at: Sequence[int], c: Array, g: float, *, held: bool = False
) -> WhirlForces:
    """Return the forces (2) of journals that whirl together, at frequencies around the pendulum frequency sqrt(g/c).

    Parameters
    ----------
    relative
        Function of the frequency (rad/s) that returns R + H, the receptances (m/N) of journals relative to their
        retainers, shape (n_sites, n_sites).
    at
        Indices of the journals that whirl, at most two.
    c, g
        Clearances of these journals (m), and acceleration of gravity (m/s^2).
    held
        Whether seals hold the rotor. If not, it is free, and k is 0.
    """
    mean, chosen = float(c.mean()), np.ix_(at, at)
    pendulum = float(np.sqrt(g / mean))

    def force(frequency: float) -> complex:
        return complex(-c @ np.linalg.inv(relative(-frequency)[chosen]) @ c) / mean

    omega = pendulum * np.linspace(SLOWEST, FASTEST, FREQUENCIES)
    forces = np.array([force(float(frequency)) for frequency in omega])
    k = -force(AT_REST * pendulum).real / mean if held else 0.0
    return WhirlForces(mean, omega, forces.real, forces.imag, k)


def least_swinging_friction(forces: WhirlForces, W: float, g: float, h: float = 1.0) -> float:
    """Return the smallest friction coefficient that turns a fall into backward whirl by (1), at most `MOST`.

    Parameters
    ----------
    forces
        Forces of the falling journals.
    W, g
        Weight that the journals carry (N), and acceleration of gravity (m/s^2).
    h
        Height from which the journals fall to the lowest point, relative to the clearance.
    """
    low, high = 0.0, MOST
    for _ in range(ROUNDS):
        mu = np.linspace(low, high, TRIALS)
        over = np.flatnonzero(passes_the_top(forces, mu, W, g, h))
        if not len(over):
            return MOST
        low, high = float(mu[max(over[0] - 1, 0)]), float(mu[over[0]])
    return high


def passes_the_top(forces: WhirlForces, mu: Array, W: float, g: float, h: float = 1.0) -> Bools:
    """Return whether journals pass the top of their circle by (1), for each friction coefficient, shape (n,)."""
    c, step, start = forces.c, np.pi / STEPS, np.sqrt(g / forces.c)
    M = (float(np.interp(start, forces.omega, forces.N)) + forces.k * c) / (c * start**2)
    if M <= 0.0 or M * g <= 0.5 * forces.k * h * c:  # a fall does not reach the lowest point
        return np.zeros(len(mu), dtype=bool)
    u = np.full(len(mu), 2.0 * g * h / c - forces.k * h**2 / M)

    def slope(theta: float, u: Array) -> Array:
        N, L = forces.at(u)
        return 2.0 * (mu * (N + W * np.cos(theta)) - W * np.sin(theta) - L) / (M * c)

    whirls = np.ones(len(mu), dtype=bool)
    for k in range(STEPS):
        theta = k * step
        k1 = slope(theta, u)
        k2 = slope(theta + 0.5 * step, u + 0.5 * step * k1)
        k3 = slope(theta + 0.5 * step, u + 0.5 * step * k2)
        k4 = slope(theta + step, u + step * k3)
        u = u + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        whirls &= (u > 0.0) & (forces.at(u)[0] + W * np.cos(theta + step) > 0.0)
    return whirls
