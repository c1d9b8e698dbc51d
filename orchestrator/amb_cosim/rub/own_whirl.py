"""Forward whirl of a rotor in contact near its spin, at a frequency of its own: it lasts long where damping is small.

Without unbalance, and with journals side by side or opposite each other, p_j = 1 or -1, the sites press with

    N_j + i L_j = -p_j sum_k E_jk(omega) c_k p_k,     E = R(omega)^-1                                 (1)

at any omega for which all N_j > 0: the harder, the nearer omega is to the own frequency of a rotor that is held at
these sites. L_j is the force along the whirl that damping asks for; nothing but unbalance gives it, so omega falls, in
many turns if L is small beside N. With friction L_j + mu N_j is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Annotated

import numpy as np

from amb_cosim.controllers.laws import Array
from amb_cosim.rub.forward_loop import Complex
from amb_cosim.rub.receptances import receptances_at
from amb_cosim.rub.rubbing_rotor import RubbingRotor

NEAR, POINTS = (0.5, 2.0), 600  # frequencies that are searched, over the speed
MAX_FORCE_RATIO = 0.1  # of N, what damping and friction may ask for


@dataclass(frozen=True, eq=False)
class OwnWhirl:
    """A whirl of one set of sites, from the least pressed to the hardest pressed.

    contact, signs
        Sites, and p of each.
    frequencies
        Lowest and highest whirl frequency (rad/s).
    N
        Normal forces at the first and at the last of them (N), by site.
    """

    contact: tuple[str, ...]
    signs: tuple[int, ...]
    frequencies: Annotated[tuple[float, float], "rad/s"]
    N: Annotated[dict[str, tuple[float, float]], "N"]


def own_whirls(rotor: RubbingRotor, Omega: float) -> list[OwnWhirl]:
    """Return the whirls of single sites and of pairs near a spin speed (rad/s) that last long (1)."""
    frequencies, mu = np.linspace(*NEAR, POINTS) * Omega, rotor.mu(Omega)
    R = np.array([receptances_at(rotor.loop(Omega), float(omega)).R for omega in frequencies])
    result = []
    for size in (1, 2):
        for contact, others in product(combinations(range(len(rotor.sites)), size), product((1, -1), repeat=size - 1)):
            at, signs = list(contact), (1, *others)
            forces, q = pressed(R, contact, signs, rotor.c)
            apart = [k for k in range(len(rotor.c)) if k not in contact]
            valid = (forces.real > 0.0) & (np.abs(forces.imag + mu[at] * forces.real) < MAX_FORCE_RATIO * forces.real)
            lasts = valid.all(axis=1) & (np.abs(q[:, apart]) < rotor.c[apart]).all(axis=1)
            ends = np.flatnonzero(np.diff(np.concatenate([[False], lasts, [False]]).astype(int)))
            for first, last in zip(ends[::2], ends[1::2] - 1, strict=True):
                names = tuple(rotor.sites[k] for k in contact)
                N = {s: (float(forces[first, k].real), float(forces[last, k].real)) for k, s in enumerate(names)}
                result.append(OwnWhirl(names, signs, (float(frequencies[first]), float(frequencies[last])), N))
    return result


def pressed(R: Complex, contact: Sequence[int], signs: Sequence[int], c: Array) -> tuple[Complex, Complex]:
    """Return N + i L (N) of sites in contact, shape (n, m), and the motion of all (m), of receptances (n, all, all)."""
    at, p = list(contact), np.array(signs, dtype=float)
    E = np.linalg.inv(R[:, at][:, :, at])
    force = E @ (c[at] * p)
    return -p * force, np.einsum("njk,nk->nj", R[:, :, at], force)
