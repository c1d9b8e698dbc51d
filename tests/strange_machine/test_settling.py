"""The settled motion of the expander is computed directly, and equals that of simulated settling."""

import json

import numpy as np
import pytest
from strange_machine import LEVITATION

import amb_cosim

CLEARANCE = 0.1e-3  # m, of the retainers
TURN = 80  # steps
LINEAR = {
    "rotor_contact": {"spin.free": False},
    "amb_actuator": {"force_law": "linear", "amplifier": "dynamic", "*.static_current_y": 0.0},
    "rolac_controller": {
        "north.k_integral_?": "10 N/(um.s)",
        "south.k_integral_?": "10 N/(um.s)",
        "derivative_time": "50 us",
    },
}
NOT_SETTLED = amb_cosim.Scenario.load(LEVITATION).changed(parameters=LINEAR, end_cycle=7)
SOLVED = NOT_SETTLED.changed(settling="solved")
REFUSED = {
    "noise": ({"rolac_controller.chain.preset": "rig"}, "rolac_controller.chain.noise, .*: every turn differs"),
    "adaptation": ({"rolac_controller.rolac_enable": True}, "rolac_controller.rolac_enable = true"),
    "identification": ({"rolac_controller.identify": True}, "rolac_controller.identify = true"),
    "a free spin": ({"rotor_contact.spin.free": True}, "rotor_contact.spin.free = true"),
    "a race": ({"rotor_contact.catch_n.race_inertia": 1e-5}, "rotor_contact.catch_n.race_inertia = 1e-05 kg.m2"),
    "forces": ({"amb_actuator.force_law": "nonlinear"}, "amb_actuator.north.k_yy does not move linearly"),
    "contact": ({"rotor_contact.turbine.u": "300 g.mm"}, "rotor_contact.*.mode = .* before cycle 0"),
    "instability": (
        {"rolac_controller.*.c_b_?": 0.0},
        "the loop is not stable: a vibration of .* Hz changes by the factor 1.* per step",
    ),
}


def orbits(run):
    places = ("north", "guide", "south", "catch_n", "catch_s", "labyrinth", "shroud")
    return np.array([run.signals[f"rotor_contact.{place}.{axis}"].values for place in places for axis in "xy"])


@pytest.fixture(scope="module")
def solved():
    return amb_cosim.run(SOLVED)


def test_computed_settled_motion_equals_long_settling():
    solved, settled = (amb_cosim.run(scenario.changed(settle_cycles=500)) for scenario in (SOLVED, NOT_SETTLED))
    assert np.abs(orbits(solved) - orbits(settled)).max() < 1e-9 * CLEARANCE
    assert (solved.summary.settled, settled.summary.settled) == ("solved", "simulated")
    assert solved.summary.settling < 3.0 / 250.0 < settled.summary.settling


def test_integrators_carry_the_weight_in_the_settled_motion(solved):
    height, current = (
        solved.signals[name].values[:TURN].mean() for name in ("rotor_contact.south_up", "rolac_controller.south.i_y")
    )
    assert abs(height) < 1e-9 * CLEARANCE
    assert current > 0.1  # A, upwards


def test_the_angle_at_cycle_0_is_that_after_the_cycles_of_settling():
    odd = {"settle_cycles": 20.3, "end_cycle": 1, "event": []}
    angles = [
        amb_cosim.run(scenario.changed(**odd)).signals["rotor_contact.theta"].values
        for scenario in (SOLVED, NOT_SETTLED)
    ]
    assert angles[0] == pytest.approx(angles[1], abs=1e-10)
    assert angles[0][0] > 1.0


def test_energies_are_balanced_from_the_settled_motion_on(solved):
    assert solved.summary.energy_balance < 1e-6


def test_fourier_windows_show_the_settled_motion(solved):
    amplitude = solved.signals["rolac_controller.amplitude.north_east"].values[1:TURN]
    assert np.ptp(amplitude) < 1e-6 * amplitude.max()


@pytest.mark.parametrize(("changes", "reason"), REFUSED.values(), ids=REFUSED)
def test_unsupported_cases_of_computed_settling_are_refused_by_name(changes, reason):
    with pytest.raises(ValueError, match=f"settling = 'solved' is not allowed here: {reason}"):
        amb_cosim.run(SOLVED, set=changes, until=0.01)


def test_settling_is_simulated_if_it_cannot_be_computed():
    run = amb_cosim.run(SOLVED.changed(settling="automatic"), set={"amb_actuator.force_law": "nonlinear"}, until=0.01)
    simulated = amb_cosim.run(NOT_SETTLED, set={"amb_actuator.force_law": "nonlinear"}, until=0.01)
    assert np.array_equal(orbits(run), orbits(simulated))
    reason = "the motion before cycle 0 was simulated: amb_actuator.north.k_yy"
    assert any(reason in notice for notice in run.summary.notices)
    assert json.loads(run.summary.to_json())["settling"] == "simulated"


def test_both_loops_start_from_the_same_settled_motion(solved):
    plain = amb_cosim.run(SOLVED, loop="plain", until=0.005)
    plain_orbits = orbits(plain)
    assert np.array_equal(plain_orbits, orbits(solved)[:, : plain_orbits.shape[1]])
