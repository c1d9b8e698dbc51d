"""Error of a reduced rotor's receptance relative to the full model; frequency up to which this error is small."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.free_rotor import FreeRotor, free_rotor
from rotor_analysis.inertia import lacks_inertia
from rotor_analysis.reduced_rotor import force_nodes, reduced_rotor
from rotor_analysis.reduction import Reduction
from rotor_analysis.rotor import Rotor

LOWEST = 0.05  # times the lowest elastic natural frequency, at which the search for the limit begins
PER_DECADE = 100  # frequencies in it
WITHIN = 1e-3  # relative width at which the bisection of the limit ends


@dataclass(frozen=True, eq=False)
class ReceptanceError:
    """Error of the plant model's receptance between bearings and contact sites.

    accuracy
        Error up to which the model counts as accurate.
    limit
        Lowest frequency (rad/s) at which the error exceeds `accuracy`; infinite if there is none.
    frequencies
        A quarter, a half, one and two times the limit (rad/s), shape (4,); empty if the limit is infinite.
    error, spinning
        Error at these frequencies for the rotor at rest, and for whirl in either direction when the rotor spins at the
        same frequency, shape (4,) each.
    """

    accuracy: float
    limit: float
    frequencies: Array
    error: Array
    spinning: Array


def receptance_error(rotor: Rotor) -> ReceptanceError | None:
    """Return the receptance error of the plant's model (`reduced_rotor`), with the accuracy set in the rotor file.

    max |H_ij reduced - H_ij| / sqrt(S_i S_j), with S_i the sum of magnitudes of all modal terms of H_ii (m/N)     (1)

    i and j are the planes of bearings and sites (`force_nodes`); the rotor is free and undamped. The limit applies to
    the rotor at rest. Gyroscopic moments couple retained and omitted shapes, so the error grows with the spin speed,
    while S_i keeps its value at rest. The result is None if a node has no inertia, because such a rotor cannot be used
    in a plant.
    """
    full, nodes, accuracy = assemble(rotor), force_nodes(rotor), rotor.reduction.accuracy
    if lacks_inertia(full.M, full.K):
        return None
    free, plant = free_rotor(full), reduced_rotor(rotor)

    def error(omega: float, *spins: float) -> float:
        return max(_error(full, free, plant, nodes, omega, spin) for spin in spins or (0.0,))

    lowest, highest = LOWEST * free.frequencies[0], free.frequencies[-1]
    count = int(PER_DECADE * np.log10(highest / lowest)) + 2
    below = lowest
    for above in np.geomspace(lowest, highest, count).tolist():
        if error(above) > accuracy:
            break
        below = above
    else:
        return ReceptanceError(accuracy, np.inf, np.zeros(0), np.zeros(0), np.zeros(0))
    while above - below > WITHIN * above:
        middle = 0.5 * (below + above)
        below, above = (middle, above) if error(middle) <= accuracy else (below, middle)
    frequencies = below * np.array([0.25, 0.5, 1.0, 2.0])
    at_rest = np.array([error(omega) for omega in frequencies])
    spinning = np.array([error(omega, omega, -omega) for omega in frequencies])
    return ReceptanceError(accuracy, below, frequencies, at_rest, spinning)


def _error(
    full: Matrices, free: FreeRotor, plant: Reduction, nodes: tuple[int, ...], omega: float, spin: float
) -> float:
    """Return the error (1) at a frequency and a spin speed (rad/s); a negative spin is opposite to the whirl."""
    rows = full.rows(nodes)[::2]
    right, left = plant.right[rows, ::2], plant.left[::2, rows]
    places = free.rows(nodes)
    size = np.sqrt(free.sizes(places, omega))
    if spin:
        exact: Array = np.linalg.inv(_dynamic_stiffness(full, omega, spin))[np.ix_(places, places)].astype(np.float64)
    else:
        exact = free.receptance(places, omega)
    error = np.abs(right @ np.linalg.solve(_dynamic_stiffness(plant.model, omega, spin), left) - exact)
    return float(np.max(error / np.outer(size, size)))


def _dynamic_stiffness(model: Matrices, omega: float, spin: float) -> Array:
    """Return K - omega^2 M + Omega omega G_1 for motion on a circle, x + i y = r exp(i omega t)."""
    G_1 = model.G[::2, 1::2]
    return np.asarray(model.K[::2, ::2] - omega**2 * model.M[::2, ::2] + spin * omega * G_1)
