"""The smallest synchronous control force that frees a trapped rotor.

Currents I that are added to the currents of the controller move the contact-free orbit to r = r_0 + S I. A state with
one site in contact exists only if |r| is at least b (from the discriminant of the quadratic in `synchronous_states`),

    b = c |sin arg rho| if Re rho < 0,   b = c otherwise                                              (1)

so the condition |r_k + S_k I| <= s b_k at all sites, with s = 1, excludes such states. States with several sites in
contact are computed, and s is lowered until no such state exists. Then only the contact-free orbit remains. Of all
currents that satisfy the condition, those with the smallest maximum are the solution of a convex problem:

    minimise t,  |I_b| <= t,  |r_k + S_k I| <= s b_k                                                  (2)

Condition (2) is stricter than necessary: a state with one site in contact also does not exist if the rotor would
penetrate another site. Moreover, the orbits at different sites need not shrink by the same factor. The currents that
leave no state in contact do not form a convex set. The solution of (2) belongs to this set. A search starts from this
solution and tries directions I/t in which such currents may be smaller. It first tries all directions, and then
directions ever closer to the best direction. The result leaves no state in contact, and is the smallest that the search
finds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import clarabel
import numpy as np
from scipy.sparse import csc_matrix

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.synchronous_states import all_sets, states_of
from array_types import Array, Bools

HALVINGS = 8  # width of the interval of s
MARGIN = 1e-6  # relative margin of orbits to the limit
ABOUT = 1000  # points about the smallest orbits that are tried
DIRECTIONS = 150  # of a search, at a width
LEVELS = np.array([0.5, 0.8, 0.95, 0.99, 0.999])  # sizes that are tried, over the best
WIDTHS = tuple(0.5 ** np.arange(1, 12))  # of directions about the best
STEPS = 6  # in which the size shrinks, at a width


@dataclass(frozen=True, eq=False)
class Freeing:
    """Currents that exclude all states in contact.

    injected
        Complex current added at each bearing, in the rotating frame (A).
    demanded
        Total demanded current at each bearing, including feedback, during contact-free rotation (A).
    """

    injected: dict[str, complex]
    demanded: dict[str, complex]

    @property
    def largest(self) -> Annotated[float, "A"]:
        """Largest amplitude of an injected current (A)."""
        return max((abs(value) for value in self.injected.values()), default=0.0)


def smallest_freeing(rotor: RubbingRotor, Omega: float) -> Freeing | None:
    """Return the smallest injected currents that free a rotor at a speed (rad/s); None if there are none.

    The currents are zero if the rotor has a stable contact-free orbit and no state in contact.
    """
    n = len(rotor.loop(Omega).currents)
    if _is_free(rotor, Omega, np.zeros(n, dtype=complex)):
        return _freeing(rotor, Omega, np.zeros(n, dtype=complex))
    return _smallest(rotor, Omega, np.eye(n, dtype=complex), np.zeros(n, dtype=complex)) if n else None


def smallest_demand(rotor: RubbingRotor, Omega: float, allowed: Array) -> Freeing | None:
    """Return the freeing currents (A) with the smallest maximum ratio of demanded to allowed current.

    The demanded current is the sum of the feedback current and the injected current, i = i_0 + S_i I.
    """
    at = rotor.receptances(Omega)
    if not len(allowed) or (allowed <= 0.0).any():
        return None
    i_0 = at.currents[1] @ rotor.unbalance * Omega**2
    S_i_inverse = np.linalg.inv(at.currents[2])
    return _smallest(rotor, Omega, S_i_inverse * allowed, -S_i_inverse @ i_0)


def _smallest(rotor: RubbingRotor, Omega: float, basis: Complex, offset: Complex) -> Freeing | None:
    """Return the freeing currents I = basis J + offset with the smallest maximum component of J, found from (2)."""

    def are_free(J: Complex) -> Bools:
        return _are_free(rotor, Omega, J @ basis.T + offset)

    start = _sufficient(rotor, Omega, basis, offset)
    if start is None:
        start = _any_free(rotor, Omega, basis, offset, are_free)
    if start is None:
        return None
    best = _searched(start, are_free)
    return _freeing(rotor, Omega, basis @ best + offset)


def _any_free(
    rotor: RubbingRotor, Omega: float, basis: Complex, offset: Complex, are_free: Callable[[Complex], Bools]
) -> Complex | None:
    """Return a J that frees the rotor, near the J with the smallest orbits; None if no such J is found.

    This J is needed if (2) has no solution, as may happen with more sites than magnets.
    """
    at = rotor.receptances(Omega)
    r = at.P @ rotor.unbalance * Omega**2 + at.S @ offset
    centre = np.linalg.lstsq(at.S @ basis / rotor.c[:, None], -r / rotor.c, rcond=None)[0]
    random = np.random.default_rng(0)
    spread = random.normal(size=(ABOUT, len(centre))) + 1j * random.normal(size=(ABOUT, len(centre)))
    tried = np.concatenate([centre[None], centre + np.abs(centre).max() * spread * random.random((ABOUT, 1))])
    free = tried[are_free(tried)]
    return np.asarray(free[np.abs(free).max(axis=1).argmin()]) if len(free) else None


def _sufficient(rotor: RubbingRotor, Omega: float, basis: Complex, offset: Complex) -> Complex | None:
    """Return the J of (2) with the largest s at which it frees the rotor; None if no such s is found."""
    at, mu = rotor.receptances(Omega), rotor.mu(Omega)
    r = at.P @ rotor.unbalance * Omega**2 + at.S @ offset
    limits = trap_limits(at.R, mu, rotor.c) * (1.0 - MARGIN)

    def with_share(share: float) -> Complex | None:
        return _smallest_currents(r, at.S @ basis, share * limits)

    best = with_share(1.0)
    if best is not None and _is_free(rotor, Omega, basis @ best + offset):
        return best
    low, high, result = 0.0, 1.0, None
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        found = with_share(share)
        if found is not None and not _is_free(rotor, Omega, basis @ found + offset):
            high = share
        else:
            low, result = share, result if found is None else found
    return result


def _searched(start: Complex, are_free: Callable[[Complex], Bools]) -> Complex:
    """Return the point with the smallest maximum component that a search finds among the free points.

    Parameters
    ----------
    start
        A free point, shape (n,).
    are_free
        Function that returns which of the given points, shape (k, n), are free.
    """
    if not start.any():
        return start
    n, best, random = len(start), start, np.random.default_rng(0)
    for width in (np.inf, *WIDTHS):
        directions = random.normal(size=(DIRECTIONS, n)) + 1j * random.normal(size=(DIRECTIONS, n))
        if np.isfinite(width):
            directions = best / np.abs(best).max() + width * directions
        alike = random.random((DIRECTIONS, 1)) < 0.5  # the maximum component is often that of all
        directions = np.where(alike, directions / np.abs(directions), directions)
        directions /= np.abs(directions).max(axis=1, keepdims=True)
        for _ in range(STEPS):
            size, shorter = float(np.abs(best).max()), None
            for level in LEVELS:
                free = are_free(level * size * directions)
                if free.any():
                    shorter = level * size * directions[int(np.argmax(free))]
                    break
            if shorter is None:
                break
            best = shorter
    return np.asarray(best)


def _is_free(rotor: RubbingRotor, Omega: float, added: Complex) -> bool:
    """Return whether the contact-free orbit is the only state with the given injected currents."""
    return bool(_are_free(rotor, Omega, added[None])[0])


def _are_free(rotor: RubbingRotor, Omega: float, added: Complex) -> Bools:
    """Return whether the contact-free orbit is the only state, for each set of injected currents, shape (n, bearings).

    Larger sets of sites are tried last, and only with the remaining currents, because their states take longer to
    compute.
    """
    at, mu, c = rotor.receptances(Omega), rotor.mu(Omega), rotor.c
    r = at.P @ rotor.unbalance * Omega**2 + added @ at.S.T
    left = np.flatnonzero((np.abs(r) < c).all(axis=1))
    for contact in all_sets(len(rotor.sites))[1:]:
        occupied = states_of(contact, at.R, mu, c, r[left]).points
        left = np.delete(left, np.unique(occupied))
    result = np.zeros(len(added), dtype=bool)
    result[left] = True
    return result


def _freeing(rotor: RubbingRotor, Omega: float, added: Complex) -> Freeing:
    at, names = rotor.receptances(Omega), rotor.loop(Omega).currents
    demanded = at.currents[1] @ rotor.unbalance * Omega**2 + at.currents[2] @ added
    injected, total = (dict(zip(names, map(complex, values), strict=True)) for values in (added, demanded))
    return Freeing(injected, total)


def trap_limits(R: Complex, mu: Array, c: Array) -> Array:
    """Return, for each site, the orbit (m) below which no state has only this site in contact (1)."""
    rho = np.diagonal(R) * (1.0 + 1j * mu)
    return np.where(rho.real < 0.0, c * np.abs(rho.imag) / np.abs(rho), c)


def _smallest_currents(r: Complex, S: Complex, limits: Array) -> Complex | None:
    """Return the currents that solve (2), which is a second-order cone problem; None if it is infeasible.

    Currents are scaled by the currents that cancel the orbit, and orbits by their limits.
    """
    if (np.abs(r) <= limits).all():
        return np.zeros(S.shape[1], dtype=complex)
    if not (limits > 0.0).all():
        return None
    unit = max(float(np.abs(np.linalg.lstsq(S, r, rcond=None)[0]).max()), 1e-300)
    n, S = S.shape[1], S * unit / limits[:, None]
    A, a = np.concatenate([np.eye(n), S]), np.concatenate([np.zeros(n), r / limits])
    # each cone: a limit, and real and imaginary part of a current or an orbit; x: those of all currents, and t
    of_x, size = np.zeros((len(A), 3, 2 * n + 1)), np.zeros((len(A), 3))
    of_x[:, 1, :n], of_x[:, 1, n:-1], of_x[:, 2, :n], of_x[:, 2, n:-1] = A.real, -A.imag, A.imag, A.real
    of_x[:n, 0, -1] = 1.0
    size[n:, 0], size[:, 1], size[:, 2] = 1.0, a.real, a.imag
    cones = [clarabel.SecondOrderConeT(3)] * len(A)
    largest = np.append(np.zeros(2 * n), 1.0)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    nothing, rows = csc_matrix((2 * n + 1, 2 * n + 1)), csc_matrix(-of_x.reshape(-1, 2 * n + 1))
    solution = clarabel.DefaultSolver(nothing, largest, rows, size.ravel(), cones, settings).solve()
    if solution.status != clarabel.SolverStatus.Solved:
        return None
    x = np.array(solution.x)
    return unit * np.asarray(x[:n] + 1j * x[n:-1])
