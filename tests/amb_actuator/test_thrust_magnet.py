"""The axis along the shaft of a thrust magnet: the same law as that of a radial axis."""

import numpy as np
import pytest

from amb_actuator.actuator import MAX_BEARINGS, constants_for, model_for
from amb_actuator.interface import LINEAR, NONLINEAR
from fmi_export.model import Instance
from thrust_bearings.disc import ThrustDisc

H = 50e-6
DISC = ThrustDisc(0.014, 0.030, 5e-4, 0.4e-3, 120.0, 2.5, 8.0, 1.3)
MAGNET = {"turns": 0.5 * DISC.turns, "pole_area": DISC.pole_area, "gap": DISC.gap, "bias_current": DISC.bias_current}
MAGNET |= {"current_limit": DISC.current_limit, "b_sat": 10.0}  # far from saturation, whose knee the disc lacks


def actuator(*bearings, **changes):
    made = Instance(model_for(bearings, "thrust"), constants_for(bearings, "thrust"))
    for name, value in MAGNET.items():
        made[f"thrust.{name}_z"] = value
    for name, value in changes.items():
        made[name] = value
    return made


def force_of(made, z, current):
    made["thrust.z"], made["thrust.i_z"] = z, current
    made.initialise()
    return made["thrust.f_z"], made["thrust.k_zz"], made["thrust.z_ref"]


@pytest.mark.parametrize(("z", "current"), [(0.0, 0.0), (5e-5, 0.0), (0.0, 1.0), (-8e-5, -2.0)])
def test_force_is_that_of_a_disc_between_coils_around_the_shaft(z, current):
    force, gradient, reference = force_of(actuator("b", force_law=float(NONLINEAR)), z, current)
    plus, minus = (DISC.bias_current + current) / (DISC.gap - z), (DISC.bias_current - current) / (DISC.gap + z)
    scale = 0.25 * 4e-7 * np.pi * DISC.turns**2 * DISC.pole_area
    assert force == pytest.approx(scale * (plus**2 - minus**2), rel=1e-6)
    assert gradient == pytest.approx(2.0 * scale * (plus**2 / (DISC.gap - z) + minus**2 / (DISC.gap + z)), rel=1e-6)
    assert reference == z


def test_constants_of_the_linear_law_are_those_of_the_disc():
    point = DISC.operating_point(0.0)
    at_current, at_place = (force_of(actuator("b", force_law=float(LINEAR)), *at) for at in ((0.0, 0.1), (1e-5, 0.0)))
    assert at_current[0] == pytest.approx(0.1 * point.k_i, rel=1e-9)
    assert at_place[0] == pytest.approx(1e-5 * point.k_s, rel=1e-9)


def test_the_axes_of_bearings_do_not_know_the_thrust_magnet():
    names = ("one", "other")
    alone = Instance(model_for(names), constants_for(names))
    both = actuator(*names)
    for made in (alone, both):
        made["force_law"], made["amplifier"], made["other.x"], made["other.i_y"] = float(NONLINEAR), 1.0, 1e-4, 0.7
        made.initialise()
        for n in range(5):
            made.step(n * H, H)
    outputs = [v.name for v in alone.model.interface.of("output")]
    assert [both[name] for name in outputs] == [alone[name] for name in outputs]


def test_the_most_axes_leave_the_codes_of_faults_below_100():
    names = tuple(f"b{k}" for k in range(MAX_BEARINGS))
    assert max(model_for(names, "thrust").faults) < 100
