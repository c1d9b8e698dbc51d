"""Error of a condensation to a few planes: eigenvalues of the condensed model compared with those of the full model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_files.checks import require
from array_types import Array
from rotor_analysis.modes import modes
from rotor_analysis.rotor import Rotor
from rotor_analysis.supported_rotor import supported_rotor
from rotor_analysis.tracking import pair_modes


@dataclass(frozen=True, eq=False)
class CondensationError:
    """Errors of the condensed model by mode, in order of the full model's frequencies; NaN for missing modes.

    planes
        Node numbers of the masters.
    speeds
        Spin speeds (rad/s), shape (n,).
    frequency_error
        Relative error of the damped natural frequency (%), shape (modes, n).
    eigenvalue_error
        |lambda - lambda_full| / |lambda_full| (%), shape (modes, n); this includes the error of the damping.
    """

    planes: tuple[int, ...]
    speeds: Annotated[Array, "rad/s"]
    frequency_error: Annotated[Array, "%"]
    eigenvalue_error: Annotated[Array, "%"]


def condensation_error(
    rotor: Rotor, speeds: Array, planes: tuple[int, ...] | None = None, count: int = 8
) -> CondensationError:
    """Condense a rotor and compare its lowest modes with the modes of the full model that have similar shapes.

    Parameters
    ----------
    rotor
        The rotor.
    speeds
        Spin speeds (rad/s), shape (n,).
    planes
        Node numbers to condense to, by default the master planes; the rotor must not move freely when they are fixed.
    count
        Number of modes that are compared.

    Raises
    ------
    ValueError
        If there are no planes, or the rotor can still move freely when they are fixed.
    """
    chosen = rotor.masters if planes is None else planes
    require(len(chosen) > 0, "planes", list(chosen), "a list of node numbers to condense to")
    full, condensed = supported_rotor(rotor), supported_rotor(rotor, planes=chosen)
    frequency, eigenvalue = np.full((2, count, len(speeds)), np.nan)
    for k, Omega in enumerate(speeds):
        exact, approximate = modes(full.model, float(Omega), count), modes(condensed.model, float(Omega))
        shapes = [condensed.reduction.right @ mode.shape for mode in approximate]
        for row, (index, _) in enumerate(pair_modes(full.model.M, [mode.shape for mode in exact], shapes)):
            if index is not None:
                mode, approximation = exact[row], approximate[index]
                frequency[row, k] = 100.0 * (approximation.frequency / mode.frequency - 1.0)
                eigenvalue[row, k] = 100.0 * abs(approximation.eigenvalue - mode.eigenvalue) / abs(mode.eigenvalue)
    return CondensationError(chosen, np.asarray(speeds, dtype=np.float64), frequency, eigenvalue)
