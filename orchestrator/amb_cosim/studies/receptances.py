"""What the synchronous control stands on: the receptance of the levitated rotor, and its inverse H over speed."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from rich.table import Table

from amb_analysis.receptance_table import SPEEDS, condition_number, inverse_receptance, pack
from amb_cosim.cosim.values import quantity
from amb_cosim.studies import modal, rolac_figures
from amb_cosim.studies.outcome import Outcome
from amb_cosim.text_tables import labelled_table
from fmi_export.model import Array
from rolac_controller import stored
from rolac_controller.inverse import N_MATRIX
from rolac_controller.names import AXES, N_AXES, N_BEARINGS, N_PLANES, N_SENSORS
from rotor_analysis.modes import Complex
from rotor_analysis.receptance import receptance as receptance_of
from rotor_analysis.rotor import Rotor, require

HERTZ = 2.0 * np.pi  # rad/s
LOWEST = 1.0 * HERTZ
POINTS = 491  # of a range of speeds: every 0.1 Hz from 1 to 50 Hz
FORCES = tuple(f"{bearing}.{axis}" for bearing, axis, _ in AXES)


def receptance(rotor: Rotor, up_to: str, k_b: str, c_b: str) -> Outcome:
    """Synchronous displacement of the eight sensors by each bearing force over speed, from the model (Fig. 5.1)."""
    speeds = _speeds(up_to, LOWEST)
    R = _receptance(rotor, speeds, k_b, c_b)
    data: dict[str, Any] = {
        "rotor": rotor.name,
        "planes_z_m": _planes(rotor),
        "speeds_hz": (speeds / HERTZ).tolist(),
        "forces": list(FORCES),
        "receptance_m_per_N": _parts(R),
    }
    return Outcome(data, {"receptance": partial(rolac_figures.receptance, data)}, [_peaks(data, R)])


def h_matrix(rotor: Rotor, up_to: str, k_b: str, c_b: str) -> Outcome:
    """H over speed, exact and as the controller interpolates it between the speeds of its table (Fig. 5.3).

    Two measures of what interpolation costs: the relative error of H in the Frobenius norm, and |I + H R|, the largest
    share of a synchronous force that one full step U <- U + H Q leaves. It is zero for the exact H.
    """
    speeds = np.unique(np.concatenate([_speeds(up_to, SPEEDS[0]), SPEEDS]))
    R = _receptance(rotor, speeds, k_b, c_b)
    exact = np.array([inverse_receptance(r) for r in R])
    every_hertz = HERTZ * np.arange(5.0, np.ceil(speeds[-1] / HERTZ) + 1.0)
    tables = {"thesis": np.array(SPEEDS), "every_hertz": every_hertz}
    found = {name: interpolated(s, _receptance(rotor, s, k_b, c_b), speeds) for name, s in tables.items()}
    data: dict[str, Any] = {
        "rotor": rotor.name,
        "planes_z_m": _planes(rotor),
        "speeds_hz": (speeds / HERTZ).tolist(),
        "table_hz": [speed / HERTZ for speed in SPEEDS],
        "forces": list(FORCES),
        "h_N_per_m": _parts(exact),
        "h_interpolated_N_per_m": _parts(found["thesis"]),
        "condition_number": [condition_number(r) for r in R],
        "tables": {
            name: {"relative_error": _errors(H, exact).tolist(), "left_by_a_step": _left(H, R).tolist()}
            for name, H in found.items()
        },
    }
    return Outcome(data, {"h_matrix": partial(rolac_figures.h_matrix, data)}, [_intervals(data)])


def interpolated(table_speeds: Array, receptances: Complex, speeds: Array) -> Complex:
    """H at some speeds as the controller takes it from a table: linear between the table's speeds, constant beyond.

    Parameters
    ----------
    table_speeds, receptances
        Speeds of the table (rad/s), shape (m,), ascending, and R there (m/N), shape (m, 8, 4).
    speeds
        Where H is wanted (rad/s), shape (n,).

    Returns
    -------
    array, shape (n, 4, 8), complex
        N/m.

    Raises
    ------
    ValueError
        If an R cannot be inverted.
    """
    table = pack(table_speeds, receptances)
    H, matrix = np.empty((len(speeds), N_AXES, N_SENSORS), dtype=np.complex128), np.empty(N_MATRIX)
    for n, speed in enumerate(speeds):
        low, high, share, _ = stored.bracket(table, 1.0, float(speed))
        stored.interpolate(table, stored.H, low, high, share, matrix)
        H[n] = matrix.view(np.complex128).reshape(N_AXES, N_SENSORS)
    return H


def _receptance(rotor: Rotor, speeds: Array, k_b: str, c_b: str) -> Complex:
    planes = rotor.planes
    for what, nodes, wanted in (
        ("bearings", rotor.bearing_nodes, N_BEARINGS),
        ("planes.sensors", planes.sensors, N_PLANES),
    ):
        require(len(nodes) == wanted, f"{what} of rotor {rotor.name!r}", list(nodes), f"{wanted} nodes")
    require(bool(planes.master), f"planes.master of rotor {rotor.name!r}", "[]", "the planes of the reduced model")
    stiffness, damping = quantity(k_b, "N/m", "k-b"), quantity(c_b, "N.s/m", "c-b")
    require(0.0 < stiffness < np.inf, "k-b", f"{stiffness:g} N/m", "> 0 N/m")
    require(0.0 < damping < np.inf, "c-b", f"{damping:g} N s/m", "> 0 N s/m, since nothing else damps the rotor")
    return receptance_of(speeds, stiffness, damping, rotor)


def _speeds(up_to: str, lowest: float) -> Array:
    highest = modal.speed(up_to, "up-to")
    require(highest > lowest, "up-to", f"{highest:g} rad/s", f"> {lowest:.4g} rad/s")
    return np.linspace(lowest, highest, POINTS)


def _errors(H: Complex, exact: Complex) -> Array:
    return np.linalg.norm(H - exact, axis=(1, 2)) / np.linalg.norm(exact, axis=(1, 2))


def _left(H: Complex, R: Complex) -> Array:
    return np.linalg.norm(np.eye(N_AXES) + H @ R, ord=2, axis=(1, 2))


def _planes(rotor: Rotor) -> list[float]:
    return [rotor.shaft.nodes[node - 1] for node in rotor.planes.sensors]


def _parts(matrices: Complex) -> dict[str, Any]:
    return {"real": matrices.real.tolist(), "imaginary": matrices.imag.tolist()}


def _peaks(data: dict[str, Any], R: Complex) -> Table:
    """Where each sensor is moved most by the force in its own direction."""
    table = labelled_table(
        f"{data['rotor']}: largest receptance of the sensors in x",
        "sensor",
        "force",
        "(um/N)",
        "at (Hz)",
        "phase (deg)",
    )
    for plane, z in enumerate(data["planes_z_m"]):
        for k in range(0, N_AXES, 2):
            curve = R[:, 2 * plane, k]
            top = int(np.argmax(np.abs(curve)))
            table.add_row(
                f"s{2 * plane + 1}, z = {z:.4g} m",
                FORCES[k],
                f"{1e6 * abs(curve[top]):.3f}",
                f"{data['speeds_hz'][top]:.2f}",
                f"{np.degrees(np.angle(curve[top])):.1f}",
            )
    return table


def _intervals(data: dict[str, Any]) -> Table:
    """The worst place between neighbouring speeds of the thesis's table."""
    table = labelled_table(
        f"{data['rotor']}: H interpolated between the speeds of the table",
        "between (Hz)",
        "largest error of H (%)",
        "at (Hz)",
        "left by a full step (%)",
        "condition number of R",
    )
    speeds, errors = np.array(data["speeds_hz"]), np.array(data["tables"]["thesis"]["relative_error"])
    left, condition = np.array(data["tables"]["thesis"]["left_by_a_step"]), np.array(data["condition_number"])
    edges = [*data["table_hz"], max(speeds[-1], data["table_hz"][-1])]
    for low, high in pairwise(edges):
        within = np.flatnonzero((speeds >= low) & (speeds <= high))
        if low < high and len(within) > 1:
            worst = within[np.argmax(errors[within])]
            table.add_row(
                f"{low:g} to {high:g}" + (", beyond the table" if low == data["table_hz"][-1] else ""),
                f"{100.0 * errors[worst]:.2f}",
                f"{speeds[worst]:.2f}",
                f"{100.0 * left[within].max():.2f}",
                f"{condition[within].max():.1f}",
            )
    return table
