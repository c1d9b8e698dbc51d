"""A journal and its retainer on a mount, two bodies in contact, against Siconos.

Siconos gets the same bodies in other coordinates, s = r - r_h of the journal in its retainer and r_h of the retainer, in
which the clearance is a circle about the origin: r = s + r_h, so M' = S^T M S, and so on.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from two_bodies import THETA, TwoBodies, follow

Siconos = Callable[..., dict[str, np.ndarray]]

SPIN = 200.0  # rad/s
MOUNTED = TwoBodies(
    mass=10.0,
    clearance=0.25e-3,
    support_stiffness=2e4,
    force=10.0 * 9.81 * np.exp(-0.6j * np.pi),
    housing_mass=4.0,
    mount_stiffness=(4e6, 6e6),
    mount_damping=(400.0, 700.0),
)
START = np.array([0.05, 0.0, -0.02, 0.01, 0.0, 0.0])  # velocities (m/s) of the bodies, both in the middle
TO_RELATIVE = np.block([[np.eye(2), np.eye(2)], [np.zeros((2, 2)), np.eye(2)]])


def given(model: TwoBodies) -> dict[str, np.ndarray]:
    """The two bodies for Siconos, in coordinates s and r_h."""
    S = TO_RELATIVE
    spring = [model.support_stiffness] * 2 + list(model.mount_stiffness)
    damper = [model.support_damping] * 2 + list(model.mount_damping)
    M = np.diag([model.mass] * 2 + [model.housing_mass] * 2)
    matrices = {name: S.T @ matrix @ S for name, matrix in {"M": M, "C": np.diag(damper), "K": np.diag(spring)}.items()}
    return matrices | {
        "f": S.T @ [model.force.real, model.force.imag, 0.0, 0.0],
        "q": np.zeros(4),
        "v": np.linalg.solve(S, START[:4]),
        "rows": np.array([0]),
        "clearance": np.array([model.clearance]),
        "restitution": np.array([model.restitution]),
        "mu": np.array([model.mu]),
        "surface": np.array([SPIN * model.journal_radius]),
    }


def ours(model: TwoBodies, times: np.ndarray):
    velocities = START.copy()
    velocities[THETA] = SPIN
    return follow(model, times, np.zeros(6), velocities)


@pytest.mark.parametrize("e", [0.0, 0.4])
def test_frictionless_bodies_move_as_in_siconos(e: float, siconos: Siconos) -> None:
    model = replace(MOUNTED, restitution=e)
    h, points = 1e-3, 40
    answer = siconos("from_event_to_event", h=h, points=points, tolerance=1e-9, **given(model))
    motion = ours(model, h * np.arange(1, points + 1))
    print(np.abs(answer["q"] @ TO_RELATIVE.T - motion.q[:, :4]).max(), np.abs(answer["v"] @ TO_RELATIVE.T - motion.v[:, :4]).max(), len(motion.impacts), motion.mode.mean(), np.abs(answer["force"][:,0]-motion.N).max(), motion.N.max())


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_bodies_with_friction_move_as_in_siconos(mu: float, siconos: Siconos) -> None:
    model = replace(MOUNTED, mu=mu)
    points, span = 20, 0.04
    h = span / points
    motion = ours(model, h * np.arange(1, points + 1))
    for every in (1000, 4000):
        answer = siconos("time_stepping", h=h / every, every=every, points=points, **given(model))
        print(every, np.abs(answer["q"] @ TO_RELATIVE.T - motion.q[:, :4]).max(), len(motion.impacts), motion.mode)
