"""Rolling: journals that whirl backward in their rings without slip, and the least friction that this takes.

    omega = -Omega R_s/c,    N_j (1 + i t_j) = -conj(p_j) sum_k E_jk c_k p_k,    |t_j| <= mu_j        (1)

with E = R(omega)^-1 of the sites that roll, p_j = exp(i psi_j), and no unbalance. Only sites with one R_s/c roll
together; the angles between them are then free, since all turn at one speed: N swings about -c_j Re E_jj over them.
Whether a rotor gets there is another matter: friction drives a backward whirl on that is faster than those of `whirl`
which do not last.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Annotated

import numpy as np

from amb_cosim.results.places import PLANT
from amb_cosim.rub.receptances import receptances_at
from amb_cosim.rub.rubbing_rotor import RubbingRotor

ANGLES = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)  # between two sites
SAME = 1e-9  # difference of R_s/c, over it, of sites that roll together


@dataclass(frozen=True, eq=False)
class Rolling:
    """Sites that roll.

    contact
        One site or two.
    frequency
        Whirl frequency (rad/s), negative.
    N, swing
        Normal force at each of them (N), in the mean over the angle between them, and how far it is from that.
    friction
        Least coefficient that keeps all of them from slipping at any such angle.
    """

    contact: tuple[str, ...]
    frequency: Annotated[float, "rad/s"]
    N: Annotated[dict[str, float], "N"]
    swing: Annotated[dict[str, float], "N"]
    friction: float


def rolling(rotor: RubbingRotor, Omega: float) -> list[Rolling]:
    """Return how single sites and pairs can roll (1) at a spin speed (rad/s), whatever their friction is."""
    p = rotor.linear_components.parameters(PLANT)
    ratio = np.array([p[f"{site}.journal_radius"] for site in rotor.sites]) / rotor.c
    result = []
    for contact in [s for size in (1, 2) for s in combinations(range(len(rotor.sites)), size)]:
        at, others = list(contact), [k for k in range(len(rotor.sites)) if k not in contact]
        if np.ptp(ratio[at]) > SAME * ratio[at[0]]:
            continue
        omega = -Omega * float(ratio[at[0]])
        R = receptances_at(rotor.loop(Omega), omega).R
        E, c = np.linalg.inv(R[np.ix_(at, at)]), rotor.c[at]
        p_j = np.stack([np.ones(len(ANGLES), dtype=complex), np.exp(1j * ANGLES)], axis=1)[:, : len(at)]
        force = (p_j * c) @ E.T
        N, q = -p_j.conj() * force, force @ R[np.ix_(others, at)].T
        if (N.real <= 0.0).any() or (np.abs(q) >= rotor.c[others]).any():
            continue
        names, mean = tuple(rotor.sites[k] for k in at), N.real.mean(axis=0)
        swing = np.abs(N.real - mean).max(axis=0)
        forces, swings = (dict(zip(names, map(float, values), strict=True)) for values in (mean, swing))
        result.append(Rolling(names, omega, forces, swings, float(np.abs(N.imag / N.real).max())))
    return result
