"""Damping of a rotor without its bearings, and the share of this damping that rotates with the shaft."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from annotated_types import Ge, Le, Lt
from pydantic import BeforeValidator, StrictFloat

from amb_files.toml import table
from amb_files.validation_errors import Unit
from array_types import Array
from rotor_analysis.checks import Moderate, as_tuple
from rotor_analysis.inertia import inertial_modes, inertias, lacks_inertia

Rate = Annotated[StrictFloat, Ge(0.0), Moderate, Unit("1/s")]
Time = Annotated[StrictFloat, Ge(0.0), Moderate, Unit("s")]
Ratio = Annotated[StrictFloat, Ge(0.0), Lt(1.0)]
Ratios = Annotated[tuple[Ratio, ...], BeforeValidator(as_tuple)]
Share = Annotated[StrictFloat, Ge(0.0), Le(1.0)]

SHIFT = 1e4  # rad^2/s^2, which makes the singular stiffness of a free rotor positive definite
N_RIGID = 2  # modes of the free rotor in a single plane: translation and tilting


@table
class Damping:
    """Damping of a rotor without its bearings: the sum of all contributions.

    Rotating damping, for example of the material or of shrink fits, drives whirl that is slower than the spin.
    """

    mass: Rate = 0.0
    """Factor of the shaft's mass matrix: external damping, which does not rotate."""
    stiffness: Time = 0.0
    """Factor of the shaft's stiffness matrix."""
    modal: Ratios = ()
    """Damping ratios of the elastic modes of the free rotor, the lowest first; the last one applies to all higher
    modes.
    """
    loss_factor: Ratio = 0.0
    """Loss factor eta of hysteretic material damping: energy loss per cycle / (2 pi maximum strain energy). Runs and
    models of the control loop replace this damping by viscous damping with the same loss in the elastic modes of the
    free rotor at rest.
    """
    rotating: Share = 1.0
    """Share of the damping that rotates with the shaft; damping by `mass` never rotates."""

    def ratios(self, count: int) -> Array:
        """Return the damping ratios `modal` of the first `count` elastic modes, shape (count,)."""
        values = self.modal or (0.0,)
        return np.array([values[min(k, len(values) - 1)] for k in range(count)])


def free_modes(M: Array, K: Array) -> tuple[Array, Array]:
    """Return the elastic modes, K phi = omega^2 M phi, of a free rotor in a single plane.

    Parameters
    ----------
    M, K
        Mass and stiffness matrices for the degrees of freedom in one plane, without bearings, shape (n, n).

    Returns
    -------
    frequencies
        Natural frequencies omega (rad/s), ascending, shape (n - 2,), or fewer if some coordinates have no inertia.
    shapes
        Mode shapes phi in columns, with phi^T M phi = 1.
    """
    if lacks_inertia(M, K):
        if inertias(M, K) < N_RIGID:  # a mass at a point does not resist tilting, nor does the free shaft
            return np.zeros(0), np.zeros((len(M), 0))
        squares, shapes = inertial_modes(M, K, SHIFT)
        return np.sqrt(np.maximum(squares[N_RIGID:], 0.0)), shapes[:, N_RIGID:]
    L = np.linalg.cholesky(M)
    half = np.linalg.solve(L, K)
    squares, vectors = np.linalg.eigh(np.linalg.solve(L, half.T))
    shapes = np.linalg.solve(L.T, vectors)
    return np.sqrt(np.maximum(squares[N_RIGID:], 0.0)), np.asarray(shapes[:, N_RIGID:])


def damping_matrices(damping: Damping, shaft_mass: Array, M: Array, K: Array) -> tuple[Array, Array]:
    """Return the viscous damping matrices of a single plane in the fixed frame and in the rotating frame (N s/m).

    C = mass M_shaft + (1 - rotating) C_i,  R = rotating C_i,
    C_i = stiffness K + sum over the elastic modes of 2 zeta_k omega_k (M phi_k) (M phi_k)^T

    Parameters
    ----------
    damping
        Damping in the rotor file.
    shaft_mass, M, K
        Mass matrix of the shaft, and mass and stiffness matrices of the free rotor, for the degrees of freedom in one
        plane, shape (n, n) each.
    """
    internal = damping.stiffness * K
    if damping.modal:
        frequencies, shapes = free_modes(M, K)
        momenta = M @ shapes
        internal = internal + (momenta * (2.0 * damping.ratios(len(frequencies)) * frequencies)) @ momenta.T
    return damping.mass * shaft_mass + (1.0 - damping.rotating) * internal, damping.rotating * internal
