"""Placement and amount of unbalance for each mode."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amb_analysis.machine.feedback import directional_stiffness, springs
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_cosim.presentation.digits import significant
from array_types import Array
from rotor_analysis.critical_speeds import antinodes, critical_speeds, lobe_masses
from rotor_analysis.parts import Point

MOST = 5  # modes, at most
BEYOND = 1.5  # highest critical speed of a mode, over the trip speed
SOFTEST = 0.02  # least stiffness of a bearing, over the largest of a magnet


def base_notes(subject: AssessedMachine) -> list[str]:
    """Return the sentence that says that the undamped shapes leave out components that move the base, if any do."""
    if not subject.base_movers:
        return []
    return [
        f"The base moves with {', '.join(subject.base_movers)}. Undamped critical speeds and their shapes are those on "
        "a base at rest; responses, currents and stability include the motion of the base."
    ]


@dataclass(frozen=True)
class UnbalanceCase:
    """Unbalance that excites a mode.

    name
        Name of the case.
    shape
        Shape of the mode at the nodes, scaled so that the largest value is 1.
    shares
        Share of the total unbalance by node, with the sign of the shape. Each lobe receives, at its antinode, a share
        in proportion to its modal mass.
    lobes
        First and last node of each lobe, in the order of `shares`.
    """

    name: str
    shape: Array
    shares: dict[int, float]
    lobes: tuple[tuple[int, int], ...]

    def of(self, total: float) -> dict[Point, complex]:
        """Return the unbalance at each node (kg m) for a total unbalance (kg m)."""
        return {node: complex(share * total) for node, share in self.shares.items()}


def unbalance_cases(subject: AssessedMachine) -> list[UnbalanceCase]:
    """Return cases for all modes with undamped critical speeds up to 1.5 times the trip speed, but at least two.

    The mode shapes are those of the rotor without seals on its bearings, whose stiffness is that at the largest speed.
    If this stiffness differs between x and y, each direction has its own cases.
    """
    speed = subject.file.speed
    directions = directional_stiffness(subject, np.array([speed.highest]))
    return [
        case
        for direction, stiffness in directions.items()
        for case in _along(subject, direction, {name: float(k[0].real) for name, k in stiffness.items()})
    ]


def _along(subject: AssessedMachine, direction: str, stiffness: dict[str, float]) -> list[UnbalanceCase]:
    """Return the cases for a direction in which the bearings have the given stiffness (N/m)."""
    least = SOFTEST * max(*(abs(stiffness[name]) for name in subject.magnets), 1.0)
    speeds, shapes = critical_speeds(subject.free, springs(subject, stiffness, least), MOST)
    count = max(2, int(np.count_nonzero(speeds <= BEYOND * subject.file.speed.tripping)))
    cases = []
    for k, (Omega, shape) in enumerate(zip(speeds[:count], shapes.T[:count], strict=True), 1):
        lobes = lobe_masses(subject.free, shape)
        mass = sum(m for _, m, _ in lobes)
        shares = {at + 1: sign * m / mass for at, m, sign in lobes}
        ends = tuple((span.start + 1, span.stop) for _, span in antinodes(shape))
        places = ", ".join(f"z = {significant(1e3 * subject.z[node - 1])} mm" for node in shares)
        name = f"mode {k}{direction} ({rpm(float(Omega)):.0f} rpm), at {places}"
        cases.append(UnbalanceCase(name, shape, shares, ends))
    return cases


def response_speeds(subject: AssessedMachine, points: int = 160) -> Array:
    """Return the speeds (rad/s) of a response: from 3 % to 150 % of the largest speed, and the speeds in the file."""
    speed = subject.file.speed
    swept = np.linspace(0.03, 1.5, points) * speed.highest
    return np.unique([*swept, speed.lowest, speed.highest, speed.tripping])
