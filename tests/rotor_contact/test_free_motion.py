"""Motion without contact: an independent integration, order of convergence, signs of forces and unbalance."""

import numpy as np
import pytest
from free_motion import ROTOR, START, START_VELOCITY, UNBALANCE, WIDE, exact_motion
from rotor_cases import BEARINGS, H, OnePlane, both, head, masters, place, plant, rigid_rotor, run


def free_rotor(Omega, steps, h=H, **values):
    x = plant(WIDE | BEARINGS | UNBALANCE | {"Omega": Omega} | {k.replace("__", "."): v for k, v in values.items()})
    place(x, START, START_VELOCITY)
    run(x, steps, h=h)
    return x


def test_integration_is_of_fourth_order_in_the_substep():
    steps = 40
    r, _ = exact_motion(300.0, steps * 1e-3)
    fixed = {"solver__exact_motion": 0.0, "solver__tolerance": 1.0}
    errors = [
        np.max(np.abs(masters(free_rotor(300.0, steps, 1e-3, solver__max_substep=1e-3 / parts, **fixed))[0] - r))
        for parts in (4, 8, 16)
    ]
    order = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    np.testing.assert_allclose(order, 4.0, atol=0.3)
    assert errors[-1] < 3e-5 * np.max(np.abs(r))


def test_force_with_gradient_is_a_spring_about_its_reference():
    """F + k (x - x_ref) with k = -1e6 and F = 0 at x_ref = 0 is the passive bearing."""
    spring = free_rotor(150.0, 200)
    values = WIDE | UNBALANCE | {"Omega": 150.0} | both("mb.c_b", 5000.0)
    for k in (1, 2):
        for axis, reference in (("x", 2e-5), ("y", -1e-5)):
            values |= {f"mb{k}.k_{axis}{axis}": -1e6, f"mb{k}.{axis}_ref": reference}
            values |= {f"mb{k}.f_{axis}": -1e6 * reference}
    sprung = place(plant(values), START, START_VELOCITY)
    run(sprung, 200)
    np.testing.assert_allclose(masters(sprung)[0], masters(spring)[0], rtol=1e-9, atol=1e-16)


def test_a_stiff_damper_on_a_light_rotor_creeps():
    """Each end has m = 10 kg: m x'' + c x' + k x = F, where c/m is 25 times the rate at which steps begin."""
    m, c, k, F = 10.0, 1e6, 1e6, 5.0
    x = plant(WIDE | both("mb.k_b", k) | both("mb.c_b", c) | {"mb1.f_x": F}, rigid_rotor(mass=2.0 * m))
    run(x, 40)
    slow, fast = np.roots([m, c, k])[::-1]
    left = (fast * np.exp(slow * 40 * H) - slow * np.exp(fast * 40 * H)) / (fast - slow)
    assert masters(x)[0][0] == pytest.approx(F / k * (1.0 - left), rel=1e-6)


@pytest.mark.parametrize(("name", "site", "direction"), [
    ("mb1.f_x", 0, 1.0), ("mb1.f_y", 0, 1j), ("mb2.f_x", 1, 1.0), ("mb2.f_y", 1, 1j),
    ("d1.f_x", 0, 1.0), ("d2.f_y", 0, 1j), ("d3.f_x", 1, 1.0), ("d4.f_y", 1, 1j),
])  # fmt: skip
def test_force_input_accelerates_its_point_along_its_axis(name, site, direction):
    x = plant(WIDE | {name: 5.0}, rigid_rotor(mass=20.0))
    run(x, 40)
    r, _ = masters(x)
    assert r[site] == pytest.approx(direction * 0.5 * (5.0 / 10.0) * 0.01**2, rel=1e-6)
    assert abs(r[1 - site]) < 1e-6 * abs(r[site])


def test_base_acceleration_moves_a_free_rotor_rigidly_the_other_way():
    x = plant(WIDE | {"base.a_x": 2.0, "base.a_y": -3.0})
    run(x, 200)
    np.testing.assert_allclose(masters(x)[0], -0.5 * (2.0 - 3.0j) * 0.05**2, rtol=1e-6)


@pytest.mark.parametrize(("Omega", "theta", "phi"), [(60.0, 0.0, 0.0), (-60.0, 0.0, 1.0), (60.0, 1.3, -0.4)])
def test_unbalance_is_at_its_angle_from_the_mark_and_turns_x_to_y(Omega, theta, phi):
    """A free rigid rotor: 10 r'' = u Omega^2 e^(i (theta + phi + Omega t)), positive speed turns from x to y."""
    u, steps = 1e-3, 100
    x = plant(WIDE | {"Omega": Omega, "d1.u": u, "d1.phi": phi}, rigid_rotor(mass=20.0))
    head(x).theta = theta
    run(x, steps)
    turned = np.exp(1j * (theta + phi)) * (np.exp(1j * Omega * steps * H) - 1.0)
    assert masters(x)[1][0] == pytest.approx(u * Omega / 10j * turned, rel=1e-6)


def test_energy_balance_of_free_vibration_on_damped_bearings():
    x = place(plant(WIDE | BEARINGS | {"Omega": 200.0}), START, START_VELOCITY)
    model = OnePlane.of(ROTOR, 1e6)
    start = 0.5 * (START_VELOCITY.conj() @ model.M @ START_VELOCITY + START.conj() @ model.K @ START).real
    energy = run(x, 2000, ["energy.kinetic", "energy.strain", "energy.dissipated"])
    np.testing.assert_allclose(energy.sum(axis=1), start, rtol=1e-4)
    assert energy[-1, 2] > 0.99 * start
    assert np.all(np.diff(energy[:, 2]) >= 0.0)
