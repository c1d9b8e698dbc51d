"""Motion along the shaft: its closed form, signs of each force, energy, and what it leaves alone."""

from dataclasses import replace

import numpy as np
import pytest
from rotor_cases import BEARINGS, H, both, memory, plant, run
from scipy.linalg import expm

from fmi_export.model import Instance
from rotor_analysis.parts import ThrustDisc
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.forces.axial_motion import SHORT, moved_along

ROTOR = replace(load_rotor(), thrust_disc=ThrustDisc(0.4))
WITH_DISC = "thrust.z", "thrust.speed"
GRADIENTS = {"none": 0.0, "magnet": 3e6, "spring": -8e6, "nearly none": 2.0, "of a short series": 1e4}  # N/m


def axial(values):
    return plant(BEARINGS | values, ROTOR)


def exactly(gradient, force, time, z=0.0, speed=0.0):
    """z and z' after a time, by a matrix exponential: m z'' = force + gradient z."""
    of_motion = np.array([[0.0, 1.0, 0.0], [gradient / ROTOR.mass, 0.0, force / ROTOR.mass], [0.0, 0.0, 0.0]])
    scaled = np.diag([1.0, H, 1.0])
    result = np.linalg.inv(scaled) @ expm(scaled @ of_motion @ np.linalg.inv(scaled) * time) @ scaled
    return (result @ [z, speed, 1.0])[:2]


@pytest.mark.parametrize("gradient", GRADIENTS.values(), ids=GRADIENTS)
def test_a_step_is_the_closed_form(gradient):
    x = axial({"thrust.f_z": 40.0, "thrust.k_zz": gradient, "thrust.f_process": -7.0})
    record = run(x, 40, WITH_DISC)
    expected = np.array([exactly(gradient, 33.0, n * H) for n in range(1, 41)])
    assert np.all(np.abs(record - expected) <= 1e-12 * np.max(np.abs(expected), axis=0))


def test_series_and_functions_of_the_closed_form_meet():
    for w in (SHORT, -SHORT):
        below, above = (np.array(moved_along(1.0, 1.0, 1.0, w * near, 1.0)) for near in (1.0 - 1e-15, 1.0 + 1e-15))
        np.testing.assert_allclose(below, above, rtol=1e-14)


def test_two_halves_of_a_step_are_the_step():
    values = {"thrust.f_z": 5.0, "thrust.k_zz": 4e5, "thrust.z_ref": -2e-5}
    whole, halves = axial(values), axial(values)
    run(whole, 20, h=H)
    run(halves, 40, h=0.5 * H)
    for name in WITH_DISC:
        assert halves[name] == pytest.approx(whole[name], rel=1e-12)


@pytest.mark.parametrize(("values", "sign"), [
    ({"thrust.f_z": 1.0}, 1.0),
    ({"thrust.f_process": -1.0}, -1.0),
    ({"thrust.k_zz": 1e5, "thrust.z_ref": -1e-5}, 1.0),  # it pushes the rotor away from where its force is zero
    ({"thrust.k_zz": -1e5, "thrust.z_ref": -1e-5}, -1.0),
    ({"gravity": 9.81, "thrust.tilt": 0.3}, -1.0),  # the end of larger z is up
    ({"gravity": 9.81, "thrust.tilt": -0.3}, 1.0),
    ({"base.a_z": 3.0}, -1.0),  # z is relative to the base, which leaves the rotor behind
])  # fmt: skip
def test_each_force_moves_the_rotor_in_its_direction(values, sign):
    assert run(axial(values), 3, WITH_DISC)[-1] @ [0.0, sign] > 1e-6


def test_an_upright_rotor_falls_along_its_shaft_and_has_no_lateral_weight():
    x = axial({"gravity": 9.81, "thrust.tilt": np.pi / 2})
    record = run(x, 80, [*WITH_DISC, "mb1.x", "mb1.y"])
    assert record[-1, 0] == pytest.approx(-0.5 * 9.81 * (80 * H) ** 2, rel=1e-12)
    assert np.max(np.abs(record[:, 2:])) < 1e-15


def test_weight_across_the_shaft_has_the_cosine_of_the_tilt():
    upright, level = (
        run(axial({"gravity": g, "thrust.tilt": t}), 60, ["mb1.y"]) for g, t in ((9.81, 1.1), (9.81, 0.0))
    )
    np.testing.assert_allclose(upright, np.cos(1.1) * level, rtol=1e-9)


@pytest.mark.parametrize("free", [0.0, 1.0], ids=["given speed", "free spin"])
def test_balance_closes_with_forces_that_change_along_the_shaft(free):
    x, largest = axial({"Omega": 200.0, "spin.free": free, "gravity": 9.81, "thrust.tilt": np.pi / 2}), 0.0
    for n in range(400):
        x["thrust.f_z"], x["thrust.k_zz"] = 300.0 * np.sin(0.05 * n), 2e6 * np.cos(0.03 * n)
        x["thrust.f_process"], x["thrust.z_ref"] = 20.0 * np.cos(n), 1e-5 * np.sin(n)
        run(x, 1, start=n * H)
        largest = max(largest, abs(x["energy.balance"]))
    along = 0.5 * ROTOR.mass * x["thrust.speed"] ** 2
    assert along > 1e-4
    assert x["energy.kinetic"] >= along * (1.0 - 1e-12)
    assert largest < 1e-9 * along


def test_lateral_motion_does_not_know_the_axial_one():
    rub = BEARINGS | both("rb.mu", 0.1) | {"Omega": 260.0, "d1.u": 4e-2}
    names = ["mb1.x", "mb2.y", "rb1.f_n", "energy.friction"]
    without = run(plant(rub, load_rotor()), 300, names)
    with_disc = run(plant(rub | {"thrust.f_z": 1e3, "thrust.k_zz": 1e6}, ROTOR), 300, names)
    assert np.max(without[:, 2]) > 0.0
    np.testing.assert_array_equal(with_disc, without)


def test_a_restored_state_continues_along_the_shaft():
    x = axial({"thrust.f_z": 3.0, "thrust.k_zz": 1e6})
    run(x, 50)
    other = Instance(x.model, x.constants)
    other.parameters[:], other.inputs[:], other.state[:] = x.parameters, x.inputs, x.state
    np.testing.assert_array_equal(run(other, 20, WITH_DISC, start=50 * H), run(x, 20, WITH_DISC, start=50 * H))


def test_only_a_rotor_with_a_thrust_disc_has_room_for_its_motion():
    with_disc, without = axial({}), plant(BEARINGS)
    assert len(with_disc.state) - len(without.state) == memory(with_disc).axial.view(np.float64).size == 2
    assert not [v.name for v in without.model.interface.variables if v.name.startswith("thrust")]
