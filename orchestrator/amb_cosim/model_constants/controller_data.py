"""Computes H from receptances (thesis 5.10), and the constants of a controller FMU with a table of receptances."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

from amb_files.checks import errors_in
from array_types import Array, Complex
from rolac_controller.control_loop import ControlLoop
from rolac_controller.parameters import LARGEST_ORDER
from rolac_controller.sizes import KEY, SIZES

# A receptance is measured to about four digits; above this condition number none is significant in H.
MAX_CONDITION = 1e4

# Default speeds of a controller's table (rad/s).
SPEEDS = tuple(2.0 * np.pi * f for f in (5.0, 10.0, 15.0, 20.0, 22.0, 24.0, 25.0, 26.0, 27.0, 28.0, 29.0, 35.0))


def condition_number(receptance: ArrayLike) -> float:
    """Return the ratio of the largest to the smallest singular value of R; infinite if R is singular.

    The parameter and the errors are the same as for `inverse_receptance`, which allows at most MAX_CONDITION.
    """
    singular = np.linalg.svd(_checked(receptance), compute_uv=False)
    return float(singular[0] / singular[-1]) if singular[-1] > 0.0 else np.inf


def inverse_receptance(receptance: ArrayLike) -> Complex:
    """Return the matrix H of the adaptive law, the negative pseudo-inverse of the receptance.

    H = -(R^H R)^-1 R^H     (5.10), with equal weights of the sensors

    Parameters
    ----------
    receptance
        R, shape (n_sensors, n_axes), complex (m/N): rows are sensors, columns are forces of the bearings' axes.

    Returns
    -------
    ndarray
        H, shape (n_axes, n_sensors), complex (N/m).

    Raises
    ------
    ValueError
        If the shape is invalid, a number is not finite, or R is ill-conditioned.
    """
    condition = condition_number(receptance)
    if condition > MAX_CONDITION:
        raise ValueError(
            f"the condition number {condition:.3g} of the receptance matrix is not allowed; it must be at most "
            f"{MAX_CONDITION:g}, so that every combination of forces moves the sensors"
        )
    return np.asarray(-np.linalg.pinv(_checked(receptance), rcond=0.0), dtype=np.complex128)


def no_table(loop: ControlLoop) -> Array:
    """Return the constants of a controller without a table.

    All functions can be used except ROLAC, which must first identify H.
    """
    return pack_rows(loop, ())


def pack(loop: ControlLoop, speeds: ArrayLike, receptances: ArrayLike, orders: Sequence[int] = (1,)) -> Array:
    """Return the constants of a controller: R and H at a list of speeds.

    Parameters
    ----------
    loop
        Names of the controller's bearings and sensors.
    speeds
        Speeds, shape (n,), ascending (rad/s).
    receptances
        R at each speed, shape (n, n_sensors, n_axes), complex (m/N); for several harmonics the shape is (len(orders),
        n, ..).
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
        raise ValueError(f"orders = {list(orders)} is not allowed; orders must ascend and be from 1 to {LARGEST_ORDER}")
    shape = (omega.size, *loop.shape)
    if r.shape not in ((len(orders), *shape), *((shape,) if len(orders) == 1 else ())):
        raise ValueError(
            f"receptances of shape {r.shape} are not allowed; {omega.size} speeds require the shape "
            f"{shape if len(orders) == 1 else (len(orders), *shape)}"
        )
    by_order = r.reshape(len(orders), *shape)
    rows = ((n, omega[k], by_order[i, k]) for i, n in enumerate(orders) for k in range(omega.size))
    return pack_rows(loop, rows)


def pack_rows(
    loop: ControlLoop,
    rows: Iterable[tuple[int, float, Complex]],
    inner: Iterable[tuple[int, float, Complex]] = (),
) -> Array:
    """Return the constants of a controller from rows (order, speed, R), ascending in order and speed; see `pack`.

    The layout is described in `rolac_controller.sizes`, `inner_loop` and `receptance_table`. `inner` contains rows
    (order, speed, C) for a controller that closes the loop in parallel with the PID (`rolac_controller.inner_loop`).
    """
    keys, receptances, inverses = [], [], []
    for order, speed, receptance in rows:
        with errors_in(f"at {speed:g} rad/s"):
            inverses.append(inverse_receptance(receptance))
        keys.append((order, speed))
        receptances.append(receptance)
    names, responses = loop.sensor_names, list(inner)
    parts = (
        np.array([(len(loop.bearings), len(loop.planes))], dtype=SIZES),
        np.array([names.index(axis.sensor) for axis in loop.axes], dtype=np.float64),
        np.array([len(responses)], dtype=np.float64),
        np.array([(order, speed) for order, speed, _ in responses], dtype=KEY),
        np.array([C for *_, C in responses], dtype=np.complex128),
        np.array([len(keys)], dtype=np.float64),
        np.array(keys, dtype=KEY),
        np.array(receptances, dtype=np.complex128),
        np.array(inverses, dtype=np.complex128),
    )
    return np.concatenate([part.ravel().view(np.float64) for part in parts])


def _checked(receptance: ArrayLike) -> Complex:
    """Return R as an array; raise ValueError if it has fewer rows than columns, or numbers that are not finite."""
    r = np.asarray(receptance, dtype=np.complex128)
    if r.ndim != 2 or not 1 <= r.shape[1] <= r.shape[0]:
        raise ValueError(f"receptance of shape {r.shape} is not allowed; it must have at least as many rows as columns")
    if not np.isfinite(r).all():
        raise ValueError("receptance contains numbers that are not finite")
    return r
