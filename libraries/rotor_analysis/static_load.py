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
        If the bearings do not support the rotor, for example a single one.
    """
    nodes = rotor.bearing_nodes
    if len(set(nodes)) < 2:
        raise ValueError(
            f"rotor {rotor.name!r} has {len(nodes)} bearings; its weight requires two or more, at a distance"
        )
    return dict(zip((bearing.name for bearing in rotor.bearings), carried_at(rotor, nodes), strict=True))


def carried_at(rotor: Rotor, nodes: Sequence[int]) -> list[float]:
    """Return the mass (kg) that a rotor on supports at two or more nodes, in line, has at each of them."""
    model = assemble(rotor)
    K, M = model.K[::2, ::2], model.M[::2, ::2]  # along x: translation and slope of each node
    along = np.zeros(len(K))
    along[::2] = 1.0
    weight = M @ along
    held = np.array([2 * (node - 1) for node in nodes])
    free = np.setdiff1d(np.arange(len(K)), held)
    deflection = np.linalg.solve(K[np.ix_(free, free)], weight[free])
    carried = weight[held] - K[np.ix_(held, free)] @ deflection
    return [float(mass) for mass in carried]
