"""Rolling: backward whirl of journals without slip, and the friction that rolling requires.

    omega = -Omega R_s/c,    N_j (1 + i t_j) = -conj(p_j) sum_k E_jk c_k p_k,    |t_j| <= mu_j        (1)

where E = R(omega)^-1 for the rolling sites, p_j = exp(i psi_j), and there is no unbalance. Only sites with equal R_s/c
roll together. The angle between two such sites is then arbitrary. Therefore N_j (1 + i t_j) lies on a circle, and the
distance of the journal from the centre of another site s is bounded:

    |N_j (1 + i t_j) - a_j| = b_j,    a_j = -c_j E_jj,    b_j = c_k |E_jk|                           (2)
    max |t_j| = max |tan(arg a_j +- arcsin(b_j/|a_j|))|,    max |q_s| = sum_k |(R_s E)_k| c_k        (3)

The equations do not determine whether a rotor reaches this state. A disturbance may lead to rolling, because friction
accelerates a backward whirl that is faster than the unstable whirls of `whirl`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.rubbing_rotor import RubbingRotor
from amb_analysis.steady_contact.synchronous_states import all_sets
from amb_cosim.presentation.json_data import JsonKey
from amb_cosim.presentation.units import force_unit, speed_unit
from rotor_contact.contact.friction import friction_excess

SAME = 1e-9  # largest relative difference of R_s/c of sites that roll together


@dataclass(frozen=True, eq=False)
class Rolling:
    """Rolling without slip at sites, after a disturbance that makes the journals whirl backward fast enough.

    contact, frequency
        One or two sites, and the whirl frequency (rad/s), which is negative.
    N, swing
        Normal force at each site (N): its mean over the angle between the sites, and its largest deviation from the
        mean.
    friction
        Smallest friction coefficient that prevents slip at all sites and angles.
    possible, accurate
        Whether all these sites have at least this friction, and whether the reduced rotor is accurate at this
        frequency.
    """

    contact: tuple[str, ...]
    frequency: Annotated[float, "rad/s"]
    N: Annotated[dict[str, float], JsonKey("normal_forces_N")]
    swing: Annotated[dict[str, float], JsonKey("swings_N")]
    friction: Annotated[float, JsonKey("least_friction")]
    possible: bool
    accurate: bool

    def __str__(self) -> str:
        forces = ", ".join(f"{site} {force_unit(force).text(force)}" for site, force in self.N.items())
        beyond = "" if self.accurate else "; the reduced rotor is not accurate at this frequency"
        at = speed_unit().text(self.frequency)
        return (
            f"the rotor may roll on {'+'.join(self.contact)} at {at} ({forces}), which requires a friction "
            f"coefficient of {self.friction:.2g}{beyond}"
        )


def rolling(rotor: RubbingRotor, Omega: float) -> list[Rolling]:
    """Return the rolling states (1) of single sites and of pairs at a spin speed (rad/s), whatever their friction."""
    ratio = np.array([site.journal_radius for site in rotor.records]) / rotor.c
    result = []
    for contact in all_sets(len(rotor.sites), 2)[1:]:
        at, others = list(contact), [k for k in range(len(rotor.sites)) if k not in contact]
        if np.ptp(ratio[at]) > SAME * ratio[at[0]]:
            continue
        omega = -Omega * float(ratio[at[0]])
        R = receptances(rotor.loop(Omega), omega).R
        E, c = np.linalg.inv(R[np.ix_(at, at)]), rotor.c[at]
        forces = -E * c
        a, b = np.diag(forces), np.abs(forces - np.diag(np.diag(forces))).sum(axis=1)
        reach = np.abs(R[np.ix_(others, at)] @ E) @ c
        if (a.real <= b).any() or (reach >= rotor.c[others]).any():
            continue
        half_angle = np.arcsin(b / np.abs(a))
        slopes = np.abs(np.tan(np.angle(a) + np.outer((1.0, -1.0), half_angle)))
        names = tuple(rotor.sites[k] for k in contact)
        mean, swing = (dict(zip(names, map(float, values), strict=True)) for values in (a.real, b))
        friction = float(slopes.max())
        possible = all(friction_excess(rotor.records[k], 1.0, friction) <= 0.0 for k in contact)
        result.append(Rolling(names, omega, mean, swing, friction, possible, abs(omega) <= rotor.valid_to))
    return result
