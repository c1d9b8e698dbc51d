"""Receptances to H, and to the table that an FMU is built with (thesis 5.10)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rolac_controller.parameters import LARGEST_ORDER
from rolac_controller.receptance_table import ROW
from rolac_controller.rig_layout import N_AXES, N_SENSORS

Complex = NDArray[np.complex128]

# A receptance is known to about four digits; beyond this condition number none of them is left in H.
MAX_CONDITION = 1e4

# Speeds at which the thesis identifies (rad/s).
SPEEDS = tuple(2.0 * np.pi * f for f in (5.0, 10.0, 15.0, 20.0, 22.0, 24.0, 25.0, 26.0, 27.0, 28.0, 29.0, 35.0))

# Constants of a controller without a table: all works but ROLAC, which needs an identification first.
NO_TABLE: NDArray[np.float64] = np.zeros(1)
NO_TABLE.flags.writeable = False


def condition_number(receptance: ArrayLike, weights: ArrayLike | None = None) -> float:
    """Largest over smallest singular value of W^(1/2) R; infinite where R is singular.

    Parameters and errors are those of `inverse_receptance`, which refuses more than MAX_CONDITION.
    """
    singular = np.linalg.svd(_weighted(receptance, weights)[0], compute_uv=False)
    return float(singular[0] / singular[-1]) if singular[-1] > 0.0 else np.inf


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
    weighted, root = _weighted(receptance, weights)
    condition = condition_number(receptance, weights)
    if condition > MAX_CONDITION:
        raise ValueError(
            f"a receptance of condition number {condition:.3g} is not allowed; at most {MAX_CONDITION:g} is, "
            "or some combination of forces hardly moves any weighted sensor"
        )
    return np.asarray(-np.linalg.pinv(weighted, rcond=0.0) * root, dtype=np.complex128)


def pack(speeds: ArrayLike, receptances: ArrayLike, orders: Sequence[int] = (1,)) -> NDArray[np.float64]:
    """Constants of the controller: R and H at a list of speeds.

    Parameters
    ----------
    speeds
        Speeds, shape (n,), ascending (rad/s).
    receptances
        R at each of them, shape (n, 8, 4), complex (m/N); for several harmonics shape (len(orders), n, 8, 4).
    orders
        Orders of the harmonics, ascending.

    Raises
    ------
    ValueError
        If speeds or orders are not ascending and positive, shapes do not match, or an R cannot be inverted (the
        message names the speed).
    """
    omega = np.asarray(speeds, dtype=np.float64)
    r = np.asarray(receptances, dtype=np.complex128)
    ascending = omega.ndim == 1 and omega.size > 0 and np.isfinite(omega).all() and (np.diff(omega) > 0.0).all()
    if not ascending or omega[0] <= 0.0:
        raise ValueError(f"speeds = {omega} rad/s is not allowed; they must be > 0 rad/s, finite and ascending")
    allowed = range(1, LARGEST_ORDER + 1)
    if not orders or any(n not in allowed for n in orders) or list(orders) != sorted(set(orders)):
        raise ValueError(f"orders = {list(orders)} is not allowed; they must ascend, from 1 to {LARGEST_ORDER}")
    shape = (omega.size, N_SENSORS, N_AXES)
    if r.shape not in ((len(orders), *shape), *((shape,) if len(orders) == 1 else ())):
        raise ValueError(
            f"receptances of shape {r.shape} is not allowed; {omega.size} speeds need "
            f"{shape if len(orders) == 1 else (len(orders), *shape)}"
        )
    by_order = r.reshape(len(orders), *shape)
    return pack_rows((n, omega[k], by_order[i, k]) for i, n in enumerate(orders) for k in range(omega.size))


def pack_rows(rows: Iterable[tuple[int, float, Complex]]) -> NDArray[np.float64]:
    """Constants of the controller from (order, speed, R), ascending in order and speed; see `pack`.

    They are laid out as `rolac_controller.receptance_table` reads them.
    """
    packed = []
    for order, speed, receptance in rows:
        try:
            h = inverse_receptance(receptance)
        except ValueError as error:
            raise ValueError(f"at {speed:g} rad/s: {error}") from error
        packed.append((order, speed, receptance, h))
    return np.concatenate([[float(len(packed))], np.array(packed, dtype=ROW).view(np.float64)])


def _weighted(receptance: ArrayLike, weights: ArrayLike | None) -> tuple[Complex, NDArray[np.float64]]:
    """W^(1/2) R and the diagonal of W^(1/2)."""
    r = np.asarray(receptance, dtype=np.complex128)
    w = np.ones(N_SENSORS) if weights is None else np.asarray(weights, dtype=np.float64)
    if r.shape != (N_SENSORS, N_AXES):
        raise ValueError(f"receptance of shape {r.shape} is not allowed; it must be ({N_SENSORS}, {N_AXES})")
    if not np.isfinite(r).all():
        raise ValueError("receptance is not allowed to hold numbers that are not finite")
    if w.shape != (N_SENSORS,) or not np.isfinite(w).all() or (w < 0.0).any():
        raise ValueError(f"weights = {w} is not allowed; they must be {N_SENSORS} finite numbers >= 0")
    root = np.sqrt(w)
    return root[:, None] * r, root
