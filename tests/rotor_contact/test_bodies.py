"""Housings, races and a free spin that are stiff, light or not allowed."""

import numpy as np
import pytest
from instances import initialised
from machines import held, machine
from rotor_cases import BEARINGS, UNWATCHED, H, both, plant, rigid_rotor, run, size_of, state

from amb_cosim.model_constants import plant_data
from fmi_export.model import Fault
from rotor_analysis.rotor import ReductionOptions
from rotor_contact.variables.enumerations import EXACT, NODAL, PIECES
from tests.support.messages import raises_naming

RUBBING = {"gravity": 9.81, "Omega": 300.0} | both("rb.mu", 0.15) | both("rb.restitution", 0.3)
FREE_SPIN = {"Omega": 300.0, "spin.free": 1.0, "spin.inertia": 0.4}
STIFF = {
    "drive": FREE_SPIN | {"drive.gain": 5e3, "drive.torque_limit": 1e4, "drive.torque": 100.0},
    "drag": FREE_SPIN | {"spin.drag": 5e3},
    "race": RUBBING | both("rb.race_inertia", 1e-6) | both("rb.race_drag", 0.5),
    "mount": RUBBING
    | both("rb.housing_mass", 0.01)
    | both("rb.mount_stiffness_x", 1e8)
    | both("rb.mount_stiffness_y", 1e8),
}
STIFF["damped mount"] = STIFF["mount"] | both("rb.mount_damping_x", 1e3) | both("rb.mount_damping_y", 1e3)
TOO_FAST = {
    "race": both("rb.race_inertia", 1e-9) | both("rb.race_drag", 0.1),
    "viscous race": both("rb.race_inertia", 1e-6) | both("rb.race_viscous_drag", 1e4),
    "mount": both("rb.housing_mass", 1e-3) | both("rb.mount_stiffness_x", 1e11),
    "drive": FREE_SPIN | {"drive.gain": 1e7},
}


@pytest.mark.parametrize("case", STIFF)
def test_stiff_bodies_keep_the_energy_balance(case):
    x = plant(STIFF[case], rigid_rotor(20.0))
    run(x, 200)
    size = max(x["energy.kinetic"], x["energy.dissipated"], abs(x["energy.work"]))
    assert size > 1e-3
    assert abs(x["energy.balance"]) < 1e-4 * size


@pytest.mark.parametrize("case", TOO_FAST)
def test_bodies_with_too_fast_modes_are_refused_with_the_reason(case):
    with pytest.raises(Fault, match=r"mount_stiffness.*race_inertia.*0\.5 us"):
        plant(RUBBING | TOO_FAST[case], rigid_rotor(20.0))


def test_nodal_rule_is_refused_for_a_housing_that_moves():
    with raises_naming(Fault, "contact.impact_law", "0", "1"):
        plant({"contact.impact_law": NODAL, "rb2.housing_mass": 1.0})


def test_spin_without_enough_inertia_for_its_unbalance_is_refused():
    with raises_naming(Fault, "spin.inertia", "0.0001 kg.m2"):
        plant({"spin.free": 1.0, "spin.inertia": 1e-4, "d1.u": 0.1})


def test_unused_parameters_of_bodies_change_no_bit():
    rub = BEARINGS | both("rb.mu", 0.2) | {"Omega": 200.0, "d1.u": 40e-3, "d3.u": 20e-3}
    unused = both("rb.mount_stiffness_x", 1e7) | both("rb.mount_damping_x", 10.0) | both("rb.race_drag", 0.1)
    unused |= {"drive.torque_limit": 10.0, "spin.drag": 1.0}
    names = ("mb1.x", "mb2.y", "rb1.f_n", "rb2.f_t", "energy.balance")
    plain, other = (run(plant(values), 800, names) for values in (rub, rub | unused))
    assert plain[:, 2].max() > 100.0
    np.testing.assert_array_equal(plain, other)


def test_heavy_housing_and_race_are_the_fixed_retainer():
    """In the limit of infinite mass and inertia the bodies do not move; the difference falls in proportion."""
    rub = BEARINGS | both("rb.mu", 0.2) | {"Omega": 200.0, "d1.u": 40e-3, "solver.max_substep": 2e-5}
    fixed = run(plant(rub), 300, ("mb1.x", "mb2.y"))
    apart = []
    for size in (1e6, 1e8):
        heavy = both("rb.housing_mass", size) | both("rb.race_inertia", size)
        apart.append(np.abs(run(plant(rub | heavy), 300, ("mb1.x", "mb2.y")) - fixed).max())
    assert apart[0] < 1e-6
    assert apart[1] < 0.1 * apart[0]


def test_heat_at_a_site_starts_at_zero_when_the_start_is_computed_again():
    orbit = BEARINGS | both("rb.mu", 0.2) | {"Omega": 200.0, "d1.u": 60e-3, "initial.orbit": 1.0}
    x = plant(orbit)
    first = x["rb1.heat"]
    run(x, 40)
    assert x["rb1.heat"] != first
    x.state[:] = 0.0
    x.initialise()
    assert x["rb1.heat"] == first


UNBALANCED = BEARINGS | {"Omega": 200.0, "d1.u": 10e-3, "spin.free": 1.0, "spin.inertia": 0.4, "spin.drag": 0.5}


def test_an_ideal_drive_holds_the_speed_against_drag():
    held = plant(UNBALANCED | {"drive.ideal": 1.0})
    given = plant(UNBALANCED | {"spin.free": 0.0})
    names = ["mb1.x", "mb2.y", "theta", "speed"]
    np.testing.assert_array_equal(run(held, 100, names), run(given, 100, names))
    spin = 0.5 * 0.4 * 200.0**2
    assert held["energy.kinetic"] == pytest.approx(given["energy.kinetic"] + spin, rel=1e-12)


@pytest.mark.parametrize("race", [{}, both("rb.race_inertia", 1e-4)])
def test_a_released_spin_coasts_from_where_it_was_held(race):
    """Omega(t) = Omega_0 exp(-d t/J); angle, position and energy are continuous."""
    x = plant(UNBALANCED | race | {"drive.ideal": 1.0, "d1.u": 1e-6})
    names = ["theta", "mb1.x", "energy.kinetic", "speed"]
    before = run(x, 200, names)
    x["drive.ideal"] = 0.0
    after = run(x, 200, names, start=200 * H)
    np.testing.assert_allclose(after[:, 3], 200.0 * np.exp(-0.5 / 0.4 * H * np.arange(1, 201)), rtol=1e-9)
    turned = (after[0, 0] - before[-1, 0]) % (2.0 * np.pi)
    assert turned == pytest.approx(200.0 * H, rel=1e-3)
    assert abs(after[0, 2] - before[-1, 2]) < 1e-3 * before[-1, 2]
    lost = before[-1, 2] - after[-1, 2]
    assert x["energy.damping"] == pytest.approx(lost, rel=1e-3)
    assert abs(x["energy.balance"]) < 1e-6 * before[-1, 2]


def test_unbalance_of_a_released_spin_keeps_the_energy_balance():
    x = plant(UNBALANCED | {"drive.ideal": 1.0, "d1.u": 40e-3, "initial.orbit": 1.0})
    run(x, 100)
    for is_held in (0.0, 1.0, 0.0):
        x["drive.ideal"] = is_held
        run(x, 100)
        assert abs(x["energy.balance"]) < 1e-5 * x["energy.kinetic"]


@pytest.mark.parametrize(
    ("limit", "ideal", "reached"), [(0.0, 1, 0), (99.0, 1, 1), (101.0, 1, 0), (2.0, 0, 1), (1e3, 0, 0), (0.0, 0, 0)]
)
def test_a_drive_at_its_limit_warns(limit, ideal, reached):
    """100 N m of drag at 200 rad/s; a drive that is off has no limit to reach."""
    x = plant(UNBALANCED | {"drive.ideal": ideal, "drive.torque_limit": limit, "drive.gain": 10.0})
    run(x, 40)
    assert x["drive.at_limit"] == reached


@pytest.mark.parametrize("rate", [80.0, 1000.0, 5000.0])
def test_a_race_that_nothing_touches_stops_in_closed_form(rate):
    """J w' = -d tanh w: sinh w decays with the rate d/J, which a step need not resolve."""
    inertia, began = 1e-5, 25.0
    race = {"seal1.race_inertia": inertia, "seal1.race_drag": inertia * rate}
    flexible = plant_data.plant(machine(reduction=ReductionOptions(modes=4)))
    x = initialised(*flexible, held(3) | race | UNWATCHED | {"Omega": 100.0})
    run(x, 2)
    n = size_of(x) + 1
    state(x)[2 * n - 1] = began
    t = H * np.arange(1, 41)
    record = run(x, len(t), ["seal1.race_speed", "solver.method"], start=2 * H)
    np.testing.assert_allclose(np.sinh(record[:, 0]), np.sinh(began) * np.exp(-rate * t), rtol=1e-5, atol=1e-6)
    assert set(record[:, 1]) <= {EXACT, PIECES}
