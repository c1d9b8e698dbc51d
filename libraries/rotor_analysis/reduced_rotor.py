"""The model of the plant: the free rotor, reduced as its file specifies, with the error and limit of the reduction."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from array_types import Array
from rotor_analysis.assembly import Matrices, assemble, on_bearings
from rotor_analysis.damping import free_modes
from rotor_analysis.free_rotor import free_rotor
from rotor_analysis.inertia import lacks_inertia
from rotor_analysis.masters import condense_to_accuracy, frequency_error
from rotor_analysis.modal_reduction import reduce_to_shapes, space_for_band, space_with_modes
from rotor_analysis.reduction import Reduction, msdc, reduce_by, unreduced
from rotor_analysis.rotor import Mesh, ReductionOptions, Rotor
from rotor_analysis.spinning_shapes import whirl, with_spinning_shapes
from rotor_analysis.undamped import undamped_frequencies

DEFAULT_BAND = 2000.0  # Hz
ALL_RESIDUALS = 1e-9  # of the static displacement, so that no residual shape is left out
HOLDS_WITHIN = 0.01  # relative error of the natural frequency up to which a reduced mode represents one of the rotor


@dataclass(frozen=True)
class ReductionError:
    """Errors in the natural frequencies of a reduced rotor at rest on its bearings, by mode.

    frequencies
        Natural frequencies of the full model (rad/s), ascending, shape (n,): of one plane if both are alike, otherwise
        of both (`undamped_frequencies`).
    percent
        Relative errors of the reduced model (%), shape (n,); NaN for modes that it does not have.
    """

    frequencies: Array
    percent: Array


@dataclass(frozen=True)
class WhirlError:
    """Errors in the whirl frequencies of a spinning, reduced free rotor, by mode.

    speed
        Spin speed (rad/s).
    forward, backward
        Frequencies of forward and backward whirl of the full model (rad/s), ascending, shapes (count + 1,) and
        (count,). The slowest forward whirl of a rotor that does not bend is due to its gyroscopic moment.
    forward_error, backward_error
        Relative errors of the reduced model (%); NaN for modes that it does not have.
    """

    speed: Annotated[float, "rad/s"]
    forward: Annotated[Array, "rad/s"]
    forward_error: Annotated[Array, "%"]
    backward: Annotated[Array, "rad/s"]
    backward_error: Annotated[Array, "%"]


def reduced_rotor(rotor: Rotor) -> Reduction:
    """Return the plant's model of the free rotor, without its bearings.

    The translations x and y of some planes come first, in order, followed by the other coordinates. With free modes,
    the planes are those of bearings and sites; with MSDC, they are the masters. If the rotor is not reduced, or has a
    node without inertia although free modes are requested, the coordinates are x, y and the slopes x', y' of every
    node. By default MSDC's masters are the planes of discs, bearings, seals, sites and sensors, and as many others as
    the first modes require.

    Parameters
    ----------
    rotor
        Description of the rotor; its `reduction` selects the method, and its `mesh` the number of modes that MSDC must
        keep accurate.

    Raises
    ------
    ValueError
        If the rotor can still move freely when its masters are fixed, or the accuracy is not reached.
    """
    full, options = assemble(rotor), rotor.reduction
    if options.method == "none":
        return unreduced(full)
    if options.method == "msdc":
        masters, count = rotor.masters, (rotor.mesh or Mesh()).modes
        return msdc(full, masters) if masters else condense_to_accuracy(full, rotor, count, options.accuracy)
    return _by_free_modes(full, rotor)


def elastic_shapes(rotor: Rotor) -> tuple[int, int]:
    """Return the numbers of elastic shapes per plane of motion in the plant's model and in the full model."""
    return reduced_rotor(rotor).model.size // 2 - 2, 2 * len(rotor.shaft.nodes) - 2


def with_modes(rotor: Rotor, modes: int) -> Rotor:
    """Return the rotor with a plant that has `modes` elastic modes per plane of motion.

    The spin speed at which the plant is accurate stays the same.
    """
    by_modes = rotor.reduction if rotor.reduction.method == "free_modes" else ReductionOptions("free_modes")
    return replace(rotor, reduction=replace(by_modes, modes=modes, band=None))


def with_modes_up_to(rotor: Rotor, highest: float) -> Rotor:
    """Return the rotor whose plant has all free modes up to a frequency (rad/s), for analyses of its control.

    Higher modes act through their residual shapes, all of which are retained (`modal_reduction`). A rotor without
    reduction is returned unchanged, because its plant contains all elements. A rotor with a node that has no inertia is
    also returned unchanged, because it cannot be reduced.
    """
    full = assemble(rotor)
    if rotor.reduction.method == "none" or lacks_inertia(full.M, full.K):
        return rotor
    count = int(np.searchsorted(free_rotor(full).frequencies, highest))
    return replace(rotor, reduction=ReductionOptions("free_modes", modes=count, accuracy=ALL_RESIDUALS))


def reduction_error(rotor: Rotor, count: int = 6) -> ReductionError:
    """Return the errors of `reduced_rotor` in the natural frequencies of the first `count` modes in one plane."""
    full, plant = on_bearings(assemble(rotor), rotor), reduced_rotor(rotor)
    reduced = reduce_by(full, plant.model.translations, plant.right, plant.left).model
    exact, approximate = (undamped_frequencies(model, rotor, count) for model in (full, reduced))
    percent = np.full(len(exact), np.nan)
    percent[: len(approximate)] = 100.0 * (approximate / exact[: len(approximate)] - 1.0)
    return ReductionError(exact, percent)


def whirl_error(rotor: Rotor, count: int = 6) -> WhirlError | None:
    """Return the errors in the plant's whirl frequencies at the speed that the rotor file states.

    The result is None if the file states no speed. It is also None if a node has no inertia, because such a rotor
    cannot be used in a plant.
    """
    full, speed = assemble(rotor), rotor.reduction.speed
    if not speed or lacks_inertia(full.M, full.K):
        return None
    exact, result = (_whirl(model, speed)[: 2 * count + 1] for model in (full, reduced_rotor(rotor).model))
    percent = np.full(len(exact), np.nan)
    percent[: len(result)] = 100.0 * (result / exact[: len(result)] - 1.0)
    return WhirlError(speed, exact[::2], percent[::2], exact[1::2], percent[1::2])


def _whirl(model: Matrices, speed: float) -> Array:
    """Return all whirl frequencies (rad/s) of a free rotor, in the order of `whirl`."""
    free = free_rotor(model)
    frequencies = np.concatenate([np.zeros(2), free.frequencies])
    return whirl(frequencies, free.modes(len(free.frequencies)), speed * model.G[::2, 1::2])[0]


def valid_to(full: Matrices, reduced: Matrices) -> float:
    """Return the frequency (rad/s) up to which a reduction of the free rotor is valid.

    The modes are those of the undamped rotor at rest without bearings. The limit is the natural frequency of the
    highest elastic mode up to which the frequencies of all modes are within 1 % of the full model's, or 0 if there is
    no such mode. The error of the mesh is not included.

    Parameters
    ----------
    full, reduced
        The free rotor and its reduction, each the same in both planes of motion.
    """
    (exact, _), (approximate, _) = (free_modes(model.M[::2, ::2], model.K[::2, ::2]) for model in (full, reduced))
    within = frequency_error(exact[: len(approximate)], approximate) <= HOLDS_WITHIN
    count = len(approximate) if within.all() else int(np.argmin(within))
    return float(exact[count - 1]) if count else 0.0


def force_nodes(rotor: Rotor) -> tuple[int, ...]:
    """Return the nodes of bearings and contact sites, which get residual shapes; if there are none, the end nodes."""
    nodes = {*rotor.site_nodes, *rotor.bearing_nodes} or {1, len(rotor.shaft.nodes)}
    return tuple(sorted(nodes))


def _by_free_modes(full: Matrices, rotor: Rotor) -> Reduction:
    """Return the reduction to free modes, residual shapes and spinning shapes, as set in the rotor file."""
    if lacks_inertia(full.M, full.K):
        return unreduced(full)
    free, forces, options = free_rotor(full), force_nodes(rotor), rotor.reduction
    highest = None
    if options.modes is not None:
        space = space_with_modes(free, options.modes, forces, options.accuracy)
    else:
        highest = 2.0 * math.pi * (DEFAULT_BAND if options.band is None else options.band)
        space = space_for_band(free, highest, forces, options.accuracy)
    if options.speed:
        space = with_spinning_shapes(space, full, options.speed, highest, options.accuracy)
    return reduce_to_shapes(full, space, forces)
