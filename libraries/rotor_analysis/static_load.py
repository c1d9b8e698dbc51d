"""The static load of the bearings: distribution of the weight of a flexible rotor at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rotor_analysis.assembly import assemble
from rotor_analysis.rotor import Rotor


def carried_masses(rotor: Rotor) -> dict[str, float]:
    """Return the mass (kg) that each bearing carries with the planes of all bearings aligned.

    K q = M e + r with q = 0 at the bearings: M e is the weight per unit of gravity, -r the load of the bearings. This
    holds for weight in any lateral direction. A bearing that pulls the rotor down carries a negative mass.

    Raises
    ------
    ValueError
        If the bearings do not support the rotor, such as a single bearing.
    """
    nodes = rotor.bearing_nodes
    if len(set(nodes)) < 2:
        raise ValueError(
            f"rotor {rotor.name!r} has {len(nodes)} bearings; its weight requires two or more, at different nodes"
        )
    return dict(zip((bearing.name for bearing in rotor.bearings), carried_at(rotor, nodes), strict=True))


def carried_at(rotor: Rotor, nodes: Sequence[int]) -> list[float]:
    """Return the mass (kg) that each of two or more supports, aligned and at `nodes`, carries."""
    model = assemble(rotor)
    K, M = model.K[::2, ::2], model.M[::2, ::2]  # along x: translation and slope of each node
    translation = np.zeros(len(K))
    translation[::2] = 1.0
    weight = M @ translation  # over g
    supported = np.array([2 * (node - 1) for node in nodes])
    free = np.setdiff1d(np.arange(len(K)), supported)
    deflection = np.linalg.solve(K[np.ix_(free, free)], weight[free])  # over g
    carried = weight[supported] - K[np.ix_(supported, free)] @ deflection
    return [float(mass) for mass in carried]
