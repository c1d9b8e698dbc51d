"""Forward whirl in contact at a natural frequency near the spin, which lasts long if damping is small.

Without unbalance, and with journals side by side or opposite each other, p_j = 1 or -1, the contact forces are

    N_j + i L_j = -p_j sum_k E_jk(omega) c_k p_k,     E = R(omega)^-1                                 (1)

at any omega for which all N_j > 0. They grow as omega approaches a natural frequency of the rotor pinned at these
sites. L_j is the tangential force that damping requires. Only unbalance supplies it, so omega falls, over many turns if
L is small compared with N. With friction, L_j + mu N_j is required.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Annotated

import numpy as np

from amb_analysis.steady_contact.forward_loop import Complex
from amb_analysis.steady_contact.receptances import receptances_at
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from array_types import Array

NEAR, POINTS = (0.5, 2.0), 600  # searched frequencies, over the speed
MAX_FORCE_RATIO = 0.1  # largest force that damping and friction may require, over N


@dataclass(frozen=True, eq=False)
class ContactWhirl:
    """A whirl of one set of sites, over a range of contact forces.

    contact, signs
        Sites, and p of each.
    frequencies
        Lowest and highest whirl frequency (rad/s).
    N
        Normal forces (N) at these two frequencies, by site.
    """

    contact: tuple[str, ...]
    signs: tuple[int, ...]
    frequencies: Annotated[tuple[float, float], "rad/s"]
    N: Annotated[dict[str, tuple[float, float]], "N"]


def contact_whirls(rotor: RubbingRotor, Omega: float) -> list[ContactWhirl]:
    """Return the long-lasting whirls (1) of single sites and of pairs near a spin speed (rad/s)."""
    frequencies = np.linspace(*NEAR, POINTS) * Omega
    mu = np.array([rotor.mu(Omega, float(omega)) for omega in frequencies])
    R = np.array([receptances_at(rotor.loop(Omega), float(omega)).R for omega in frequencies])
    result = []
    for size in (1, 2):
        for contact, others in product(combinations(range(len(rotor.sites)), size), product((1, -1), repeat=size - 1)):
            at, signs = list(contact), (1, *others)
            forces, q = pressed(R, contact, signs, rotor.c)
            apart = [k for k in range(len(rotor.c)) if k not in contact]
            required = np.abs(forces.imag + mu[:, at] * forces.real)
            valid = (forces.real > 0.0) & (required < MAX_FORCE_RATIO * forces.real)
            lasts = valid.all(axis=1) & (np.abs(q[:, apart]) < rotor.c[apart]).all(axis=1)
            ends = np.flatnonzero(np.diff(np.concatenate([[False], lasts, [False]]).astype(int)))
            for first, last in zip(ends[::2], ends[1::2] - 1, strict=True):
                names = tuple(rotor.sites[k] for k in contact)
                N = {s: (float(forces[first, k].real), float(forces[last, k].real)) for k, s in enumerate(names)}
                result.append(ContactWhirl(names, signs, (float(frequencies[first]), float(frequencies[last])), N))
    return result


def pressed(R: Complex, contact: Sequence[int], signs: Sequence[int], c: Array) -> tuple[Complex, Complex]:
    """Return N + i L (N) of the sites in contact, shape (n, m), and the motion of all (m), from receptances (n, all,
    all)."""
    at, p = list(contact), np.array(signs, dtype=float)
    E = np.linalg.inv(R[:, at][:, :, at])
    force = E @ (c[at] * p)
    return -p * force, np.einsum("njk,nk->nj", R[:, :, at], force)
