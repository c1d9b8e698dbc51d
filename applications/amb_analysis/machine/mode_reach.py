"""Reach of magnets and sensors at the bending modes of the free rotor.

A bearing whose law answers a displacement at its sensor by a force at its magnet adds to a mode of modal mass m

    m (q'' + 2 zeta w q' + w^2 q) = -sum_b phi_m phi_s (k + c d/dt) q                                  (1)

phi_m and phi_s are the mode shape at magnet and sensor. With phi_m phi_s < 0, a node between them, damping c of the law
drives the mode. The reach of a bearing is the root of the product with its sign, over the largest |phi|:

    r = sign(phi_m phi_s) sqrt(|phi_m phi_s|)/max|phi|                                                 (2)

1 at an antinode that both share, 0 at a node of either.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from amb_analysis.machine.machine import Machine
from array_types import Array
from rotor_analysis.damping import free_modes

SMALL = 0.02  # share of the largest of a shape below which a place is at a node of it
REACHED = 0.05  # least reach of a mode that is controlled


@dataclass(frozen=True)
class BearingReach:
    """A bearing, the sensor plane next to it, and a mode shape at both over its largest value."""

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
        """Whether magnet or sensor is at a node."""
        return min(abs(self.at_magnet), abs(self.at_sensor)) < SMALL

    @property
    def kind(self) -> str:
        """Obstacle to damping by the bearing, in words; empty without any."""
        if self.is_at_node:
            return "at a node"
        return "non-collocated" if self.value < 0.0 else ""


@dataclass(frozen=True, eq=False)
class ModeReach:
    """A bending mode of the free rotor, numbered from 1, its shape at all nodes, and its reach at each bearing."""

    number: int
    frequency: Annotated[float, "rad/s"]
    shape: Array
    bearings: tuple[BearingReach, ...]

    @property
    def deciding(self) -> BearingReach:
        """The bearing that drives the mode most, if a bearing does; otherwise that with the largest reach.

        A single bearing with a reach below -`REACHED` counts: its law needs the opposite phase at this mode.
        """
        worst = min(self.bearings, key=lambda one: one.value)
        return worst if worst.value < -REACHED else max(self.bearings, key=lambda one: one.value)


def mode_reaches(machine: Machine, count: int) -> list[ModeReach]:
    """Return the first bending modes of the free rotor at rest, with the reach (2) of each magnet and nearest sensor.

    Parameters
    ----------
    machine
        The machine.
    count
        Number of modes; fewer if the model has fewer.

    Raises
    ------
    ValueError
        If the rotor has no sensors.
    """
    if not machine.probes:
        raise ValueError(f"rotor {machine.rotor.name} has no sensors")
    frequencies, all_shapes = free_modes(machine.free.M[::2, ::2], machine.free.K[::2, ::2])
    rows = [machine.free.translations[node][0] // 2 for node in sorted(machine.free.translations)]
    shapes = all_shapes[rows][:, :count]
    shapes = shapes / shapes[np.abs(shapes).argmax(axis=0), np.arange(shapes.shape[1])]
    pairs = _pairs(machine)
    return [
        ModeReach(
            k + 1,
            float(frequencies[k]),
            shape,
            tuple(BearingReach(b, s, float(shape[at - 1]), float(shape[seen - 1])) for b, at, s, seen in pairs),
        )
        for k, shape in enumerate(shapes.T)
    ]


def _pairs(machine: Machine) -> list[tuple[str, int, str, int]]:
    """Return each magnetic bearing with its node, and the nearest sensor plane with its node."""
    nodes = {bearing.name: bearing.node for bearing in machine.rotor.bearings}
    result = []
    for name in machine.magnets:
        at = machine.z[nodes[name] - 1]
        sensor, seen = min(machine.probes.items(), key=lambda probe, at=at: abs(machine.z[probe[1] - 1] - at))  # type: ignore[misc]
        result.append((name, nodes[name], sensor, seen))
    return result
