"""The least friction coefficient that drives a fall of a machine without power into backward whirl."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from amb_analysis.linear.linear_source import source_of_run
from amb_analysis.steady_contact.swing import MOST, least_swinging_friction, whirl_forces
from amb_analysis.steady_contact.unpowered import relative_receptances
from amb_assessment.assessment.findings import Quantity
from amb_assessment.assessment.stages import co_simulated
from amb_assessment.assessment.subject import Subject, rpm
from amb_cosim.results.component_names import PLANT
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from amb_cosim.scenario.plan_run import plan_run
from array_types import Array
from rotor_analysis.refinement import refined
from rotor_analysis.static_load import carried_at

SPEEDS = 5  # from standstill to the trip speed, before refinement about minima
ROUNDING = 1e-9  # of a clearance, by which retainers on a line may differ from it
MARGIN = 2.0  # of this friction over that of landings, as in the criteria; above it no landing whirls by chance


def whirl_friction(subject: Subject, friction: float) -> Quantity:
    """Return the least friction coefficient (`swing`) of any one or two retainers at any speed up to the trip speed.

    Parameters
    ----------
    subject
        The machine, with seals and stages.
    friction
        Largest friction coefficient of its landings, for criteria.
    """
    highest = subject.file.speed.tripping
    linear_source = source_of_run(plan_run(co_simulated(subject, subject.file.speed.highest)))
    c = np.array([subject.parameters[PLANT][f"{site}.clearance"] for site in subject.retainers])
    across = abs(subject.parameters[PLANT]["gravity"])
    g = across or STANDARD_GRAVITY
    sets, masses = zip(*_lying(subject, c), strict=True)

    def least(Omega: float) -> list[float]:
        relative = relative_receptances(linear_source, Omega, subject.retainers)
        weights = [across * float(c[at] @ mass / c[at].mean()) for at, mass in zip(sets, masses, strict=True)]
        forces = [whirl_forces(relative, at, c[at], g) for at in sets]
        return [least_swinging_friction(F, W, g) for F, W in zip(forces, weights, strict=True)]

    speeds, values = refined(
        lambda speeds: np.array([least(float(Omega)) for Omega in speeds]),
        np.linspace(0.0, highest, SPEEDS),
        lambda values: -values,
        resonant=False,
    )
    n, k = np.unravel_index(int(values.argmin()), values.shape)
    value, where = float(values[n, k]), " and ".join(subject.retainers[j] for j in sets[k])
    usual = "rigid retainers without damping have 0.237, and less with a strong gyroscopic effect"
    note = f"no whirl up to {MOST:g}" if value >= MOST else usual
    return Quantity("whirl_friction", f"{where}, {rpm(speeds[n]):.0f} 1/min", value, "1", {"friction": friction}, note)


def chance(least: Quantity) -> str:
    """Return why chance decides whether a landing whirls; empty if the friction is too small for a whirl."""
    friction = least.facts["friction"]
    if least.value >= MARGIN * friction:
        return ""
    return (
        f"friction of {friction:g} is more than half of the {least.value:.3g} that drives a fall into backward whirl, "
        "so that chance decides on each landing"
    )


def whirl_facts(least: Quantity) -> dict[str, float]:
    """Return the variables of criteria on landings: `whirl_friction`, and the largest friction of the landings."""
    return {"whirl_friction": least.value, **least.facts}


def _lying(subject: Subject, c: Array) -> list[tuple[list[int], Array]]:
    """Return the retainers, one or two, in which a fall can whirl, by number, and the mass (kg) that each carries.

    Two are those on which a rotor lies: each carries a share by the rule of the lever, and the line through both
    journals reaches no other retainer. If there are none, as with a centre of mass beyond the retainers, any two count.
    One carries the least of its shares, or all of the mass if it has no other.

    Parameters
    ----------
    subject, c
        The machine, and the clearances (m) of its retainers, shape (n,).
    """
    node_of = {site.name: site.node for site in subject.rotor.sites}
    nodes = [node_of[site] for site in subject.retainers]
    z, pairs = subject.z[np.array(nodes) - 1], list[tuple[list[int], Array]]()
    for i, j in combinations(range(len(c)), 2):
        if nodes[i] != nodes[j]:
            pairs.append(([i, j], np.array(carried_at(subject.rotor, [nodes[i], nodes[j]]))))
    if not pairs:
        return [([k], np.array([subject.rotor.mass])) for k in range(len(c))]

    def is_reached(at: list[int], mass: Array) -> bool:
        i, j = at
        along = c[i] + (c[j] - c[i]) * (z - z[i]) / (z[j] - z[i])
        return bool(mass.min() > 0.0 and np.all(np.abs(along) <= c * (1.0 + ROUNDING)))

    pairs = [pair for pair in pairs if is_reached(*pair)] or pairs
    shares: dict[int, float] = {}
    for at, mass in pairs:
        for k, share in zip(at, mass.tolist(), strict=True):
            if share > 0.0:
                shares[k] = min(share, shares.get(k, share))
    return [*(([k], np.array([share])) for k, share in sorted(shares.items())), *pairs]
