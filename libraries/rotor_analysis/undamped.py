"""Natural frequencies and shapes of the undamped rotor at rest, computed from any of its models."""

from __future__ import annotations

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.inertia import inertial
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor import Rotor

# Added to omega^2 (rad^2/s^2): M phi = mu (K + shift M) phi has its largest mu = 1 / (omega^2 + shift) where the lowest
# modes are, and rounding on the scale of a short, stiff or weightless element does not touch them.
SHIFTS = (1e4, 1e6, 1e8, 1e10)


def undamped_modes(supported: Matrices, rotor: Rotor, count: int) -> tuple[Array, Array]:
    """Return the first modes, K phi = omega^2 M phi, of a rotor on its bearings.

    K and M are the means over both planes. With fewer than two bearings or seals, one or two of these modes are rigid
    motions; they have no frequency and are omitted.

    Parameters
    ----------
    supported
        The rotor on its bearings and seals, full or reduced.
    rotor
        Description of the rotor.
    count
        Number of modes, including rigid motions; fewer if the model has fewer.

    Returns
    -------
    frequencies
        Natural frequencies omega (rad/s), ascending, shape (n,). A negative value means that the motion diverges as
        exp(-omega t).
    shapes
        Mode shapes phi over the x coordinates, in columns, with phi^T M phi = 1.
    """
    at_rest = supported.at(0.0)
    supports = (*rotor.bearings, *rotor.seals)
    supported_nodes = {bearing.node for bearing in supports if np.trace(bearing.at(0.0)[0]) != 0.0}
    tilts = any(np.trace(tilting.at(0.0)[0]) != 0.0 for tilting in _tilting(rotor))
    rigid = max(0, 2 - len(supported_nodes) - tilts)
    return _lowest(_plane_of(at_rest.M), _plane_of(at_rest.K), count, rigid, rotor)


def _tilting(rotor: Rotor) -> list[Bearing]:
    """Return the moments of bearings and seals, in the form of `Bearing.tilting`."""
    supports = (part.tilting for part in (*rotor.bearings, *rotor.seals))
    return [tilting for tilting in supports if tilting is not None]


def planes_are_alike(rotor: Rotor) -> bool:
    """Return whether bearings and seals at rest have equal stiffness and mass in x and y and do not couple the axes."""
    supports = (*rotor.bearings, *rotor.seals, *_tilting(rotor))
    tensors = (tensor for part in supports for tensor in part.at(0.0)[::2])
    return all(np.array_equal(0.5 * (T + T.T), T[0, 0] * np.eye(2)) for T in tensors)


def undamped_frequencies(supported: Matrices, rotor: Rotor, count: int) -> Array:
    """Return the natural frequencies of the undamped rotor at rest on its bearings and seals (rad/s), ascending.

    The equation is K phi = omega^2 M phi with the symmetric parts of K and M, because the skew part of cross-coupling
    has no potential. If the planes are alike, these are the first `count` of `undamped_modes`, each of which exists in
    both planes. Otherwise they are the first 2 `count` of both planes together. Rigid motions that nothing holds are
    omitted, and fewer frequencies are returned if the model has fewer.
    """
    if planes_are_alike(rotor):
        return undamped_modes(supported, rotor, count)[0]
    at_rest, z = supported.at(0.0), rotor.shaft.nodes
    supports = (*rotor.bearings, *rotor.seals)
    held = [np.kron([1.0, z[part.node - 1] - z[0]], _symmetric(part.at(0.0)[0])) for part in supports]
    held += [np.kron([0.0, 1.0], _symmetric(tilting.at(0.0)[0])) for tilting in _tilting(rotor)]
    rigid = 4 - int(np.linalg.matrix_rank(np.vstack(held)))  # of two translations and two rotations
    return _lowest(_symmetric(at_rest.M), _symmetric(at_rest.K), 2 * count, rigid, rotor)[0]


def _lowest(M: Array, K: Array, count: int, rigid: int, rotor: Rotor) -> tuple[Array, Array]:
    """Return the first `count` frequencies and shapes of K phi = omega^2 M phi, without `rigid` motions."""
    from scipy.linalg import eigh  # slow to import

    last = len(M) - 1
    for shift in SHIFTS:
        try:
            mu, shapes = eigh(M, K + shift * M, subset_by_index=(max(0, last + 1 - count), last))
        except np.linalg.LinAlgError:  # a bearing's negative stiffness outweighs the shift
            continue
        mu, shapes = mu[inertial(mu)], shapes[:, inertial(mu)]
        squares = (1.0 / mu - shift)[::-1]
        held = np.sort(np.argsort(np.abs(squares), kind="stable")[rigid:])  # a motion that diverges comes before these
        squares = squares[held]
        return np.sign(squares) * np.sqrt(np.abs(squares)), (shapes / np.sqrt(mu))[:, ::-1][:, held]
    raise ValueError(
        f"the undamped modes of rotor {rotor.name!r} cannot be computed: supports have too much negative stiffness"
    )


def _plane_of(matrix: Array) -> Array:
    return _symmetric(0.5 * (matrix[::2, ::2] + matrix[1::2, 1::2]))


def _symmetric(matrix: Array) -> Array:
    return np.asarray(0.5 * (matrix + matrix.T))
