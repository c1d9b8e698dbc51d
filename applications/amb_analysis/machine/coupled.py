"""The sampled loop of a machine with stages, and with other values of its constants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np

from amb_analysis.linear.components import LinearComponent
from amb_analysis.linear.linearisable import LinearSource
from amb_analysis.linear.loop import Loop
from amb_analysis.machine.machine import Machine
from amb_cosim.controllers.laws import Law
from amb_cosim.results.component_names import ACTUATOR, PLANT
from array_types import Array
from rotor_analysis.assembly import with_bearings
from rotor_analysis.parts import Bearing
from rotor_analysis.reduced_rotor import reduced_rotor


@dataclass(frozen=True)
class MachineVariation:
    """Factors on constants of a machine; 1 means no change.

    k_i, k_s
        Factors on the magnets' force over current and over displacement.
    modes
        Factors on the bending frequencies of the free rotor.
    """

    k_i: float = 1.0
    k_s: float = 1.0
    modes: float = 1.0


NOMINAL = MachineVariation()


@dataclass(frozen=True)
class CoupledMachine(LinearSource):
    """Source of linear models with additional coefficients at the rotor and other values of its constants.

    machine, others, variation
        The machine; seals and stages; factors on constants.
    """

    machine: Machine = field(kw_only=True)
    others: tuple[Bearing, ...] = field(default=(), kw_only=True)
    variation: MachineVariation = field(default=NOMINAL, kw_only=True)

    def parts(self, names: Sequence[str]) -> list[LinearComponent]:
        """Return the linear parts of components."""
        return [self._changed(name, part) for name, part in zip(names, super().parts(names), strict=True)]

    def _changed(self, name: str, part: LinearComponent) -> LinearComponent:
        if name == PLANT and (self.others or self.variation.modes != 1.0):
            return replace(part, law=self._coupled_rotor(part.law))
        if name == ACTUATOR and (self.variation.k_i, self.variation.k_s) != (1.0, 1.0):
            return replace(part, law=self._varied_magnets(part))
        return part

    def _coupled_rotor(self, law: Law) -> Law:
        """Return q'' = (M + dM)^-1 (f - (K + dK) q - (C + dC) q') in the coordinates of the plant."""
        Omega = self._speed(PLANT)
        M, K, right, left = self._keep("reduction", lambda: _reduced(self.machine))
        n = len(M)
        dK, dC, dM = (np.zeros((n, n)) for _ in range(3))
        for item in self.others:
            rows = [2 * 2 * (item.node - 1), 2 * 2 * (item.node - 1) + 1]
            for whole, at_place in zip((dK, dC, dM), item.at(Omega), strict=True):
                whole += left[:, rows] @ at_place @ right[rows]
        dK = dK + (self.variation.modes**2 - 1.0) * K
        back = np.linalg.inv(M + dM)
        A, B = law.A.copy(), law.B.copy()
        A[n:] = back @ (M @ law.A[n:] - np.hstack([dK, dC]))
        B[n:] = back @ M @ law.B[n:]
        return Law(A, B, law.C, law.D, law.sample_time)

    def _varied_magnets(self, part: LinearComponent) -> Law:
        """Return the actuator with its forces over displacement and over current multiplied."""
        law, v = part.law, self.variation
        C, D = law.C.copy(), law.D.copy()
        forces = [k for k, name in enumerate(part.outputs) if ".f_" in name]
        displacements = [k for k, name in enumerate(part.inputs) if name.endswith((".x", ".y"))]
        others = [k for k in range(len(part.inputs)) if k not in displacements]
        C[forces] *= v.k_i
        D[np.ix_(forces, others)] *= v.k_i
        D[np.ix_(forces, displacements)] *= v.k_s
        return Law(law.A, law.B, C, D, law.sample_time)


def coupled_loop(machine: Machine, others: tuple[Bearing, ...] = (), variation: MachineVariation = NOMINAL) -> Loop:
    """Return the sampled loop of a machine with seals and stages, and with factors on its constants."""
    made = machine.linear_components
    retained = {f.name: getattr(made, f.name) for f in fields(LinearSource) if f.init}
    return Loop(CoupledMachine(**retained, machine=machine, others=others, variation=variation))


def _reduced(machine: Machine) -> tuple[Array, Array, Array, Array]:
    """Return M of the plant with its seals, K without, and `right` and `left` of `Reduction` with them."""
    reduction = reduced_rotor(machine.rotor)
    model = reduction.model
    first = [row for rows in model.translations.values() for row in rows]
    order = first + [row for row in range(model.size) if row not in set(first)]
    at = np.ix_(order, order)
    return (
        with_bearings(model, machine.rotor.seals).at(0.0).M[at],
        model.K[at],
        reduction.right[:, order],
        reduction.left[order],
    )
