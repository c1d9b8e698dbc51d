"""Error of a condensation to a few planes: eigenvalues of the condensed model against those of the full one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amb_files.checks import require
from array_types import Array
from rotor_analysis.modes import modes
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import MassModel
from rotor_analysis.supported_rotor import supported_rotor
from rotor_analysis.tracking import pair_modes


@dataclass(frozen=True)
class CondensationError:
    """Errors of the condensed model, in percent; NaN for modes that it does not have.

    planes
        Node numbers of the masters.
    speeds
        Spin speeds (rad/s), shape (n,).
    frequency
        Relative error of the damped natural frequency, shape (n, count), by ascending frequency of the full model.
    eigenvalue
        |lambda - lambda_full| / |lambda_full|, shape (n, count); it includes the error of damping.
    """

    planes: tuple[int, ...]
    speeds: Array
    frequency: Array
    eigenvalue: Array


def condensation_error(
    rotor: Rotor,
    speeds: Array,
    planes: tuple[int, ...] | None = None,
    count: int = 8,
    mass: MassModel | None = None,
) -> CondensationError:
    """Condense a rotor and compare its lowest modes with those of the full model, paired by their shapes.

    Parameters
    ----------
    rotor
        Its description.
    speeds
        Spin speeds (rad/s), shape (n,).
    planes
        Node numbers that support the rotor; its master planes by default.
    count
        Number of modes to compare.
    mass
        `consistent` or `diagonal`; by default that of the rotor.

    Raises
    ------
    ValueError
        If there are no planes, or they do not support the rotor.
    """
    chosen = rotor.masters if planes is None else planes
    require(len(chosen) > 0, "planes", list(chosen), "a list of node numbers to condense to")
    full, condensed = supported_rotor(rotor, mass), supported_rotor(rotor, mass, chosen)
    frequency, eigenvalue = np.full((2, len(speeds), count), np.nan)
    for row, Omega in enumerate(speeds):
        exact, result = modes(full.model, float(Omega), count), modes(condensed.model, float(Omega))
        shapes = [condensed.reduction.right @ mode.shape for mode in result]
        for column, (index, _) in enumerate(pair_modes(full.model.M, [mode.shape for mode in exact], shapes)):
            if index is not None:
                mode, approximation = exact[column], result[index]
                frequency[row, column] = 100.0 * (approximation.frequency / mode.frequency - 1.0)
                eigenvalue[row, column] = 100.0 * abs(approximation.eigenvalue - mode.eigenvalue) / abs(mode.eigenvalue)
    return CondensationError(chosen, np.asarray(speeds, dtype=np.float64), frequency, eigenvalue)
