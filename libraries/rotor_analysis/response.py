"""Steady response to unbalance: x = Re[X exp(i theta)], y = Re[Y exp(i theta)] at every node."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fmi_export.model import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.modes import Complex
from rotor_analysis.rotor import require
from rotor_analysis.supported import Supported


def dynamic_stiffness(model: Matrices, Omega: float) -> Complex:
    """Stiffness against a synchronous force, -Omega^2 M + i Omega (C + Omega G) + K (N/m), shape (size, size)."""
    return np.asarray(-(Omega**2) * model.M + 1j * Omega * (model.C + Omega * model.G) + model.K)


def unbalance_response(
    support: Supported, unbalance: Mapping[int, complex], speeds: Array, nodes: tuple[int, ...]
) -> Complex:
    """Complex amplitudes of the synchronous motion.

    [-Omega^2 M + i Omega (C + Omega G) + K] Q = Omega^2 (u, -i u)

    Parameters
    ----------
    support
        The rotor on its bearings, in full or condensed. Unbalance at a node that is no master acts through (3.13).
    unbalance
        Node number to complex unbalance u exp(i phi) (kg m); at theta + phi = 0 it pulls along x.
    speeds
        Spin speeds (rad/s), shape (n,).
    nodes
        Node numbers to look at.

    Returns
    -------
    array, shape (n, len(nodes), 2), complex
        X and Y (m).

    Raises
    ------
    ValueError
        If a node does not exist, a value is not finite, or an undamped rotor is run at its critical speed.
    """
    out = support.displacement_of(nodes)
    force = unit_force(support, unbalance)
    amplitudes = np.empty((len(speeds), len(nodes), 2), dtype=np.complex128)
    for k, Omega in enumerate(speeds):
        require(bool(np.isfinite(Omega)), "Omega", f"{Omega} rad/s", "finite")
        amplitudes[k] = (out @ steady_state(support.model, float(Omega), force)).reshape(-1, 2)
    return amplitudes


def unit_force(support: Supported, unbalance: Mapping[int, complex]) -> Complex:
    """Synchronous force of an unbalance on the model's coordinates, divided by Omega^2 (kg m), shape (model.size,)."""
    for node, u in unbalance.items():
        require(bool(np.isfinite(u)), f"unbalance at node {node}", f"{u} kg m", "finite")
    pull = np.array([component for u in unbalance.values() for component in (u, -1j * u)], dtype=np.complex128)
    return np.asarray(support.force_at(tuple(unbalance)) @ pull)


def steady_state(model: Matrices, Omega: float, unit: Complex) -> Complex:
    """Complex amplitude (m) of the model's coordinates under the force Omega^2 `unit` exp(i theta)."""
    stiffness = dynamic_stiffness(model, Omega)
    try:
        return np.asarray(np.linalg.solve(stiffness, Omega**2 * unit))
    except np.linalg.LinAlgError as error:
        raise ValueError(f"Omega = {Omega} rad/s is a critical speed of an undamped rotor: no steady state") from error


def orbit(amplitudes: Complex) -> tuple[Array, Array, Array]:
    """Size and place of the ellipses that complex amplitudes X, Y describe.

    x + i y = r_f exp(i theta) + r_b exp(-i theta),  r_f = (X + i Y) / 2,  r_b = conj(X - i Y) / 2

    Parameters
    ----------
    amplitudes
        X and Y in the last axis, shape (..., 2).

    Returns
    -------
    major, minor, phase
        Semi-axes |r_f| + |r_b| and |r_f| - |r_b| (m; minor < 0 turns backward), and the angle of r_f (rad), by which
        the forward part leads the x axis at theta = 0. Shape (...) each.
    """
    x, y = amplitudes[..., 0], amplitudes[..., 1]
    forward, backward = 0.5 * (x + 1j * y), 0.5 * (x - 1j * y)
    return np.abs(forward) + np.abs(backward), np.abs(forward) - np.abs(backward), np.angle(forward)
