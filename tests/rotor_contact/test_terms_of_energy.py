"""Each term of the energy by exact motion, in whole steps and in pieces, against an integration in substeps of 2 us.

Exact motion has the heat of dampers as a form of the state at the start of a piece, and the work of the spin as
another; the integration adds powers from substep to substep. Both sides of the balance are therefore independent.
"""

from dataclasses import replace

import numpy as np
import pytest
from rotor_cases import BEARINGS, H, both, plant, run

from rotor_analysis.damping import Damping
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor_file import load_rotor

RIG = replace(load_rotor(), damping=Damping(modal=(0.01,), stiffness=1e-5))  # a mode vibrates within a step
TERMS = ("kinetic", "strain", "damping", "friction", "impact", "work")
ENERGIES = tuple(f"energy.{term}" for term in TERMS)
WHIRLS = BEARINGS | {"Omega": 260.0, "d1.u": 1e-3, "d3.f_x": 30.0, "mb1.k_xx": 2e5}
FREE = {"spin.free": 1.0, "spin.inertia": 0.4, "spin.drag": 0.5}
MOUNTS = both("rb.housing_mass", 3.0) | both("rb.mount_stiffness_x", 4e7) | both("rb.mount_stiffness_y", 4e7)
MOUNTS |= both("rb.mount_damping_x", 4e3) | both("rb.mount_damping_y", 4e3)
RACES = both("rb.race_inertia", 2.5e-4) | both("rb.race_drag", 0.05)
BRAKED = {"spin.free": 1.0, "spin.inertia": 0.005, "spin.drag": 0.0} | both("rb.mu", 0.4)
FALLEN = both("rb.mu", 0.1) | {"Omega": 100.0, "gravity": 9.81, "d1.u": 1e-4}
ROLLS = BEARINGS | both("rb.mu", 2.0) | {"initial.orbit": 1.0, "Omega": 90.0, "d1.u": 0.094, "rb2.enabled": 0.0}
SEALED = replace(RIG, seals=(Bearing("seal", 9, ((2e5, 1.5e5), (-1.5e5, 2e5)), ((150.0, 30.0), (-30.0, 150.0))),))
SITUATIONS = {  # values, rotor, acceleration of the spin (rad/s^2), steps before
    "constant speed": (WHIRLS, RIG, 0.0, 0),
    "ramp of 1e-6 rad/s^2": (WHIRLS, RIG, 1e-6, 0),
    "ramp of 30 rad/s^2": (WHIRLS, RIG, 30.0, 0),
    "ramp of 300 rad/s^2": (WHIRLS, RIG, 300.0, 0),
    "free spin": (WHIRLS | FREE, RIG, 0.0, 0),
    "sliding": (FALLEN, RIG, 0.0, 3000),
    "rolling": (ROLLS, RIG, 0.0, 400),
    "sliding in races on mounts": (FALLEN | MOUNTS | RACES, RIG, 0.0, 3000),
    "free spin in races on mounts": (FALLEN | MOUNTS | RACES | FREE, RIG, 0.0, 3000),
    "free spin that friction brakes": (FALLEN | MOUNTS | RACES | BRAKED, RIG, 0.0, 3000),
    "moving base": (WHIRLS | {"base.a_x": 8.0, "base.a_y": -5.0}, RIG, 0.0, 0),
    "seal": (WHIRLS, SEALED, 0.0, 0),
    "seal on a ramp": (WHIRLS, SEALED, 300.0, 0),
}
STEPS = 60


def continued(x, **values):
    """Another instance in the same state."""
    y = type(x)(x.model, x.constants)
    y.values[:], y.state[:] = x.values, x.state
    for name, value in values.items():
        y[name.replace("__", ".")] = value
    return y


def gained(x, gain, begin):
    """Gain of each term over some steps with a spin that accelerates, and the change of the balance."""
    names = (*ENERGIES, "energy.balance")
    first = np.array([x[name] for name in names])
    Omega = x["Omega"]
    for n in range(STEPS):
        if gain:
            x["Omega"], x["Omega_dot"] = Omega + gain * H * n, gain
        x.step(begin + n * H, H)
    result = np.array([x[name] for name in names]) - first
    return result[:-1], result[-1]


@pytest.fixture(scope="module", params=SITUATIONS)
def both_ways(request):
    values, rotor, gain, before = SITUATIONS[request.param]
    x = plant(values, rotor)
    run(x, max(before, 1))
    begin = max(before, 1) * H
    integrated = continued(x, solver__exact_motion=0.0, solver__max_substep=2e-6)
    return gained(x, gain, begin), gained(integrated, gain, begin)


def test_each_term_is_that_of_the_integration(both_ways):
    (exact, _), (integrated, _) = both_ways
    largest = np.abs(integrated).max()
    for term, found, own in zip(TERMS, exact, integrated, strict=True):
        assert found == pytest.approx(own, rel=1e-5, abs=1e-7 * largest), term


def test_the_balance_fails_if_a_heat_is_wrong_by_a_hundredth(both_ways):
    """The smallest heat decides: its hundredth is larger than twice the balance."""
    (exact, balance), _ = both_ways
    heats = [value for value in exact[2:5] if value > 0.0]
    assert abs(balance) < 0.005 * min(heats)
