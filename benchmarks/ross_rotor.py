"""Rubbing of an unreduced rotor on one compliant retainer, computed by ROSS; imports nothing of this project.

ROSS uses Newmark's method and evaluates the contact force at the beginning of a step.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import ross


def seconds_per_step(
    nodes: list[float],
    diameter: list[float],
    material: list[float],
    bodies: list[list[float]],
    bearings: list[list[float]],
    retainer: list[float],
    unbalance: list[float],
    speed: float,
    step: float,
    steps: int,
) -> dict[str, float]:
    """Return the time (s) of a step of `run_rubbing`, as the difference of a long and a short run, and contact share.

    `bodies` are node (from 1), mass, diametral and polar inertia, `bearings` node, stiffness and damping, `retainer`
    node, clearance and stiffness, `unbalance` node and kg m; all SI.
    """
    steel = ross.Material("shaft", rho=material[0], E=material[1], Poisson=material[2])
    lengths = np.diff(nodes)
    shaft = [ross.ShaftElement(length, 0.0, d, material=steel) for length, d in zip(lengths, diameter, strict=True)]
    discs = [ross.DiskElement(int(node) - 1, *inertia) for node, *inertia in bodies]
    supports = [ross.BearingElement(int(node) - 1, kxx=k, cxx=c) for node, k, c in bearings]
    rotor: Any = ross.Rotor(shaft, discs, supports)
    node, clearance, stiffness = retainer

    def run(count: int) -> tuple[Any, float]:
        begin = time.perf_counter()
        result = rotor.run_rubbing(
            n=int(node) - 1,
            distance=clearance,
            contact_stiffness=stiffness,
            contact_damping=0.0,
            friction_coeff=0.0,
            node=[int(unbalance[0]) - 1],
            unbalance_magnitude=[unbalance[1]],
            unbalance_phase=[0.0],
            speed=speed,
            t=step * np.arange(count + 1),
        )
        return result, time.perf_counter() - begin

    short = 10
    run(short)  # the first run also loads modules
    _, before = run(short)
    result, after = run(short + steps)
    x, y = (result.yout[:, 6 * (int(node) - 1) + axis] for axis in (0, 1))
    return {"seconds": (after - before) / steps, "contact": float(np.mean(np.hypot(x, y) > clearance))}
