"""The static load of the bearings: distribution of the weight of a flexible rotor.

    K q = M e + r,    q = 0 at rigid supports                                                     (1)

M e is the weight along e per unit of gravity, and -r is the load on the supports. K includes springs, which exert no
force while aligned with the supports; a spring that is deflected by q carries k q.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from array_types import Array
from rotor_analysis.assembly import assemble, with_bearings
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor import Rotor


def carried_masses(rotor: Rotor, springs: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the mass (kg) that each bearing carries according to (1), with aligned bearings.

    Seals are omitted; `carried_with_seals` includes them. The result holds for weight in any lateral direction. A
    bearing that pulls the rotor down carries a negative mass.

    Parameters
    ----------
    rotor
        The rotor.
    springs
        Stiffness (N/m), by name, of the bearings that are springs.

    Raises
    ------
    ValueError
        If the bearings do not support the rotor, for example because there is only one bearing.
    """
    springs = springs or {}
    rigid, stiff = _supports(rotor, springs)
    carried = carried_at(rotor, [b.node for b in rigid], [(b.node, springs[b.name]) for b in stiff])
    masses = dict(zip((bearing.name for bearing in (*rigid, *stiff)), carried, strict=True))
    return {bearing.name: masses.get(bearing.name, 0.0) for bearing in rotor.bearings}


def carried_with_seals(rotor: Rotor, springs: Mapping[str, float], Omega: float) -> dict[str, Array]:
    """Return the tensor S (kg), shape (2, 2), of each bearing, whose load is S g under gravity g across the shaft.

    Seals act as springs with their stiffness at a spin speed. Because of their cross-coupled stiffness, the bearings
    also carry loads perpendicular to gravity. Without seals S is the mass of `carried_masses` times the identity.

    Parameters
    ----------
    rotor, springs
        As for `carried_masses`, which raises the same errors.
    Omega
        Spin speed (rad/s).
    """
    if not rotor.seals:
        return {name: mass * np.eye(2) for name, mass in carried_masses(rotor, springs).items()}
    rigid, stiff = _supports(rotor, springs)
    model = assemble(rotor)
    for bearing in stiff:
        model = model.with_bearing(bearing.node, springs[bearing.name] * np.eye(2), np.zeros((2, 2)))
    K = with_bearings(model, rotor.seals).at(Omega).K
    translations = np.zeros((model.size, 2))
    for rows in model.translations.values():
        translations[rows, (0, 1)] = 1.0
    weight = model.M @ translations  # over g; a seal's mass is that of a fluid, without weight
    load, q = _loads(K, weight, model.rows(tuple(b.node for b in rigid)))
    shares = dict(zip((bearing.name for bearing in rigid), load.reshape(-1, 2, 2), strict=True))
    shares |= {b.name: springs[b.name] * q[model.rows((b.node,))] for b in stiff}
    return {bearing.name: shares.get(bearing.name, np.zeros((2, 2))) for bearing in rotor.bearings}


def carried_at(rotor: Rotor, nodes: Sequence[int], springs: Sequence[tuple[int, float]] = ()) -> list[float]:
    """Return the mass (kg) that, by (1), each aligned support at `nodes` and each spring (N/m, by node) carries.

    Seals are omitted.
    """
    model = assemble(rotor)
    K, M = model.K[::2, ::2], model.M[::2, ::2]  # along x: translation and slope of each node
    for node, k in springs:
        K[2 * (node - 1), 2 * (node - 1)] += k
    translation = np.zeros(len(K))
    translation[::2] = 1.0
    carried, q = _loads(K, M @ translation, [2 * (node - 1) for node in nodes])
    return [*(float(mass) for mass in carried), *(float(k * q[2 * (node - 1)]) for node, k in springs)]


def _supports(rotor: Rotor, springs: Mapping[str, float]) -> tuple[list[Bearing], list[Bearing]]:
    """Return the rigid bearings, and the springs with positive stiffness, which together support the rotor."""
    rigid = [bearing for bearing in rotor.bearings if bearing.name not in springs]
    stiff = [bearing for bearing in rotor.bearings if springs.get(bearing.name, 0.0) > 0.0]
    if len({bearing.node for bearing in (*rigid, *stiff)}) < 2:
        idle = f", {len(springs) - len(stiff)} of them without stiffness" if len(stiff) < len(springs) else ""
        bearings = f"{len(rotor.bearings)} bearing{'s' * (len(rotor.bearings) != 1)}"
        raise ValueError(
            f"rotor {rotor.name!r} has {bearings}{idle}; its weight requires two or more bearings, at "
            "different nodes, that can carry load"
        )
    return rigid, stiff


def _loads(K: Array, weight: Array, supported: Sequence[int]) -> tuple[Array, Array]:
    """Return the solution of (1) per unit of gravity: the loads -r of supported rows, and q of all rows."""
    at, free = np.array(supported, dtype=int), np.setdiff1d(np.arange(len(K)), supported)
    q = np.zeros_like(weight)
    q[free] = np.linalg.solve(K[np.ix_(free, free)], weight[free])
    return weight[at] - K[np.ix_(at, free)] @ q[free], q
