"""Synchronous response of a rotor in its bearings, peaks of it, and their amplification.

    [-Omega^2 M + i Omega (C + Omega G) + K - F(i Omega)] Q = Omega^2 (u, -i u)                   (1)

F are the forces of the magnetic bearings (`feedback`), M, C, G and K those of the rotor with everything else that
supports it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from amb_cosim.machine.coefficients import SupportCoefficients
from amb_cosim.machine.feedback import bearing_forces
from amb_cosim.machine.machine import Machine
from amb_cosim.results.component_names import PLANT
from array_types import Array, Complex
from rotor_analysis.assembly import Matrices, with_bearings
from rotor_analysis.response import dynamic_stiffness, orbit, unbalance_vector

FINE = 40  # speeds about each peak
HALF_POWER = 1.0 / np.sqrt(2.0)


@dataclass(frozen=True)
class Peak:
    """A critical speed of a response.

    Omega, amplitude
        Speed (rad/s) and amplitude at the peak.
    amplification
        AF = Omega/(Omega_2 - Omega_1), the speeds where the amplitude is 1/sqrt(2) of the peak.
    from_single_side
        Whether only one of these speeds was found, and the width is twice the distance to it.
    """

    Omega: float
    amplitude: float
    amplification: float
    from_single_side: bool = False


def passive(machine: Machine, Omega: float, others: tuple[SupportCoefficients, ...] = ()) -> Matrices:
    """Return the condensed rotor with its seals, passive bearings and other coefficients, at a spin speed (rad/s)."""
    model, local = with_bearings(machine.free_rotor.model, machine.rotor.seals).at(Omega), machine.parameters[PLANT]
    for bearing in machine.rotor.bearings:
        k, c = (local.get(f"{bearing.name}.{name}", 0.0) for name in ("k_b", "c_b"))
        model = model.with_bearing(bearing.node, k * np.eye(2), c * np.eye(2))
    for item in others:
        model = item.added_to(model, Omega)
    return model


def synchronous_response(
    machine: Machine,
    speeds: Array,
    cases: Sequence[Mapping[int, complex]],
    others: tuple[SupportCoefficients, ...] = (),
) -> Complex:
    """Return the displacements (m) of all nodes at speeds (rad/s) under unbalance, shape (speeds, cases, nodes, 2).

    Parameters
    ----------
    machine
        The machine.
    speeds
        Spin speeds (rad/s), above 0, shape (n,).
    cases
        Unbalance (kg m) by node, of each case.
    others
        Seals and stages.
    """
    rotor = machine.free_rotor
    nodes = tuple(sorted(rotor.model.translations))
    displayed, held = rotor.displacement_of(rotor.nodes), rotor.model.rows(nodes)
    retained = [2 * (node - 1) + k for node in nodes for k in (0, 1)]
    loads = np.stack([unbalance_vector(rotor, case) for case in cases], axis=1)
    result = np.empty((len(speeds), len(cases), len(machine.z), 2), dtype=np.complex128)
    for k, Omega in enumerate(map(float, speeds)):
        forces = bearing_forces(machine, Omega, Omega)[np.ix_(retained, retained)]
        stiffness = dynamic_stiffness(passive(machine, Omega, others), Omega)
        stiffness[np.ix_(held, held)] -= forces
        motion = displayed @ np.linalg.solve(stiffness, Omega**2 * loads)
        result[k] = motion.T.reshape(len(cases), -1, 2)
    return result


def refined_response(
    machine: Machine,
    speeds: Array,
    cases: Sequence[Mapping[int, complex]],
    nodes: Sequence[int],
    others: tuple[SupportCoefficients, ...] = (),
) -> tuple[Array, Complex]:
    """Return speeds (rad/s), closer where the motion of a node peaks, and the `synchronous_response` at these.

    Parameters
    ----------
    machine, cases, others
        As for `synchronous_response`.
    speeds
        Speeds (rad/s) that are to be among the result, ascending, above 0, shape (n,).
    nodes
        Nodes whose peaks matter.
    """
    rough = synchronous_response(machine, speeds, cases, others)
    amplitudes, step = orbit(rough)[0], float(np.median(np.diff(speeds)))
    tops = sorted(
        {
            peak.Omega
            for k in range(len(cases))
            for node in nodes
            for peak in peaks_of(speeds, amplitudes[:, k, node - 1])
            if peak.amplification > 0.05 * peak.Omega / step
        }
    )
    merged = [top for k, top in enumerate(tops) if k == 0 or top - tops[k - 1] > step]
    fine = {top + step * t for top in merged for t in 2.5 * np.linspace(-1.0, 1.0, FINE) ** 3}
    extra = np.array(sorted(w for w in fine - {*map(float, speeds)} if w > 0.0))
    if not len(extra):
        return speeds, rough
    order = np.argsort(np.concatenate([speeds, extra]))
    close = synchronous_response(machine, extra, cases, others)
    return np.concatenate([speeds, extra])[order], np.concatenate([rough, close])[order]


def peaks_of(speeds: Array, amplitudes: Array) -> list[Peak]:
    """Return the peaks of a response, with their amplification by the half-power width.

    A maximum is not a peak if the amplitude falls to 1/sqrt(2) on neither side before it rises higher.

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
    return Peak(Omega, height, Omega / (2.0 * abs(Omega - end)), from_single_side=True)


def separation_margin(Omega: float, lowest: float, highest: float) -> float:
    """Return the distance (%) of a critical speed from the operating speeds, over the nearer end; negative within."""
    if Omega < lowest:
        return 100.0 * (lowest - Omega) / lowest
    if Omega > highest:
        return 100.0 * (Omega - highest) / highest
    return -100.0 * min((Omega - lowest) / lowest, (highest - Omega) / highest)
