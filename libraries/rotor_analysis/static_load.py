"""The static load of the bearings: distribution of the weight of a flexible rotor at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from rotor_analysis.assembly import assemble
from rotor_analysis.rotor import Rotor


def carried_masses(rotor: Rotor, springs: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the mass (kg) that each bearing carries with the planes of all other bearings aligned.

    K q = M e + r with q = 0 at the bearings: M e is the weight per unit of gravity, -r the load of the bearings. This
    holds for weight in any lateral direction. A bearing that pulls the rotor down carries a negative mass.

    Parameters
    ----------
    rotor
        The rotor.
    springs
        Stiffness (N/m) of bearings that are springs, without force where the others are aligned: such a bearing gives
        way, and carries k q.

    Raises
    ------
    ValueError
        If the bearings do not support the rotor, such as a single bearing.
    """
    springs = springs or {}
    rigid = [bearing for bearing in rotor.bearings if bearing.name not in springs]
    stiff = [bearing for bearing in rotor.bearings if springs.get(bearing.name, 0.0) > 0.0]
    if len({bearing.node for bearing in (*rigid, *stiff)}) < 2:
        idle = f", {len(springs) - len(stiff)} of them without stiffness" if len(stiff) < len(springs) else ""
        raise ValueError(
            f"rotor {rotor.name!r} has {len(rotor.bearings)} bearings{idle}; its weight requires two or more, at "
            "different nodes"
        )
    nodes = [bearing.node for bearing in rigid]
    carried = carried_at(rotor, nodes, [(bearing.node, springs[bearing.name]) for bearing in stiff])
    masses = dict(zip((bearing.name for bearing in (*rigid, *stiff)), carried, strict=True))
    return {bearing.name: masses.get(bearing.name, 0.0) for bearing in rotor.bearings}


def carried_at(rotor: Rotor, nodes: Sequence[int], springs: Sequence[tuple[int, float]] = ()) -> list[float]:
    """Return the mass (kg) that each support, aligned and at `nodes`, and each spring, at a node (N/m), carries."""
    model = assemble(rotor)
    K, M = model.K[::2, ::2], model.M[::2, ::2]  # along x: translation and slope of each node
    for node, k in springs:
        K[2 * (node - 1), 2 * (node - 1)] += k
    translation = np.zeros(len(K))
    translation[::2] = 1.0
    weight = M @ translation  # over g
    supported = np.array([2 * (node - 1) for node in nodes])
    free = np.setdiff1d(np.arange(len(K)), supported)
    deflection = np.linalg.solve(K[np.ix_(free, free)], weight[free])  # over g
    carried = weight[supported] - K[np.ix_(supported, free)] @ deflection
    q = np.zeros(len(K))
    q[free] = deflection
    return [*(float(mass) for mass in carried), *(float(k * q[2 * (node - 1)]) for node, k in springs)]
