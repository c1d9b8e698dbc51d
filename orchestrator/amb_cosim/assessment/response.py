"""Synchronous response of a rotor in its bearings, peaks of it, and their amplification.

    [-Omega^2 M + i Omega (C + Omega G) + K - F(i Omega)] Q = Omega^2 (u, -i u)                   (1)

F are the forces of the magnetic bearings (`feedback`), M, C, G and K the rotor with what else holds it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from amb_cosim.assessment.coefficients import SupportCoefficients
from amb_cosim.assessment.feedback import Complex, bearing_forces
from amb_cosim.assessment.subject import Subject
from amb_cosim.results.places import PLANT
from fmi_export.model import Array
from rotor_analysis.assembly import Matrices, with_bearings

HALF_POWER = 1.0 / np.sqrt(2.0)


@dataclass(frozen=True)
class Peak:
    """A critical speed of a response.

    Omega, amplitude
        Speed (rad/s) and amplitude at the peak.
    amplification
        AF = Omega/(Omega_2 - Omega_1), the speeds where the amplitude is 1/sqrt(2) of the peak.
    one_sided
        Whether only one of these speeds was found, and the width is twice the distance to it.
    """

    Omega: float
    amplitude: float
    amplification: float
    one_sided: bool = False


def passive(subject: Subject, Omega: float, others: tuple[SupportCoefficients, ...] = ()) -> Matrices:
    """Return the condensed rotor with its seals, passive bearings and other coefficients, at a spin speed (rad/s)."""
    model, local = with_bearings(subject.condensed.model, subject.rotor.seals).at(Omega), subject.parameters[PLANT]
    for bearing in subject.rotor.bearings:
        k, c = (local.get(f"{bearing.name}.{name}", 0.0) for name in ("k_b", "c_b"))
        model = model.with_bearing(bearing.node, k * np.eye(2), c * np.eye(2))
    for item in others:
        model = item.added_to(model, Omega)
    return model


def dynamic_stiffness(model: Matrices, forces: Complex, Omega: float) -> Complex:
    """Return the matrix of (1): forces over displacements of all degrees of freedom (N/m).

    Parameters
    ----------
    model
        Rotor and passive parts at this speed.
    forces
        Forces of the magnetic bearings over displacements, x and y of each of the model's nodes in turn.
    Omega
        Spin speed, and frequency (rad/s).
    """
    stiffness = (model.K - Omega**2 * model.M).astype(np.complex128)
    stiffness += 1j * Omega * (model.C + Omega * model.G)
    at = [row for node in sorted(model.translations) for row in model.translations[node]]
    stiffness[np.ix_(at, at)] -= forces
    return stiffness


def unbalance_vector(model: Matrices, unbalance: Mapping[int, complex]) -> Complex:
    """Return the unbalance (kg m) by node as the force of (1) over Omega^2, shape (size,)."""
    force = np.zeros(model.size, dtype=np.complex128)
    for node, u in unbalance.items():
        x, y = model.translations[node]
        force[x] += u
        force[y] += -1j * u
    return force


def synchronous_response(
    subject: Subject,
    speeds: Array,
    cases: Sequence[Mapping[int, complex]],
    others: tuple[SupportCoefficients, ...] = (),
) -> Complex:
    """Return the displacements (m) of all nodes at speeds (rad/s) under unbalance, shape (speeds, cases, nodes, 2).

    Parameters
    ----------
    subject
        The machine.
    speeds
        Spin speeds (rad/s), above 0, shape (n,).
    cases
        Unbalance (kg m) by node, of each case.
    others
        Seals and stages.
    """
    reduction, free = subject.condensed, subject.free
    displayed = [row for node in sorted(free.translations) for row in free.translations[node]]
    retained = [2 * (node - 1) + k for node in sorted(reduction.model.translations) for k in (0, 1)]
    loads = reduction.left @ np.stack([unbalance_vector(free, case) for case in cases], axis=1)
    result = np.empty((len(speeds), len(cases), len(subject.z), 2), dtype=np.complex128)
    for k, Omega in enumerate(map(float, speeds)):
        forces = bearing_forces(subject, Omega, Omega)[np.ix_(retained, retained)]
        stiffness = dynamic_stiffness(passive(subject, Omega, others), forces, Omega)
        motion = reduction.right[displayed] @ np.linalg.solve(stiffness, Omega**2 * loads)
        result[k] = motion.T.reshape(len(cases), -1, 2)
    return result


def peaks_of(speeds: Array, amplitudes: Array) -> list[Peak]:
    """Return the peaks of a response, with their amplification by the half-power width.

    A maximum from which the amplitude does not fall to 1/sqrt(2) on either side, before it rises higher, is no peak.

    Parameters
    ----------
    speeds
        Ascending (rad/s), shape (n,), close enough for the cubic spline through the amplitudes.
    amplitudes
        Amplitudes there, shape (n,).
    """
    from scipy.interpolate import CubicSpline

    curve = CubicSpline(speeds, amplitudes)
    slope = curve.derivative()
    result = []
    for Omega in slope.roots(extrapolate=False):
        if slope(Omega, 1) < 0.0:
            height = float(curve(Omega))
            ends = curve.solve(HALF_POWER * height, extrapolate=False)
            before = _nearest(ends[ends < Omega][::-1], Omega, height, speeds, amplitudes)
            after = _nearest(ends[ends > Omega], Omega, height, speeds, amplitudes)
            if before is not None or after is not None:
                result.append(_peak(float(Omega), height, before, after))
    return result


def _nearest(ends: Array, Omega: float, height: float, speeds: Array, amplitudes: Array) -> float | None:
    """Return the first of some speeds, unless the amplitude is higher than the peak before it."""
    if not len(ends):
        return None
    low, high = sorted((float(ends[0]), Omega))
    between = amplitudes[(speeds > low) & (speeds < high)]
    return float(ends[0]) if np.max(between, initial=0.0) <= height * (1.0 + 1e-6) else None


def _peak(Omega: float, height: float, before: float | None, after: float | None) -> Peak:
    if before is not None and after is not None:
        return Peak(Omega, height, Omega / (after - before))
    (end,) = (item for item in (before, after) if item is not None)
    return Peak(Omega, height, Omega / (2.0 * abs(Omega - end)), one_sided=True)


def separation_margin(Omega: float, lowest: float, highest: float) -> float:
    """Return the distance (%) of a critical speed from the operating speeds, over the nearer end; negative within."""
    if Omega < lowest:
        return 100.0 * (lowest - Omega) / lowest
    if Omega > highest:
        return 100.0 * (Omega - highest) / highest
    return -100.0 * min((Omega - lowest) / lowest, (highest - Omega) / highest)
