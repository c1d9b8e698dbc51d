"""Forward whirl in contact at a natural frequency near the spin speed; such a whirl lasts long if damping is small.

Without unbalance, and with journals on the same side (p_j = 1) or on opposite sides (p_j = -1), the contact forces are

    N_j + i L_j = -p_j sum_k E_jk(omega) c_k p_k,     E = R(omega)^-1                                 (1)

at any omega for which all N_j > 0. The forces grow as omega approaches a natural frequency of the rotor when it is
pinned at these sites. L_j is the tangential force that damping requires. Only unbalance supplies this force. Without
unbalance, omega falls, but it falls slowly if L is small compared with N. With friction, L_j + mu N_j is required.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import combinations
from typing import Annotated

import numpy as np
from scipy.optimize import brentq

from amb_analysis.steady_contact.forward_loop import Complex, ForwardLoop
from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from array_types import Array
from rotor_analysis.refinement import refined

NEAR, POINTS = (0.5, 2.0), 600  # range of searched frequencies over the speed, and their number before refinement
ABOUT = np.outer((-1.0, 1.0), 0.5 ** np.arange(20)).ravel()  # distances from a change of sign, over the spacing
JUMP, SAME = 1e-3, 1e-9  # smallest jump of the margin, and relative distance of the frequencies across it
MAX_FORCE_RATIO = 0.1  # largest force that damping and friction may require, over N


@dataclass(frozen=True, eq=False)
class ContactWhirl:
    """A whirl with one set of sites in contact, over a range of contact forces.

    contact, signs
        The sites in contact, and p of each of them.
    frequencies
        Lowest and highest whirl frequency (rad/s).
    N
        Normal forces (N) at these two frequencies, by site; an unbounded force is None.
    """

    contact: tuple[str, ...]
    signs: tuple[int, ...]
    frequencies: Annotated[tuple[float, float], "rad/s"]
    N: Annotated[dict[str, tuple[float | None, float | None]], "N"]


def contact_whirls(rotor: RubbingRotor, Omega: float) -> list[ContactWhirl]:
    """Return the long-lasting whirls (1) near a spin speed (rad/s), with one or two sites in contact.

    A whirl lasts at frequencies at which its margin is positive. The margin is the minimum, over the sites j in contact
    and the other sites k, of

        (N_j/10 - |L_j + mu_j N_j|)/|N_j + i L_j|,    1 - |q_k|/c_k                               (2)

    The maxima of the margin as a function of frequency are refined. A whirl ends at zeros of the margin.
    """
    search = _Search(rotor, rotor.loop(Omega), rotor.mu(Omega))
    first = search.about_changes_of_sign(np.linspace(*NEAR, POINTS) * Omega)
    frequencies, margins = refined(search.margins, first, lambda margins: margins, resonant=False)
    result = []
    for number, (contact, signs) in enumerate(search.sets):
        lasts = np.concatenate([[False], margins[:, number] > 0.0, [False]])
        ends = np.flatnonzero(np.diff(lasts.astype(int)))
        for k, after in zip(ends[::2], ends[1::2], strict=True):
            slow, fast = search.end(number, frequencies[: k + 1][::-1]), search.end(number, frequencies[after - 1 :])
            N = {rotor.sites[site]: (slow[1][j], fast[1][j]) for j, site in enumerate(contact)}
            result.append(ContactWhirl(tuple(N), signs, (slow[0], fast[0]), N))
    return result


@dataclass(frozen=True, eq=False)
class _Search:
    """Forces and margins as functions of frequency, for all sets of sites in contact and all their signs p."""

    rotor: RubbingRotor
    loop: ForwardLoop
    mu: Array
    _receptances: dict[float, Complex] = field(default_factory=dict)

    @cached_property
    def sets(self) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
        """For each set, the sites in contact and the sign p of each of these sites."""
        sites = range(len(self.rotor.sites))
        singles: list[tuple[tuple[int, ...], tuple[int, ...]]] = [((site,), (1,)) for site in sites]
        return [*singles, *((pair, (1, sign)) for pair in combinations(sites, 2) for sign in (1, -1))]

    def receptances(self, frequencies: Array) -> Complex:
        """Return the receptances at frequencies (rad/s), shape (n, n_sites, n_sites)."""
        for omega in map(float, frequencies):
            if omega not in self._receptances:
                self._receptances[omega] = receptances(self.loop, omega).R
        return np.array([self._receptances[float(omega)] for omega in frequencies])

    def forces(self, number: int, frequencies: Array) -> Array:
        """Return the normal forces (N) of a set at frequencies (rad/s), shape (n, m)."""
        return np.asarray(contact_forces(self.receptances(frequencies), *self.sets[number], self.rotor.c)[0].real)

    def margins(self, frequencies: Array) -> Array:
        """Return the margins (2) of all sets at frequencies (rad/s), shape (n, sets)."""
        R, c = self.receptances(frequencies), self.rotor.c
        result = []
        for contact, signs in self.sets:
            F, q = contact_forces(R, contact, signs, c)
            apart = [k for k in range(len(c)) if k not in contact]
            force_margins = (MAX_FORCE_RATIO * F.real - np.abs(F.imag + self.mu[list(contact)] * F.real)) / np.abs(F)
            result.append(np.concatenate([force_margins, 1.0 - np.abs(q[:, apart]) / c[apart]], axis=1).min(axis=1))
        return np.stack(result, axis=1)

    def about_changes_of_sign(self, grid: Array) -> Array:
        """Return frequencies, denser where a force changes sign, so that whirls over a narrow range are found there."""
        about = [grid]
        for number in range(len(self.sets)):
            forces = self.forces(number, grid)
            for n, site in np.argwhere(forces[:-1] * forces[1:] < 0.0):
                at = brentq(partial(self._force, number, int(site)), grid[n], grid[n + 1])
                about.append(at + (grid[n + 1] - grid[n]) * ABOUT)
        result = np.unique(np.concatenate(about))
        return np.asarray(result[(result >= grid[0]) & (result <= grid[-1])])

    def end(self, number: int, outward: Array) -> tuple[float, list[float | None]]:
        """Return the frequency at which a whirl ends, and the forces there (N).

        The end is between the first two frequencies or, if there is only one frequency, at this frequency.

        If the margin jumps and the forces grow towards the end, a mode of the pinned rotor has no damping, so the
        forces are unbounded.
        """
        if len(outward) == 1:
            return float(outward[0]), [float(N) for N in self.forces(number, outward)[0]]
        margin = partial(self._margin, number)
        omega = float(brentq(margin, outward[0], outward[1], xtol=1e-12, rtol=1e-12))
        inwards = SAME * float(np.sign(outward[0] - outward[1]))
        near, farther, outside = omega * (1.0 + inwards * np.array([1.0, 2.0, -1.0]))
        largest_forces = self.forces(number, np.array([near, farther])).max(axis=1)
        bounded = margin(near) - margin(outside) < JUMP or largest_forces[0] <= largest_forces[1]
        at_end = self.forces(number, np.array([omega]))[0]
        return omega, [float(N) if bounded else None for N in at_end]

    def _force(self, number: int, site: int, omega: float) -> float:
        return float(self.forces(number, np.array([omega]))[0, site])

    def _margin(self, number: int, omega: float) -> float:
        return float(self.margins(np.array([omega]))[0, number])


def contact_forces(R: Complex, contact: Sequence[int], signs: Sequence[int], c: Array) -> tuple[Complex, Complex]:
    """Return N + i L (N) at the sites in contact, shape (n, m), and the motion (m) at all sites, from receptances R."""
    at, p = list(contact), np.array(signs, dtype=float)
    E = np.linalg.inv(R[:, at][:, :, at])
    force = E @ (c[at] * p)
    return -p * force, np.einsum("njk,nk->nj", R[:, :, at], force)
