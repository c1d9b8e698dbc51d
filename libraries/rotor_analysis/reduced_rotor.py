"""The model of the plant: the free rotor reduced as in its file, its error, and its frequency limit."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.free_rotor import free_rotor
from rotor_analysis.masters import condense_to_accuracy, frequency_error, needed_masters, not_reached
from rotor_analysis.modal_reduction import reduce_to_shapes, space_for_band, space_with_modes
from rotor_analysis.reduction import Reduction, craig_bampton, craig_bampton_by_modes, msdc, unreduced
from rotor_analysis.rotor import Mesh, ReductionOptions, Rotor
from rotor_analysis.undamped import undamped_modes

HOLDS_WITHIN = 0.01  # relative error of a natural frequency, up to which a mode counts as one of the rotor's


@dataclass(frozen=True)
class ReductionError:
    """Errors of a reduced rotor at rest on its bearings, by mode in one plane.

    frequencies
        Natural frequencies of the full model (rad/s), ascending, shape (count,).
    percent
        Relative errors of the reduced model (%), shape (count,); NaN for modes that it does not have.
    """

    frequencies: Array
    percent: Array


def reduced_rotor(rotor: Rotor) -> Reduction:
    """Return the plant's model of the free rotor, without its bearings.

    The translations x and y of the master planes come first, in order, then those of the modes. Unreduced, the
    coordinates are x, y and the slopes x', y' of every node. By default the masters are the planes of discs, bearings,
    seals, sites and sensors and, for MSDC, others until the first modes are accurate; the number of modes in Craig and
    Bampton's method is as large as accuracy requires.

    Parameters
    ----------
    rotor
        Its description, with `reduction` and, for the number of modes that must be accurate, `mesh`.

    Raises
    ------
    ValueError
        If the masters do not support the rotor, or the accuracy is not reached.
    """
    full, options = assemble(rotor), rotor.reduction
    count = (rotor.mesh or Mesh()).modes
    if options.method == "none":
        return unreduced(full)
    if options.method == "free_modes":
        return _by_free_modes(full, rotor, count)
    if options.method == "msdc":
        named = rotor.masters
        return msdc(full, named) if named else condense_to_accuracy(full, rotor, count, options.accuracy)
    masters = rotor.masters or needed_masters(rotor)
    if options.modes is not None:
        return craig_bampton(full, masters, options.modes)
    return _craig_bampton_to_accuracy(full, rotor, masters, count)


def retained_modes(rotor: Rotor) -> tuple[int, int]:
    """Return how many modes per plane of motion the plant's model has in addition to its planes, and at most can."""
    model = reduced_rotor(rotor).model
    planes = len(model.translations)
    return model.size // 2 - planes, 2 * len(rotor.shaft.nodes) - planes


def with_modes(rotor: Rotor, modes: int) -> Rotor:
    """Return a rotor whose plant's model has its planes and a number of modes in each plane of motion."""
    return replace(rotor, reduction=ReductionOptions("craig_bampton", rotor.masters, modes))


def reduction_error(rotor: Rotor, count: int = 6) -> ReductionError:
    """Return the errors of the frequencies of `reduced_rotor`, of the first `count` modes without rigid motion."""
    exact = undamped_modes(assemble(rotor), rotor, count)[0]
    result = undamped_modes(reduced_rotor(rotor).model, rotor, count)[0]
    percent = np.full(len(exact), np.nan)
    percent[: len(result)] = 100.0 * (result / exact[: len(result)] - 1.0)
    return ReductionError(exact, percent)


def valid_to(full: Matrices, reduced: Matrices) -> float:
    """Return the frequency (rad/s) up to which a reduction of the free rotor is valid.

    It is the natural frequency of the highest elastic mode such that this and all lower modes are within 1 % of the
    full model, for the undamped rotor at rest without bearings; 0 if there is none. The error of the mesh is not
    included.

    Parameters
    ----------
    full, reduced
        The free rotor and its reduction, each the same in both planes of motion.
    """
    (exact, _), (result, _) = (free_modes(model.M[::2, ::2], model.K[::2, ::2]) for model in (full, reduced))
    within = frequency_error(exact[: len(result)], result) <= HOLDS_WITHIN
    count = len(result) if within.all() else int(np.argmin(within))
    return float(exact[count - 1]) if count else 0.0


def force_nodes(rotor: Rotor) -> tuple[int, ...]:
    """Return the nodes of the contact sites, or else of the bearings, or else of the ends."""
    nodes = {*rotor.site_nodes} or {*rotor.bearing_nodes} or {1, len(rotor.shaft.nodes)}
    return tuple(sorted(nodes))


def _by_free_modes(full: Matrices, rotor: Rotor, count: int) -> Reduction:
    """The reduction by the free modes, and the residual shapes of its contact sites, as the rotor file requires."""
    free, forces, options = free_rotor(full), force_nodes(rotor), rotor.reduction
    places = tuple(sorted({*rotor.bearing_nodes, *rotor.site_nodes})) or forces
    if options.modes is not None:
        space = space_with_modes(free, options.modes, forces)
    else:
        default = float(free.frequencies[min(max(count - 2, 1), len(free.mu)) - 1])
        highest = default if options.band is None else 2.0 * math.pi * options.band
        space = space_for_band(free, highest, forces, options.accuracy, places)
    return reduce_to_shapes(full, space, places)


def _craig_bampton_to_accuracy(full: Matrices, rotor: Rotor, masters: tuple[int, ...], count: int) -> Reduction:
    """The reduction with the fewest modes that make the first `count` natural frequencies accurate."""
    exact, accuracy = undamped_modes(full, rotor, count)[0], rotor.reduction.accuracy
    inner = full.size // 2 - len(masters)
    reduced_to = craig_bampton_by_modes(full, masters)
    for modes in range(inner + 1):
        reduction = reduced_to(modes)
        error = frequency_error(exact, undamped_modes(reduction.model, rotor, count)[0])
        if np.max(error) <= accuracy:
            return reduction
    raise not_reached(accuracy, "modes", error)
