"""The error that the solver's default settings leave, against a hundred times shorter steps."""

import math

import numpy as np
import pytest
from rotor_cases import BEARINGS, H, both, plant, run

from rotor_contact.variables.enumerations import NEWTON, NODAL

REFERENCE = {"solver.max_substep": H / 100.0, "solver.tolerance": 1.0, "solver.exact_motion": 0.0}


def rub_history(Omega, before, during, turns, values):
    """Forces at both retainers and displacement of both bearings: settled, unbalance added on D1, and on."""
    x = plant(BEARINGS | values | {"Omega": Omega, "d1.u": before, "initial.orbit": 1.0})
    run(x, 100)
    x["d1.u"] = during
    return run(x, round(turns * 2.0 * math.pi / Omega / H), ["rb1.f_n", "rb2.f_n", "mb1.x", "mb1.y", "mb2.x", "mb2.y"])


CASES = {
    "rubbing at 90 rad/s": (90.0, 5e-4, 94e-3, 4.0, {"contact.impact_law": NODAL}),
    "rubbing at 120 rad/s": (120.0, 5e-4, 60e-3, 6.0, {"contact.impact_law": NODAL}),
    "impacts of fig. 4.9": (260.0, 5e-4, 25.5e-3, 6.0, {"contact.impact_law": NODAL}),
    "impacts of fig. 4.9, newton": (260.0, 5e-4, 25.5e-3, 6.0, {"contact.impact_law": NEWTON}),
    "impacts and friction": (260.0, 5e-4, 40e-3, 4.0, {"contact.impact_law": NODAL} | both("rb.mu", 0.15)),
}


@pytest.mark.parametrize("case", CASES)
def test_peak_force_and_settled_orbit_are_right_to_a_thousandth(case):
    Omega, before, during, turns, values = CASES[case]
    result, reference = (rub_history(Omega, before, during, turns, values | v) for v in ({}, REFERENCE))
    peak, expected = (record[:, :2].max(axis=0) for record in (result, reference))
    assert np.all(expected[0] > 500.0)
    np.testing.assert_allclose(peak, expected, rtol=1e-3)
    turn = round(2.0 * math.pi / Omega / H)
    for k in (2, 4):
        radius, settled = (np.hypot(r[-turn:, k], r[-turn:, k + 1]).max() for r in (result, reference))
        assert radius == pytest.approx(settled, rel=1e-3)
