"""Stiffness, damping and mass that a place of the rotor feels beside its own seals: stages, cross-coupled, over speed.

    f = -(K(Omega) q + C(Omega) q' + M(Omega) q''),   q = (x, y) at the place                     (1)

A stage drives forward whirl with K = Q [[0, 1], [-1, 0]]: on a forward circle q = (cos, sin), f = Q (-sin, cos), which
points along the velocity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from amb_cosim.assessment.machine_file import WHIRL
from amb_cosim.assessment.subject import Subject
from fmi_export.model import Array
from rotor_analysis.assembly import Matrices
from rotor_analysis.parts import Bearing

Triple = tuple[Array, Array, Array]  # K (N/m), C (N s/m), M (kg), shape (2, 2) each


@dataclass(frozen=True)
class SupportCoefficients:
    """What a place of the rotor feels: its name, its node, and K, C and M of (1) over the spin speed (rad/s)."""

    name: str
    node: int
    at: Callable[[float], Triple]

    def added_to(self, model: Matrices, Omega: float) -> Matrices:
        """Return a model with them, whose node keeps its translations."""
        K, C, M = self.at(Omega)
        rows = np.ix_(model.translations[self.node], model.translations[self.node])
        stiff, damped, heavy = model.K.copy(), model.C.copy(), model.M.copy()
        stiff[rows] += K
        damped[rows] += C
        heavy[rows] += M
        return replace(model, K=stiff, C=damped, M=heavy)


def cross_coupling(name: str, node: int, Q: float) -> SupportCoefficients:
    """Return a cross-coupled stiffness Q (N/m) that drives forward whirl."""
    zero = np.zeros((2, 2))
    return SupportCoefficients(name, node, lambda Omega: (Q * WHIRL, zero, zero))


def anticipated(subject: Subject, factor: float = 1.0) -> tuple[SupportCoefficients, ...]:
    """Return the anticipated coupling of the stages at the largest speed times a factor, in place of the rotor's seals.

    So level I has it: rotor, bearings, and one coupling for whatever drives whirl.
    """
    speed = subject.file.speed.highest
    stages = (cross_coupling(s.at, subject.node_of(s.at), factor * s.anticipated(speed)) for s in subject.file.stages)
    return (*stages, *(_taken_away(seal) for seal in subject.rotor.seals))


def real_coefficients(subject: Subject) -> tuple[SupportCoefficients, ...]:
    """Return the stages by the better calculation of level II, the anticipated coupling where there is none.

    The rotor's seals are in its own model.
    """
    speed, result = subject.file.speed.highest, []
    for stage in subject.file.stages:
        node, bearing = subject.node_of(stage.at), stage.coefficients()
        local = cross_coupling(stage.at, node, stage.level_two(speed)) if bearing is None else None
        result.append(local or SupportCoefficients(stage.at, node, bearing.at))  # type: ignore[union-attr]
    return tuple(result)


def _taken_away(seal: Bearing) -> SupportCoefficients:
    def at(Omega: float) -> Triple:
        K, C, M = seal.at(Omega)
        return -K, -C, -M

    return SupportCoefficients(seal.name, seal.node, at)
