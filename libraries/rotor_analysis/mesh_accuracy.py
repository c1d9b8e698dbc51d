"""Refinement of a mesh for the first modes: elements are divided where their division changes a natural frequency."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from array_types import Array
from rotor_analysis.assembly import assemble, element_matrices, on_bearings
from rotor_analysis.element import Element
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import SHORTEST, MassModel
from rotor_analysis.undamped import undamped_modes

Layers = tuple[Element, ...]  # an element and the sleeves on it

MOST_NODES = 500
MOST_NEEDED = 4 * MOST_NODES  # elements, extrapolated by the order of the error; refinement stops if more are needed
ORDER: dict[MassModel, int] = {"diagonal": 2, "consistent": 4}  # of a frequency's error in the length of the elements
ROUNDING = 64 * np.finfo(float).eps  # of the terms of a dynamic stiffness, in the difference of two
LARGE = 0.25  # elements with this share of the largest contribution are divided together


def refine_to_accuracy(rotor: Rotor, modes: int, accuracy: float) -> Rotor:
    """Return `rotor` on a mesh whose halving changes no natural frequency by more than `accuracy`.

    The change is computed for each element to first order. It follows from the mode shape phi, with phi^T M phi = 1,
    and the dynamic stiffness D = K - omega^2 M of the element. D_halves is the dynamic stiffness of its two halves with
    the middle node condensed:

        delta omega / omega = phi^T (D_halves - D) phi / (2 omega^2)

    The rounding error of the difference is subtracted, because it dominates the difference if the motion hardly bends
    the rotor, for example on soft bearings. While the sum over the elements exceeds `accuracy` for a mode, the original
    elements that contribute most are divided into more equal parts.

    Parameters
    ----------
    rotor
        Description of the rotor; parts and masters keep their positions on the shaft.
    modes
        Number of modes, the first ones of the undamped rotor at rest (`undamped_modes`).
    accuracy
        Allowed relative change.

    Raises
    ------
    ValueError
        If the mesh would require more than 500 nodes.
    """
    z = np.array(rotor.shaft.nodes)
    counts = np.ceil(np.diff(z) / (z[-1] - z[0]) * modes).astype(int)
    order = ORDER[rotor.shaft.mass_matrix]
    max_counts = np.maximum(1, np.diff(z) // (SHORTEST * (1.0 + SHORTEST) * (z[-1] - z[0]))).astype(int)
    counts = np.minimum(counts, max_counts)
    while np.sum(counts) < MOST_NODES:
        mesh = _divide(rotor, counts)
        change = _change_by_halving(mesh, modes)
        sums = np.sum(change, axis=0)
        inaccurate = change[:, sums > accuracy]
        if inaccurate.size == 0:
            return mesh
        if np.sum(counts) * (np.max(sums) / accuracy) ** (1.0 / order) > MOST_NEEDED:
            break
        coarse = np.any(inaccurate > LARGE * np.max(inaccurate, axis=0), axis=1)
        divided = np.unique(np.repeat(np.arange(len(counts)), counts)[coarse])
        finer = np.minimum(counts[divided] + np.maximum(1, counts[divided] // 3), max_counts[divided])
        if np.array_equal(finer, counts[divided]):
            break
        counts[divided] = finer
    raise ValueError(f"mesh.accuracy = {accuracy:g} is not reached with {MOST_NODES} nodes; increase mesh.accuracy")


def _change_by_halving(rotor: Rotor, modes: int) -> Array:
    """Return the relative changes in the frequencies when elements are halved, shape (elements, modes)."""
    frequencies, shapes = undamped_modes(on_bearings(assemble(rotor), rotor), rotor, modes)
    change = np.empty((len(rotor.elements), len(frequencies)))
    for e, layers in enumerate(rotor.elements):
        at_ends = shapes[2 * e : 2 * e + 4]
        halves = _stiffness_halved(layers, rotor.shaft.mass_matrix, frequencies)
        whole = _dynamic_stiffness(layers, rotor.shaft.mass_matrix, frequencies)
        difference = np.abs(np.einsum("im,mij,jm->m", at_ends, halves - whole, at_ends))
        size = np.einsum("im,mij,jm->m", np.abs(at_ends), np.abs(whole), np.abs(at_ends))
        change[e] = np.maximum(difference - ROUNDING * size, 0.0)
    return change / np.maximum(2.0 * frequencies**2, np.finfo(float).tiny)


def _dynamic_stiffness(layers: Layers, mass: MassModel, frequencies: Array) -> Array:
    """Return the dynamic stiffness of an element at each frequency (rad/s), shape (modes, 4, 4)."""
    D = np.zeros((len(frequencies), 4, 4))
    for layer in layers:
        M, _, K = element_matrices(layer, mass)
        D += K - (frequencies * np.abs(frequencies))[:, np.newaxis, np.newaxis] * M
    return D


def _stiffness_halved(layers: Layers, mass: MassModel, frequencies: Array) -> Array:
    """Return the dynamic stiffness of an element's two halves, with the middle node condensed, shape (modes, 4, 4)."""
    D = np.zeros((len(frequencies), 6, 6))
    for k, (begin, end) in enumerate(((0.0, 0.5), (0.5, 1.0))):
        half = tuple(layer.part(begin, end) for layer in layers)
        D[:, 2 * k : 2 * k + 4, 2 * k : 2 * k + 4] += _dynamic_stiffness(half, mass, frequencies)
    ends, middle = np.array([0, 1, 4, 5]), np.array([2, 3])
    to_middle = np.linalg.solve(D[:, middle[:, np.newaxis], middle], D[:, middle[:, np.newaxis], ends])
    return D[:, ends[:, np.newaxis], ends] - D[:, ends[:, np.newaxis], middle] @ to_middle


def _divide(rotor: Rotor, counts: NDArray[np.int_]) -> Rotor:
    """Return `rotor` with each element divided into a number of equal parts."""
    z = rotor.shaft.nodes
    inner = [np.linspace(a, b, n + 1)[:-1].tolist() for (a, b), n in zip(pairwise(z), counts, strict=True)]
    return rotor.on_mesh(rotor.shaft.on_nodes((*(place for places in inner for place in places), z[-1])))
