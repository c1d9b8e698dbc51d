"""Steady response to unbalance: x = Re[X exp(i theta)], y = Re[Y exp(i theta)] at every node."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np

from amb_files.checks import require
from array_types import Array, Complex
from rotor_analysis.assembly import Matrices
from rotor_analysis.parts import Point, seat
from rotor_analysis.supported_rotor import SupportedRotor

Stiffness = Callable[[float], Complex]
"""Dynamic stiffness (N/m) as a function of the spin speed (rad/s)."""


def dynamic_stiffness(model: Matrices, Omega: float, omega: float | Array | Complex | None = None) -> Complex:
    """Return the dynamic stiffness, -omega^2 M + i omega (C + Omega G) + K + D (N/m), shape (size, size).

    D is the hysteretic damping (`hysteresis`). With frequencies of shape (n,) the result has the shape (n, size, size).

    Parameters
    ----------
    model
        A model with its bearings.
    Omega
        Spin speed (rad/s), positive from x to y.
    omega
        Frequency or frequencies of the force (rad/s); by default Omega. omega - i a is that of a force whose amplitude
        grows as exp(a t). Hysteretic damping depends only on the real part.
    """
    model = model.at(Omega)
    omegas = 1.0 * np.asarray(Omega if omega is None else omega)[..., np.newaxis, np.newaxis]
    stiffness = -(omegas**2) * model.M + 1j * omegas * (model.C + Omega * model.G) + model.K
    if model.hysteresis is not None:
        hysteretic = np.array([model.hysteresis.stiffness(float(w), Omega) for w in omegas.real.ravel()])
        stiffness += hysteretic.reshape(stiffness.shape)
    return np.asarray(stiffness)


def unbalance_response(
    rotor_model: SupportedRotor, unbalance: Mapping[Point, complex], speeds: Array, nodes: tuple[int, ...]
) -> Complex:
    """Return the complex amplitudes of the synchronous motion.

    [-Omega^2 M + i Omega (C + Omega G) + K + D] Q = Omega^2 (u, -i u)

    Parameters
    ----------
    rotor_model
        The rotor on its bearings, full or condensed. Unbalance at a node that is not a master acts through (3.13).
    unbalance
        Complex unbalance u exp(i phi) (kg m), by node number or by centre of mass off its node; at theta + phi = 0 the
        unbalance pulls along x.
    speeds
        Spin speeds (rad/s), shape (n,).
    nodes
        Node numbers whose motion is returned.

    Returns
    -------
    array, shape (n, len(nodes), 2), complex
        X and Y (m).

    Raises
    ------
    ValueError
        If a node does not exist, if a value is not finite, or if an undamped rotor is run at its critical speed.
    """
    stiffness = partial(dynamic_stiffness, rotor_model.model)
    return np.asarray(synchronous_motion(rotor_model, stiffness, [unbalance], speeds, nodes)[:, 0])


def synchronous_motion(
    rotor_model: SupportedRotor,
    stiffness: Stiffness,
    cases: Sequence[Mapping[Point, complex]],
    speeds: Array,
    nodes: tuple[int, ...],
) -> Complex:
    """Return the complex X and Y (m) at nodes for several cases of unbalance, shape (speeds, cases, nodes, 2).

    stiffness(Omega) Q = Omega^2 (u, -i u)

    Parameters
    ----------
    rotor_model, speeds, nodes
        As for `unbalance_response`.
    stiffness
        Dynamic stiffness of the rotor with all its supports, in the coordinates of `rotor_model`.
    cases
        For each case, the unbalance (kg m) by node or centre of mass.

    Raises
    ------
    ValueError
        As `unbalance_response`.
    """
    to_nodes = rotor_model.displacement_of(nodes)
    loads = np.stack([unbalance_vector(rotor_model, case) for case in cases], axis=1)
    result = np.empty((len(speeds), len(cases), len(nodes), 2), dtype=np.complex128)
    for k, Omega in enumerate(map(float, speeds)):
        require(bool(np.isfinite(Omega)), "Omega", f"{Omega} rad/s", "finite")
        try:
            motion = to_nodes @ np.linalg.solve(stiffness(Omega), Omega**2 * loads)
        except np.linalg.LinAlgError as error:
            raise ValueError(
                f"Omega = {Omega} rad/s is a critical speed of an undamped rotor: there is no steady state"
            ) from error
        result[k] = motion.T.reshape(len(cases), -1, 2)
    return result


def unbalance_vector(rotor_model: SupportedRotor, unbalance: Mapping[Point, complex]) -> Complex:
    """Return the unbalance (kg m) in the model's coordinates, shape (size,): synchronous force divided by Omega^2."""
    for point, u in unbalance.items():
        require(bool(np.isfinite(u)), f"unbalance at node {seat(point)}", f"{u} kg m", "finite")
    components = np.array([component for u in unbalance.values() for component in (u, -1j * u)], dtype=np.complex128)
    return np.asarray(rotor_model.force_at(tuple(unbalance)) @ components)


def orbit(amplitudes: Complex) -> tuple[Array, Array, Array]:
    """Return the semi-axes and phases of the elliptic orbits whose complex amplitudes are X and Y.

    x + i y = r_f exp(i theta) + r_b exp(-i theta),  r_f = (X + i Y) / 2,  r_b = conj(X - i Y) / 2

    Parameters
    ----------
    amplitudes
        X and Y in the last axis, shape (..., 2).

    Returns
    -------
    major, minor, phase
        Semi-axes |r_f| + |r_b| and |r_f| - |r_b| (m; backward if minor < 0), and the angle of r_f (rad), by which the
        forward part leads the x axis at theta = 0. Shape (...) each.
    """
    x, y = amplitudes[..., 0], amplitudes[..., 1]
    forward, backward = 0.5 * (x + 1j * y), 0.5 * (x - 1j * y)
    return np.abs(forward) + np.abs(backward), np.abs(forward) - np.abs(backward), np.angle(forward)
