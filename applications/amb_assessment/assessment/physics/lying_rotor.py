"""The retainers on which an unpowered rotor lies or in which it can whirl, and the mass that each retainer carries."""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from amb_assessment.assessment.physics.assessed_machine import AssessedMachine
from amb_cosim.results.component_names import PLANT
from array_types import Array, Complex
from rotor_analysis.static_load import carried_at

ROUNDING = 1e-9  # of a clearance, by which retainers on a line may differ from it
SIDES = 16  # to which a rotor without gravity across its shaft may lean


class LyingOn(NamedTuple):
    """One or two retainers in which a falling rotor can whirl.

    at, mass
        Indices of the retainers among the machine's retainers, and the mass (kg) that each carries.
    height
        Distance that the carried mass falls from its levitated position to its lowest point, divided by the distance
        that it would fall from the retainers' centres.
    """

    at: list[int]
    mass: Array
    height: float


def clearances(subject: AssessedMachine) -> Array:
    """Return the radial clearances of a machine's retainers (m)."""
    return np.array([subject.parameters[PLANT][f"{site}.clearance"] for site in subject.retainers])


def carried_masses(subject: AssessedMachine) -> dict[str, float]:
    """Return the largest mass (kg) that each retainer carries when the rotor lies; 0 for an unreachable retainer."""
    result = dict.fromkeys(subject.retainers, 0.0)
    for lying in lying_on(subject) if result else ():
        for k, mass in zip(lying.at, lying.mass.tolist(), strict=True):
            result[subject.retainers[k]] = max(mass, result[subject.retainers[k]])
    return result


def lying_on(subject: AssessedMachine) -> list[LyingOn]:
    """Return all sets of one or two retainers in which a falling rotor can whirl.

    A rotor lies on two retainers if each carries a share by the lever rule, and if the line through both journals at
    their lowest points reaches no other retainer. If no pair meets this condition, for example because the centre of
    mass is beyond the retainers, every pair counts. If the rotor whirls in a single retainer, this retainer carries the
    smallest of its shares in the pairs, or the whole mass if there are no pairs. Without gravity across the shaft, the
    journals may lean to any side.
    """
    c, p = clearances(subject), subject.parameters[PLANT]
    offset = np.array([complex(*(p[f"{site}.offset_{axis}"] for axis in "xy")) for site in subject.retainers])
    down = complex(np.sign(subject.gravity_across) * np.exp(1j * p["gravity_angle"]))
    sinks = (offset * down.conjugate()).real
    return [
        LyingOn(at, mass, 1.0 + float(sinks[at] @ mass / (c[at] @ mass)))
        for at, mass in _sets(subject, c, offset, down)
    ]


def _sets(subject: AssessedMachine, c: Array, offset: Complex, down: complex) -> list[tuple[list[int], Array]]:
    """Return the retainer indices and the masses of each set in `lying_on`.

    Parameters
    ----------
    subject, c, offset, down
        The machine; the clearances (m) and the centres x + i y (m) of its retainers, each of shape (n,); and the
        direction of gravity, which is 0 without gravity across the shaft.
    """
    node_of = {site.name: site.node for site in subject.rotor.sites}
    nodes = [node_of[site] for site in subject.retainers]
    z, pairs = subject.z[np.array(nodes) - 1], list[tuple[list[int], Array]]()
    for i, j in combinations(range(len(c)), 2):
        if nodes[i] != nodes[j]:
            pairs.append(([i, j], np.array(carried_at(subject.rotor, [nodes[i], nodes[j]]))))
    if not pairs:
        return [([k], np.array([subject.rotor.mass])) for k in range(len(c))]
    sides = np.array([down]) if down else np.exp(2j * np.pi * np.arange(SIDES) / SIDES)
    lowest = offset + np.outer(sides, c)

    def lies(at: list[int], mass: Array) -> bool:
        i, j = at
        along = lowest[:, [i]] + (lowest[:, [j]] - lowest[:, [i]]) * (z - z[i]) / (z[j] - z[i])
        within = np.abs(along - offset) <= c * (1.0 + ROUNDING)
        return bool(mass.min() > 0.0 and within.all(axis=1).any())

    pairs = [pair for pair in pairs if lies(*pair)] or pairs
    shares: dict[int, float] = {}
    for at, mass in pairs:
        for k, share in zip(at, mass.tolist(), strict=True):
            if share > 0.0:
                shares[k] = min(share, shares.get(k, share))
    return [*(([k], np.array([share])) for k, share in sorted(shares.items())), *pairs]
