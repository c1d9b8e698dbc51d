"""The model of the plant: the free rotor reduced as its file says, its error, and up to which frequency it holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fmi_export.model import Array
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.masters import condense_to_accuracy, frequency_error, needed_masters, not_reached
from rotor_analysis.reduction import Reduction, craig_bampton, craig_bampton_by_modes, msdc, unreduced
from rotor_analysis.rotor import Mesh, Rotor
from rotor_analysis.undamped import undamped_modes

HOLDS_WITHIN = 0.01  # relative error of a natural frequency, up to which a mode counts as one of the rotor's


@dataclass(frozen=True)
class ReductionError:
    """Errors of a reduced rotor at rest on its bearings, by mode in one plane.

    frequencies
        Natural frequencies of the full model (rad/s), ascending, shape (count,).
    percent
        Of the reduced model over these less one, in percent, shape (count,); NaN where it has no such mode.
    """

    frequencies: Array
    percent: Array


def reduced_rotor(rotor: Rotor) -> Reduction:
    """Return the model of the free rotor that the plant has, without its bearings.

    The translations x and y of the master planes come first, in order, then those of the modes. Unreduced, the
    coordinates are x, y and the slopes x', y' of every node. Where the rotor names no masters, they are the planes of
    discs, bearings, seals, sites and sensors and, for MSDC, more until the first modes are accurate. Where it names no
    number of modes for Craig and Bampton's method, there are as many as that takes.

    Parameters
    ----------
    rotor
        Its description, with `reduction` and, for the number of modes that must be accurate, `mesh`.

    Raises
    ------
    ValueError
        If the masters do not hold the rotor, or the accuracy is not reached.
    """
    full, options = assemble(rotor), rotor.reduction
    count = (rotor.mesh or Mesh()).modes
    if options.method == "none":
        return unreduced(full)
    if options.method == "msdc":
        named = rotor.masters
        return msdc(full, named) if named else condense_to_accuracy(full, rotor, count, options.accuracy)
    masters = rotor.masters or needed_masters(rotor)
    if options.modes is not None:
        return craig_bampton(full, masters, options.modes)
    return _craig_bampton_to_accuracy(full, rotor, masters, count)


def reduction_error(rotor: Rotor, count: int = 6) -> ReductionError:
    """Return the errors of the frequencies of `reduced_rotor`, of the first `count` modes without rigid motion."""
    exact = undamped_modes(assemble(rotor), rotor, count)[0]
    result = undamped_modes(reduced_rotor(rotor).model, rotor, count)[0]
    percent = np.full(len(exact), np.nan)
    percent[: len(result)] = 100.0 * (result / exact[: len(result)] - 1.0)
    return ReductionError(exact, percent)


def valid_to(full: Matrices, reduced: Matrices) -> float:
    """Return the frequency (rad/s) up to which a reduction of the free rotor holds.

    It is the natural frequency of the highest elastic mode such that this mode and all below it are within 1 % of the
    full model's, of the undamped rotor without bearings at rest; 0 if there is none. The mesh has an error of its own.

    Parameters
    ----------
    full, reduced
        The free rotor and its reduction, each the same in both planes of motion.
    """
    (exact, _), (result, _) = (free_modes(model.M[::2, ::2], model.K[::2, ::2]) for model in (full, reduced))
    within = frequency_error(exact[: len(result)], result) <= HOLDS_WITHIN
    count = len(result) if within.all() else int(np.argmin(within))
    return float(exact[count - 1]) if count else 0.0


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
