"""The sampled loop of a machine with varied constants and additional bearings, such as the cross coupling of stages."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from amb_analysis.linear.components import LinearComponent
from amb_analysis.linear.linear_source import LinearSource
from amb_analysis.linear.loop import Loop
from amb_analysis.machine.machine import Machine
from amb_cosim.controllers.laws import Law
from amb_cosim.results.component_names import ACTUATOR, PLANT
from array_types import Array
from rotor_analysis.assembly import with_bearings
from rotor_analysis.parts import Bearing
from rotor_analysis.reduction import reduce_by


@dataclass(frozen=True)
class MachineVariation:
    """Factors by which constants of a machine are multiplied; 1 means no change.

    k_i, k_s
        Factors on the magnets' force per current and force per displacement.
    modes
        Factors on the bending frequencies of the free rotor.
    """

    k_i: float = 1.0
    k_s: float = 1.0
    modes: float = 1.0


NOMINAL = MachineVariation()


def coupled_loop(machine: Machine, others: tuple[Bearing, ...] = (), variation: MachineVariation = NOMINAL) -> Loop:
    """Return the sampled loop of a machine with the bearings `others` added, and with factors on its constants.

    Calls with the same arguments return the same loop, so analyses share the poles that are computed for it.
    """
    source = machine.linear_components

    def changed(at: LinearSource, name: str, part: LinearComponent) -> Law:
        if name == PLANT and (others or variation.modes != 1.0):
            return _coupled_rotor(machine, at, part.law, others, variation.modes)
        if name == ACTUATOR and (variation.k_i, variation.k_s) != (1.0, 1.0):
            return _varied_magnets(part, variation)
        return part.law

    loop: Loop = source.cached(f"loop with {others!r}, {variation!r}", lambda: Loop(replace(source, changed=changed)))
    return loop


def _coupled_rotor(machine: Machine, at: LinearSource, law: Law, others: tuple[Bearing, ...], modes: float) -> Law:
    """Return q'' = (M + dM)^-1 (f - (K + dK) q - (C + dC) q') in the plant's coordinates; other states are kept."""
    M, K, right, left = at.cached("reduction", lambda: _reduced(machine))
    n, Omega = len(M), at.speed_of(PLANT)
    dK, dC, dM = (np.zeros((n, n)) for _ in range(3))
    for bearing in others:
        first = 2 * 2 * (bearing.node - 1)
        for part, rows in ((bearing, [first, first + 1]), (bearing.tilting, [first + 2, first + 3])):
            if part is not None:
                for added, coefficients in zip((dK, dC, dM), part.at(Omega), strict=True):
                    added += left[:, rows] @ coefficients @ right[rows]
    dK = dK + (modes**2 - 1.0) * K
    inverse = np.linalg.inv(M + dM)
    A, B = law.A.copy(), law.B.copy()
    lateral = slice(n, 2 * n)
    A[lateral] = inverse @ M @ law.A[lateral]
    A[lateral, : 2 * n] -= inverse @ np.hstack([dK, dC])
    B[lateral] = inverse @ M @ law.B[lateral]
    return Law(A, B, law.C, law.D, law.sample_time)


def _varied_magnets(part: LinearComponent, v: MachineVariation) -> Law:
    """Return the law of the actuator with factors on its force per current and force per displacement."""
    law = part.law
    C, D = law.C.copy(), law.D.copy()
    forces = [k for k, name in enumerate(part.outputs) if ".f_" in name]
    displacements = [k for k, name in enumerate(part.inputs) if name.endswith((".x", ".y", ".z"))]
    others = [k for k in range(len(part.inputs)) if k not in displacements]
    C[forces] *= v.k_i
    D[np.ix_(forces, others)] *= v.k_i
    D[np.ix_(forces, displacements)] *= v.k_s
    return Law(law.A, law.B, C, D, law.sample_time)


def _reduced(machine: Machine) -> tuple[Array, Array, Array, Array]:
    """Return the plant's M with seals, its K without seals, and `right` and `left` of its `Reduction`."""
    reduction = machine.sampled_rotor
    model, order = reduction.model, reduction.model.translations_first
    at = np.ix_(order, order)
    with_seals = with_bearings(machine.free, machine.rotor.seals)
    M = reduce_by(with_seals, model.translations, reduction.right, reduction.left).model.at(0.0).M
    return M[at], model.K[at], reduction.right[:, order], reduction.left[order]
