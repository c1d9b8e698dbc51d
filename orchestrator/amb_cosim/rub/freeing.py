"""The smallest synchronous control force that frees a rotor which may stay in contact.

Currents I, injected beside the controller's, move the orbit without contact to r = r_0 + S I. A state of one site in
contact exists only where |r| is at least (`synchronous_states`, the discriminant of its quadratic)

    b = c |sin arg rho| if Re rho < 0,   b = c otherwise                                              (1)

so |r_k + S_k I| <= s b_k at all sites, with s = 1, leaves none of these; states of several sites are looked for, and s
is lowered until there is none. What is then left is the orbit without contact. Of all such currents those are returned
whose largest is the smallest: a convex problem,

    minimise t,  |I_b| <= t,  |r_k + S_k I| <= s b_k                                                  (2)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from scipy.optimize import minimize

from amb_cosim.controllers.laws import Array
from amb_cosim.rub.forward_loop import Complex
from amb_cosim.rub.rubbing_rotor import RubbingRotor
from amb_cosim.rub.synchronous_states import all_sets, states_of

HALVINGS = 8  # of the interval that holds s
MARGIN = 1e-6  # share by which orbits are kept off the limit


@dataclass(frozen=True, eq=False)
class Freeing:
    """Currents that leave no state in contact.

    injected
        Complex current added at each bearing, in the rotating frame (A).
    demanded
        What is then demanded there, with the feedback's share, while the rotor turns free (A).
    share
        s of (2): how much smaller orbits are kept for states of several sites.
    """

    injected: dict[str, complex]
    demanded: dict[str, complex]
    share: float

    @property
    def largest(self) -> Annotated[float, "A"]:
        """Largest amplitude of an injected current (A)."""
        return max((abs(value) for value in self.injected.values()), default=0.0)


def smallest_freeing(rotor: RubbingRotor, Omega: float) -> Freeing | None:
    """Return the smallest injected currents that free a rotor at a speed (rad/s); None where no currents do.

    Currents of zero where it has no state in contact and turns free by itself.
    """
    n = len(rotor.loop(Omega).currents)
    if _is_free(rotor, Omega, np.zeros(n, dtype=complex)):
        return _told(rotor, Omega, np.zeros(n, dtype=complex), 1.0)
    return _smallest(rotor, Omega, np.eye(n, dtype=complex), np.zeros(n, dtype=complex)) if n else None


def smallest_demand(rotor: RubbingRotor, Omega: float, allowed: Array) -> Freeing | None:
    """Return the injected currents with which the largest demanded one, over what is allowed (A), is smallest.

    What is demanded of a bearing is what the feedback asks for and what is injected, i = i_0 + S_i I.
    """
    at = rotor.receptances(Omega)
    if not len(allowed) or (allowed <= 0.0).any():
        return None
    local = at.currents[1] @ rotor.unbalance * Omega**2
    turned = np.linalg.inv(at.currents[2])
    return _smallest(rotor, Omega, turned * allowed, -turned @ local)


def _smallest(rotor: RubbingRotor, Omega: float, turned: Complex, offset: Complex) -> Freeing | None:
    """Return the currents I = turned J + offset that free, of the J whose largest is smallest (2)."""
    at, mu = rotor.receptances(Omega), rotor.mu(Omega)
    r = at.P @ rotor.unbalance * Omega**2 + at.S @ offset
    limits = trap_limits(at.R, mu, rotor.c) * (1.0 - MARGIN)

    def with_share(share: float) -> Complex | None:
        result = _smallest_currents(r, at.S @ turned, share * limits)
        return None if result is None else turned @ result + offset

    best = with_share(1.0)
    if best is not None and _is_free(rotor, Omega, best):
        return _told(rotor, Omega, best, 1.0)
    low, high, result = 0.0, 1.0, None
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        currents = with_share(share)
        if currents is not None and not _is_free(rotor, Omega, currents):
            high = share
        else:
            low = share
            result = result if currents is None else _told(rotor, Omega, currents, share)
    return result


def _is_free(rotor: RubbingRotor, Omega: float, added: Complex) -> bool:
    """Return whether injected currents leave the orbit without contact alone."""
    at, mu = rotor.receptances(Omega), rotor.mu(Omega)
    r = (at.P @ rotor.unbalance * Omega**2 + at.S @ added)[None]
    sets = all_sets(len(rotor.sites))
    free = len(states_of((), at.R, mu, rotor.c, r).points) > 0
    return free and not any(len(states_of(s, at.R, mu, rotor.c, r).points) for s in sets[1:])


def _told(rotor: RubbingRotor, Omega: float, added: Complex, share: float) -> Freeing:
    at, names = rotor.receptances(Omega), rotor.loop(Omega).currents
    demanded = at.currents[1] @ rotor.unbalance * Omega**2 + at.currents[2] @ added
    injected, whole = (dict(zip(names, map(complex, values), strict=True)) for values in (added, demanded))
    return Freeing(injected, whole, share)


def trap_limits(R: Complex, mu: Array, c: Array) -> Array:
    """Return the orbit (m) of each site below which it has no state in contact by itself (1)."""
    rho = np.diagonal(R) * (1.0 + 1j * mu)
    return np.where(rho.real < 0.0, c * np.abs(rho.imag) / np.abs(rho), c)


def _smallest_currents(r: Complex, S: Complex, limits: Array) -> Complex | None:
    """Return the currents of (2) by sequential quadratic programming, scaled; None where there are none."""
    b = S.shape[1]
    start = -np.linalg.lstsq(S, r, rcond=None)[0]
    if (np.abs(r + S @ start) > limits).any():
        return None
    scale = max(float(np.abs(start).max()), 1e-300)
    turned = S * scale

    def split(x: Array) -> Complex:
        return x[:b] + 1j * x[b : 2 * b]

    def slack(x: Array) -> Array:
        added = split(x)
        orbits = 1.0 - np.abs((r + turned @ added) / limits) ** 2
        return np.concatenate([x[-1] ** 2 - np.abs(added) ** 2, orbits, x[-1:]])

    def slopes(x: Array) -> Array:
        added, J = split(x), np.zeros((b + len(r) + 1, 2 * b + 1))
        J[:b, :b], J[:b, b : 2 * b], J[:b, -1] = -2.0 * np.diag(added.real), -2.0 * np.diag(added.imag), 2.0 * x[-1]
        g = -2.0 * ((r + turned @ added).conj() / limits**2)[:, None] * turned
        J[b:-1, :b], J[b:-1, b : 2 * b], J[-1, -1] = g.real, -g.imag, 1.0
        return J

    first = np.concatenate([(start / scale).real, (start / scale).imag, [1.0 + 1e-9]])
    goal = np.zeros(2 * b + 1)
    goal[-1] = 1.0
    result = minimize(
        lambda x: x[-1],
        first,
        jac=lambda _: goal,
        constraints={"type": "ineq", "fun": slack, "jac": slopes},
        method="SLSQP",
        options={"maxiter": 300, "ftol": 1e-12},
    )
    added = split(result.x) * scale
    retained = (np.abs(r + S @ added) <= limits * (1.0 + 10.0 * MARGIN)).all()
    return added if retained and np.abs(added).max() <= np.abs(start).max() * (1.0 + 1e-6) else start
