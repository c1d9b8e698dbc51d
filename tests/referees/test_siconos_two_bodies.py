"""A journal and its retainer on a mount, two bodies in contact, against Siconos.

Siconos gets the same bodies in other coordinates, s = r - r_h of the journal in its retainer, and r_h of that: there
the clearance is a circle about the origin. With r = s + r_h the matrices are S^T M S, and so on.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from touchdown_cases import follow_plant, plant_of
from two_bodies import MOUNTED, TwoBodies, follow

Siconos = Callable[..., dict[str, np.ndarray]]

SPIN = 200.0  # rad/s
START = np.array([0.05, 0.0, -0.02, 0.01, SPIN, 0.0])  # velocities (m/s) of the bodies, both in the middle; spin
TO_RELATIVE = np.block([[np.eye(2), np.eye(2)], [np.zeros((2, 2)), np.eye(2)]])


def siconos_data(model: TwoBodies) -> dict[str, np.ndarray]:
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


@pytest.mark.slow
@pytest.mark.parametrize("e", [0.0, 0.4])
def test_frictionless_bodies_move_as_in_siconos(e: float, siconos: Siconos) -> None:
    """The last bounces, which each code truncates differently, leave 1e-8 m."""
    model = replace(MOUNTED, restitution=e)
    h, points = 1e-3, 40
    answer = siconos("from_event_to_event", h=h, points=points, tolerance=1e-9, **siconos_data(model))
    times = h * np.arange(1, points + 1)
    bounces = e > 0.0
    by_substeps, exact = (plant_of(model, np.zeros(6), START, **{"solver.exact_motion": k}) for k in (0.0, 1.0))
    for motion, error, of_force in (
        (follow(model, times, np.zeros(6), START), 1e-11, 1e-4),
        (follow_plant(by_substeps, times), 1e-11, 1e-4),
        (follow_plant(exact, times), 1e-9, 1e-3),  # m of 1e-4, N of 400
    ):
        assert 0 < np.count_nonzero(motion.mode) < points
        np.testing.assert_allclose(motion.q[:, :4], answer["q"] @ TO_RELATIVE.T, atol=5e-8 if bounces else error)
        np.testing.assert_allclose(motion.N, answer["force"][:, 0], atol=0.1 if bounces else of_force)


@pytest.mark.slow
@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_bodies_with_friction_move_as_in_siconos(mu: float, siconos: Siconos) -> None:
    """Siconos's time stepping converges to the motion with its step; the clearance is 2.5e-4 m.

    The plant's pieces are as long as 1e-4 of a peak allows, and its substeps shorter.
    """
    model = replace(MOUNTED, mu=mu)
    points, span = 20, 0.04
    times = span / points * np.arange(1, points + 1)
    plants = (plant_of(model, np.zeros(6), START, **{"solver.exact_motion": exact}) for exact in (0.0, 1.0))
    by_substeps, motion = (follow_plant(plant, times) for plant in plants)
    difference = []
    for every in (500, 2000):
        h = span / points / every
        answer = siconos("time_stepping", h=h, every=every, points=points, **siconos_data(model))
        difference.append(np.abs(motion.q[:, :4] - answer["q"] @ TO_RELATIVE.T).max())
    assert difference[-1] < 4e-6
    assert difference[-1] < 0.35 * difference[0]
    in_python = follow(model, times, np.zeros(6), START).q[:, :4]
    np.testing.assert_allclose(in_python, by_substeps.q[:, :4], atol=1e-11)
    np.testing.assert_allclose(in_python, motion.q[:, :4], atol=4e-9)
