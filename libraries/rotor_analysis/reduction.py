"""Reduction of the rotor to other coordinates, and to a few planes by modified static condensation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.pairs import times_turned, turned


@dataclass(frozen=True)
class Reduction:
    """A reduced model and its relation to the full model.

    model
        Matrices in the reduced coordinates: x and y of some planes in order, then the coordinates of the modes.
    right, left
        Full displacement = `right` @ coordinates, reduced force = `left` @ full force. For symmetric K, `left` is the
        transpose of `right`; with cross-coupled bearings, it is not.
    """

    model: Matrices
    right: Array
    left: Array


def msdc(full: Matrices, planes: tuple[int, ...]) -> Reduction:
    """Condense a model to the translations at `planes` (MSDC, thesis 3.8 to 3.13).

    R_D = K_ss^-1 K_sm,  q_s = -R_D q_m;  R_E = K_ms K_ss^-1
    X_R = X_mm - R_E X_sm - X_ms R_D + R_E X_ss R_D  for X = M, C, R, G  (3.12)
    K_R = K_mm - R_E K_sm,  f_R = f_m - R_E f_s                          (3.11, 3.13)

    Parameters
    ----------
    full
        The model to reduce.
    planes
        Node numbers whose translations are retained.

    Raises
    ------
    ValueError
        If a plane has no translations in `full`; if the slaves can move freely with the masters fixed (K_ss singular);
        or if a bearing at another node is anisotropic while some damping rotates.
    """
    return reduce_by(full, _in_turn(planes), *_static(full, planes))


def unreduced(full: Matrices) -> Reduction:
    """Return a `Reduction` that reduces nothing, so that slopes remain among the coordinates."""
    identity = np.eye(full.size)
    return Reduction(full, identity, identity)


def _static(full: Matrices, planes: tuple[int, ...]) -> tuple[Array, Array]:
    """Return `right` and `left` of the static condensation to `planes`."""
    unknown = [node for node in planes if node not in full.translations]
    if unknown:
        raise ValueError(f"planes {unknown} are not in the model; it has nodes {sorted(full.translations)}")
    for item in full.over_speed:
        if item.bearing.node not in planes:
            at = f"node {item.bearing.node} of bearing {item.bearing.name}, whose coefficients depend on speed"
            raise ValueError(f"planes {list(planes)} are not allowed; they must include {at}")
    masters = full.rows(planes)
    slaves = [row for row in range(full.size) if row not in set(masters)]
    K_ss = full.K[np.ix_(slaves, slaves)]
    size = np.sqrt(np.abs(np.diag(K_ss)))
    if slaves and np.linalg.cond(K_ss / np.outer(size, size)) > 1e14:
        raise ValueError(f"planes {list(planes)} do not support the rotor: retain at least two planes of the shaft")
    right = np.zeros((full.size, len(masters)))
    left = np.zeros((len(masters), full.size))
    right[masters] = np.eye(len(masters))
    left[:, masters] = np.eye(len(masters))
    right[slaves] = -np.linalg.solve(K_ss, full.K[np.ix_(slaves, masters)])
    left[:, slaves] = -np.linalg.solve(K_ss.T, full.K[np.ix_(masters, slaves)].T).T
    return right, left


def _in_turn(planes: tuple[int, ...]) -> dict[int, tuple[int, int]]:
    """Return the rows of x and y by plane, for a model in which these rows come first."""
    return {node: (2 * i, 2 * i + 1) for i, node in enumerate(planes)}


def reduce_by(full: Matrices, translations: dict[int, tuple[int, int]], right: Array, left: Array) -> Reduction:
    """Return `full` in other coordinates, with x and y at the planes in the rows `translations`; see `Reduction`.

    Raises
    ------
    ValueError
        If a bearing that is not at a plane is anisotropic while some damping rotates.
    """
    J = turned(full.size)
    rotates = full.R.any() or (full.hysteresis is not None and full.hysteresis.rotating)
    if rotates and not np.allclose(times_turned(right), J @ right, atol=1e-9):
        what = "they must include anisotropic bearings, because the shaft has rotating damping"
        raise ValueError(f"planes {list(translations)} are not allowed; {what}")
    reduced = Matrices(
        M=left @ full.M @ right,
        C=left @ full.C @ right,
        R=left @ full.R @ right,
        G=left @ full.G @ right,
        K=left @ full.K @ right,
        translations=translations,
        over_speed=tuple(replace(item, right=item.right @ right, left=left @ item.left) for item in full.over_speed),
        hysteresis=None if full.hysteresis is None else full.hysteresis.reduced(right, left),
        slopes=_slopes(full, right, left),
    )
    return Reduction(reduced, right, left)


def _slopes(full: Matrices, right: Array, left: Array) -> tuple[Array, Array] | None:
    """Return the maps of all slopes in the coordinates of a reduction; None if the model has no slopes."""
    if full.slopes is not None:
        return full.slopes[0] @ right, left @ full.slopes[1]
    if full.size != 4 * len(full.translations):
        return None
    rows = [row + 2 for row in full.rows(tuple(sorted(full.translations)))]
    return right[rows], left[:, rows]
