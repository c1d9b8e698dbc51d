"""Reach of magnets and sensors at the bending modes of the free rotor.

If a bearing's control law answers a displacement at its sensor with a force at its magnet, a mode of modal mass m obeys

    m (q'' + 2 zeta w q' + w^2 q) = -sum_b phi_m phi_s (k + c d/dt) q                                  (1)

phi_m and phi_s are the values of the mode shape at the magnet and at the sensor. If phi_m phi_s < 0, a node of the mode
lies between magnet and sensor, and the damping c of the law drives the mode. The reach of a bearing is the square root
of |phi_m phi_s|, with the sign of phi_m phi_s, divided by the largest |phi|:

    r = sign(phi_m phi_s) sqrt(|phi_m phi_s|)/max|phi|                                                 (2)

The reach is 1 if magnet and sensor share an antinode, and 0 if either is at a node.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from array_types import Array
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.rotor import Rotor

SMALL = 0.02  # share of the largest value of a shape; positions with less are at a node of it
REACHED = 0.05  # least reach of a mode that is controlled


@dataclass(frozen=True)
class BearingReach:
    """A bearing, its nearest sensor plane, and a mode shape's values at both, relative to the shape's largest value."""

    bearing: str
    sensor: str
    at_magnet: float
    at_sensor: float

    @property
    def value(self) -> float:
        """The reach (2), from -1 to 1."""
        product = self.at_magnet * self.at_sensor
        return math.copysign(math.sqrt(abs(product)), product)

    @property
    def is_at_node(self) -> bool:
        """Whether the magnet or the sensor, or both, are at a node of the mode."""
        return min(abs(self.at_magnet), abs(self.at_sensor)) < SMALL

    @property
    def kind(self) -> str:
        """The reason why the bearing cannot damp the mode, in words; empty if it can."""
        if self.is_at_node:
            return "at a node"
        return "non-collocated" if self.value < 0.0 else ""


@dataclass(frozen=True, eq=False)
class ModeReach:
    """A bending mode of the free rotor: its number (from 1), its shape at all nodes, and its reach at each bearing."""

    number: int
    frequency: Annotated[float, "rad/s"]
    shape: Array
    bearings: tuple[BearingReach, ...]

    @property
    def deciding(self) -> BearingReach:
        """The bearing that drives the mode most, if any does; otherwise the bearing with the largest reach.

        A bearing with a reach below -`REACHED` drives the mode; to damp this mode, the law of the bearing would need
        the opposite phase.
        """
        worst = min(self.bearings, key=lambda bearing: bearing.value)
        return worst if worst.value < -REACHED else max(self.bearings, key=lambda bearing: bearing.value)


def mode_reaches(rotor: Rotor, magnets: Sequence[str], count: int) -> list[ModeReach]:
    """Return the first bending modes of the free rotor at rest, with the reach (2) of each magnet and its sensor.

    Parameters
    ----------
    rotor
        The rotor with its bearings and sensors.
    magnets
        Names of the bearings that are magnets.
    count
        Number of modes; fewer if the model has fewer. The sensor of a magnet is the one nearest to it.

    Raises
    ------
    ValueError
        If the rotor has no sensors.
    """
    if not rotor.sensors:
        raise ValueError(f"rotor {rotor.name} has no sensors")
    free, z = assemble(rotor), rotor.shaft.nodes
    frequencies, all_shapes = free_modes(free.M[::2, ::2], free.K[::2, ::2])
    shapes = all_shapes[::2][:, :count]
    shapes = shapes / shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]
    nodes = {bearing.name: bearing.node for bearing in rotor.bearings}
    pairs = [(b, min(rotor.sensors, key=lambda s, at=z[nodes[b] - 1]: abs(z[s.node - 1] - at))) for b in magnets]  # type: ignore[misc]
    return [
        ModeReach(
            k + 1,
            float(frequencies[k]),
            shape,
            tuple(BearingReach(b, s.name, float(shape[nodes[b] - 1]), float(shape[s.node - 1])) for b, s in pairs),
        )
        for k, shape in enumerate(shapes.T)
    ]
