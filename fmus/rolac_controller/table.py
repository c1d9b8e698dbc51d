"""Receptances to the table of H that an FMU stores (thesis 5.10)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rolac_controller.fourier import N_SENSORS
from rolac_controller.rolac import N_AXES

Complex = NDArray[np.complex128]

# A receptance is known to about four digits; beyond this condition number none of them is left in H.
MAX_CONDITION = 1e4

# Constants of a controller without a table: PID and Fourier transform work, ROLAC cannot be enabled.
NO_TABLE: NDArray[np.float64] = np.zeros(1)
NO_TABLE.flags.writeable = False


def inverse_receptance(receptance: ArrayLike, weights: ArrayLike | None = None) -> Complex:
    """Matrix H of the adaptive law, the negative weighted pseudo-inverse of the receptance.

    H = -(R^H W R)^-1 R^H W     (5.10)

    Parameters
    ----------
    receptance
        R, shape (8, 4), complex (m/N): s1 to s8 by forces at mb1.x, mb1.y, mb2.x, mb2.y.
    weights
        Diagonal of W, shape (8,), non-negative; ones by default.

    Returns
    -------
    ndarray
        H, shape (4, 8), complex (N/m).

    Raises
    ------
    ValueError
        If a shape is wrong, a number is not finite, a weight is negative, or R is ill-conditioned.
    """
    r = np.asarray(receptance, dtype=np.complex128)
    w = np.ones(N_SENSORS) if weights is None else np.asarray(weights, dtype=np.float64)
    if r.shape != (N_SENSORS, N_AXES):
        raise ValueError(f"receptance of shape {r.shape} is not allowed; it must be ({N_SENSORS}, {N_AXES})")
    if not np.isfinite(r).all():
        raise ValueError("receptance is not allowed to hold numbers that are not finite")
    if w.shape != (N_SENSORS,) or not np.isfinite(w).all() or (w < 0.0).any():
        raise ValueError(f"weights = {w} is not allowed; they must be {N_SENSORS} finite numbers >= 0")
    root = np.sqrt(w)
    weighted = root[:, None] * r
    singular = np.linalg.svd(weighted, compute_uv=False)
    condition = singular[0] / singular[-1] if singular[-1] > 0.0 else np.inf
    if condition > MAX_CONDITION:
        raise ValueError(
            f"a receptance of condition number {condition:.3g} is not allowed; at most {MAX_CONDITION:g} is, "
            "or some combination of forces hardly moves any weighted sensor"
        )
    return np.asarray(-np.linalg.pinv(weighted, rcond=0.0) * root, dtype=np.complex128)


def pack(speeds: ArrayLike, receptances: ArrayLike, weights: ArrayLike | None = None) -> NDArray[np.float64]:
    """Constants of the controller: the speeds and their H, flat, as `rolac_controller.rolac` reads them.

    Parameters
    ----------
    speeds
        Speeds, shape (n,), ascending (rad/s).
    receptances
        R at each of them, shape (n, 8, 4), complex (m/N).
    weights
        Sensor weights, as in `inverse_receptance`.

    Raises
    ------
    ValueError
        If the speeds are not ascending and positive, shapes do not match, or an R cannot be inverted (the
        message names the speed).
    """
    omega = np.asarray(speeds, dtype=np.float64)
    r = np.asarray(receptances, dtype=np.complex128)
    ascending = omega.ndim == 1 and omega.size > 0 and np.isfinite(omega).all() and (np.diff(omega) > 0.0).all()
    if not ascending or omega[0] <= 0.0:
        raise ValueError(f"speeds = {omega} rad/s is not allowed; they must be > 0 rad/s, finite and ascending")
    if r.shape != (omega.size, N_SENSORS, N_AXES):
        raise ValueError(
            f"receptances of shape {r.shape} is not allowed; "
            f"{omega.size} speeds need ({omega.size}, {N_SENSORS}, {N_AXES})"
        )
    matrices = np.empty((omega.size, N_AXES, N_SENSORS), dtype=np.complex128)
    for k in range(omega.size):
        try:
            matrices[k] = inverse_receptance(r[k], weights)
        except ValueError as error:
            raise ValueError(f"at {omega[k]:g} rad/s: {error}") from error
    return np.concatenate([[float(omega.size)], omega, matrices.view(np.float64).ravel()])
