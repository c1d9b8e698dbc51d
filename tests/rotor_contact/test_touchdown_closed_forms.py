"""Touchdown in closed form: falling, rocking, races that spin up, spins that are braked, rolling, unbalance, whirl."""

import math
from dataclasses import replace

import numpy as np
import pytest
from flexible_touchdown import ROLLING, SLIDING
from rotor_cases import both, plant, rigid_rotor, run, state
from scipy.optimize import brentq
from touchdown_cases import coordinates, follow_plant, plant_of
from two_bodies import PHI, THETA, TwoBodies, X, Y

from rotor_analysis.damping import Damping
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor_file import load_rotor

G, CLEARANCE, RADIUS = 9.81, 0.5e-3, 0.025
HALF = 10.0  # kg, carried by either end
FALLING = TwoBodies(mass=HALF, clearance=CLEARANCE, force=-1j * HALF * G)


@pytest.mark.parametrize("angle", [-0.5 * math.pi, 0.3, 1.25 * math.pi])
def test_rotor_falls_through_its_clearance_in_the_direction_of_gravity(angle):
    """It lands after sqrt(2 c/g), with the speed g t."""
    rotor = plant(both("rb.clearance", CLEARANCE) | {"gravity": G, "gravity_angle": angle}, rigid_rotor(2 * HALF))
    landing, h = math.sqrt(2 * CLEARANCE / G), 1e-4
    impulse = run(rotor, 200, ["rb1.impulse"], h)[:, 0]
    assert np.flatnonzero(impulse).tolist() == [int(landing / h)]
    assert impulse.sum() == pytest.approx(HALF * G * landing, rel=1e-8)
    assert rotor["mb1.x"] + 1j * rotor["mb1.y"] == pytest.approx(CLEARANCE * np.exp(1j * angle), abs=1e-12)


def test_retainers_carry_the_weight_of_the_rig_once_it_has_settled():
    """942 N, shared by the rule of the lever; much damping of the shaft brings it to rest soon."""
    rig = replace(load_rotor(), damping=Damping(modal=(0.3,)))
    rotor = plant({"gravity": G} | both("mb.c_b", 500.0), rig)
    run(rotor, 4000, h=250e-6)
    body, at = rigid_body(rig), rig.shaft.nodes
    near, far = (at[site.node - 1] for site in rig.sites[:2])
    share = (body.centre - near) / (far - near)
    assert body.mass * G == pytest.approx(942.0, abs=1.0)
    assert rotor["rb1.f_n"] == pytest.approx((1 - share) * body.mass * G, rel=1e-6)
    assert rotor["rb2.f_n"] == pytest.approx(share * body.mass * G, rel=1e-6)


def at_angle(phi, whirl=0.0, spin=0.0):
    """Positions and velocities with the journal on its retainer at the angle `phi` from x, whirling (rad, rad/s)."""
    q, v = np.zeros(6), np.zeros(6)
    place = CLEARANCE * np.exp(1j * phi)
    q[[X, Y]] = place.real, place.imag
    v[[X, Y]] = (1j * whirl * place).real, (1j * whirl * place).imag
    v[THETA] = spin
    return q, v


def at_rest(spin):
    """Positions and velocities of a rotor that only spins (rad/s)."""
    v = np.zeros(6)
    v[THETA] = spin
    return np.zeros(6), v


def sliding_at_rest(mu, spin, **bodies):
    """A journal that spin and friction hold where gravity balances them: tan(phi) = mu from the bottom."""
    model = TwoBodies(mass=HALF, clearance=CLEARANCE, force=-1j * HALF * G, mu=mu, journal_radius=RADIUS, **bodies)
    normal = HALF * G / math.sqrt(1 + mu**2)
    return model, at_angle(-0.5 * math.pi - math.copysign(math.atan(mu), spin), 0.0, spin), normal


def test_constant_friction_accelerates_a_race_to_the_journal_speed():
    """J w' = mu N (R_s + c) - M, and at the end w (R_s + c) = Omega R_s, but for the rocking of the journal."""
    mu, spin, inertia, drag = 0.15, 200.0, 2e-4, 0.02
    model, start, normal = sliding_at_rest(mu, spin, race_inertia=inertia, race_drag=drag)
    rotor = plant_of(model, *start, SLIDING, max_substep=2e-5)
    radius = RADIUS + CLEARANCE
    acceleration = (mu * normal * radius - drag) / inertia
    speed = follow_plant(rotor, 5e-3 * np.arange(1, 31)).v[:, PHI]
    rising = speed < 0.9 * spin * RADIUS / radius
    assert 5 < rising.sum() < 25
    np.testing.assert_allclose(np.diff(speed[rising][1:]), 5e-3 * acceleration, rtol=1e-6)
    assert speed[-1] == pytest.approx(spin * RADIUS / radius, rel=0.01)
    assert (rotor["rb1.mode"], rotor["rb1.slip_velocity"]) == (ROLLING, pytest.approx(0.0, abs=1e-9))


def test_friction_brakes_a_free_spin_at_a_constant_rate():
    """J Omega' = -mu N R_s at each end; the energy lost by the spin is heat."""
    mu, spin, inertia = 0.1, 150.0, 4e-3
    model, start, normal = sliding_at_rest(mu, spin, spin_inertia=inertia)
    rotor = plant_of(model, *start, SLIDING, max_substep=2e-5)
    times = 0.02 * np.arange(1, 6)
    speed = follow_plant(rotor, times).v[:, THETA]
    np.testing.assert_allclose(speed, spin - mu * normal * RADIUS / inertia * times, rtol=1e-9)
    lost = 0.5 * inertia * (spin**2 - speed[-1] ** 2)
    assert rotor["rb1.heat"] == pytest.approx(lost, rel=1e-7)
    assert rotor["energy.friction"] == pytest.approx(2 * lost, rel=1e-7)


@pytest.mark.parametrize("spin", [40.0, -40.0])
def test_rolling_rotor_is_braked_with_the_inertia_of_its_whirl(spin):
    """It whirls at -Omega R_s/c, so that its energy is (J + m R_s^2) Omega^2/2, which the drive takes away."""
    inertia, torque = 4e-3, -math.copysign(0.5, spin)
    model = TwoBodies(mass=HALF, clearance=CLEARANCE, mu=5.0, journal_radius=RADIUS, spin_inertia=inertia,
                      drive_torque=torque)  # fmt: skip
    rotor = plant_of(model, *at_angle(0.0, -spin * RADIUS / CLEARANCE, spin), ROLLING, max_substep=2e-6)
    times = 0.01 * np.arange(1, 6)
    motion = follow_plant(rotor, times)
    assert np.all(motion.mode == ROLLING)
    expected = spin + torque / (inertia + HALF * RADIUS**2) * times
    np.testing.assert_allclose(motion.v[:, THETA], expected, rtol=1e-7)
    assert rotor["rb1.whirl_speed"] == pytest.approx(-expected[-1] * RADIUS / CLEARANCE, rel=1e-7)
    np.testing.assert_allclose(motion.N, HALF * CLEARANCE * (expected * RADIUS / CLEARANCE) ** 2, rtol=1e-6)
    assert rotor["energy.friction"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("exactly", "tolerance"), [(0, 1e-8), (1, 1e-4)])
def test_free_spin_and_unbalance_keep_energy_and_angular_momentum(exactly, tolerance):
    """Without drive, damping and contact both are constant, while the spin lends energy to the whirl."""
    unbalance, inertia, k = 0.02, 0.02, 1e5
    model = TwoBodies(mass=HALF, clearance=0.1, support_stiffness=k, unbalance=unbalance, spin_inertia=inertia)
    v = np.zeros(6)
    v[THETA] = math.sqrt(k / HALF)
    rotor = plant_of(model, np.zeros(6), v, max_substep=2e-5, **{"solver.exact_motion": exactly})
    energy, momentum, speed = [], [], []
    n = len(coordinates(model))
    h = 1e-3
    for step in range(200):
        rotor.step(step * h, h)
        z = state(rotor)
        r, rate = complex(*z[:2]), complex(*z[n : n + 2])
        e, Omega = unbalance * np.exp(1j * rotor["theta"]), rotor["speed"]
        across = (r.conjugate() * rate).imag * HALF + (r.conjugate() * 1j * Omega * e + e.conjugate() * rate).imag
        momentum.append(inertia * Omega + across)
        energy.append(rotor["energy.kinetic"] + rotor["energy.strain"])
        speed.append(Omega)
    assert np.ptp(speed) > 0.1 * speed[0]
    np.testing.assert_allclose(momentum, inertia * v[THETA], rtol=tolerance)
    np.testing.assert_allclose(energy, inertia * v[THETA] ** 2, rtol=tolerance)
    assert abs(rotor["energy.balance"]) < tolerance * energy[0]


def test_backward_whirl_grows_where_friction_exceeds_its_damping():
    """On a support k, d a sliding journal whirls steadily backward where d w = mu (m w^2 - k).

    N = (m w^2 - k) c presses it outward, mu N drives it against the spin, d w c brakes it: faster whirl grows up to
    rolling, slower whirl dies.
    """
    k, d, mu = 2e5, 800.0, 0.2
    steady = (d + math.sqrt(d**2 + 4 * mu**2 * HALF * k)) / (2 * mu * HALF)
    model = TwoBodies(
        mass=HALF, clearance=CLEARANCE, support_stiffness=k, support_damping=d, mu=mu, journal_radius=RADIUS
    )
    rest = follow_plant(plant_of(model, *at_angle(0.0, -steady, 400.0), SLIDING), np.array([2e-3]))
    assert rest.N[0] == pytest.approx((HALF * steady**2 - k) * CLEARANCE, rel=1e-6)
    slower = plant_of(model, *at_angle(0.0, -0.99 * steady, 400.0), SLIDING, max_substep=2e-5)
    faster = plant_of(model, *at_angle(0.0, -1.01 * steady, 20.0), SLIDING, max_substep=2e-5)
    assert follow_plant(slower, np.array([0.2])).mode[0] != ROLLING
    assert abs(slower["mb1.x"] + 1j * slower["mb1.y"]) < 0.5 * CLEARANCE
    assert follow_plant(faster, 0.1 * np.arange(1, 9)).mode[-1] == ROLLING
    assert faster["rb1.whirl_speed"] == pytest.approx(-20.0 * RADIUS / CLEARANCE, rel=1e-6)


def test_backward_whirl_follows_from_rotor_and_retainer_receptance():
    """Black, J. Mech. Eng. Sci. 10 (1968): a sliding whirl exp(-i w t) keeps its size where (1 + i mu)(A + B) is real.

    A and B are the receptances of rotor and retainer there; N (1 + i mu)(A + B) = -c. Slower whirl dies, faster grows:
    an error of the first steps, too.
    """
    mu = 0.2
    model = TwoBodies(mass=HALF, clearance=CLEARANCE, support_stiffness=2e5, support_damping=800.0, mu=mu,
                      housing_mass=3.0, mount_stiffness=(6e5, 6e5), mount_damping=(300.0, 300.0))  # fmt: skip

    def receptances(w):
        rotor = model.support_stiffness - model.mass * w**2 - 1j * w * model.support_damping
        retainer = model.mount_stiffness[0] - model.housing_mass * w**2 - 1j * w * model.mount_damping[0]
        return np.array([1 / rotor, 1 / retainer])

    def balance(w):
        return ((1 + 1j * mu) * receptances(w).sum()).imag

    w = brentq(balance, 500.0, 1000.0)
    rotor_shift, retainer_shift = receptances(w)
    normal = (-CLEARANCE / ((1 + 1j * mu) * (rotor_shift + retainer_shift))).real
    places = -normal * (1 + 1j * mu) * np.array([rotor_shift, -retainer_shift])
    q, v = (np.concatenate([np.ravel(np.column_stack([z.real, z.imag])), np.zeros(2)])
            for z in (places, -1j * w * places))  # fmt: skip
    v[THETA] = 1000.0
    rotor = plant_of(model, q, v, SLIDING, max_substep=5e-6)
    motion = follow_plant(rotor, math.pi / w * np.arange(1, 5))
    np.testing.assert_allclose(motion.N, normal, rtol=1e-5)
    np.testing.assert_allclose(motion.q[-1], q, atol=1e-5 * CLEARANCE)
    assert rotor["rb1.whirl_speed"] == pytest.approx(-w, rel=1e-5)


def test_retainer_warms_up_by_friction_and_gives_off_heat():
    """C T' = P - h (T - T_a) with P = mu N Omega R_s, up to its limit and beyond."""
    spin, capacity, transfer, ambient = 300.0, 20.0, 40.0, 290.0
    model, start, normal = sliding_at_rest(0.2, spin)
    rotor = plant_of(model, *start, SLIDING, max_substep=1e-4, ambient_temperature=ambient,
                     **both("rb.heat_capacity", capacity), **both("rb.heat_transfer", transfer),
                     **both("rb.temperature_limit", ambient + 2.0))  # fmt: skip
    power = 0.2 * normal * spin * RADIUS
    record = run(rotor, 200, ["rb1.temperature", "rb1.friction_power", "rb1.heat", "rb1.overheated"], 5e-3)
    t = 5e-3 * np.arange(1, 201)
    rise = power / transfer * (1 - np.exp(-transfer / capacity * t))
    np.testing.assert_allclose(record[:, 0], ambient + rise, atol=1e-4)
    np.testing.assert_allclose(record[:, 1], power, rtol=1e-9)
    np.testing.assert_allclose(record[:, 2], power * t, rtol=1e-7)
    assert 0 < np.argmax(rise > 2.0) < 199
    np.testing.assert_array_equal(record[:, 3], rise > 2.0)


def test_heat_of_all_retainers_is_that_of_friction_and_impacts():
    rotor = plant_of(replace(FALLING, mu=0.2, restitution=0.4, race_inertia=1e-4, race_drag=0.05, spin_inertia=0.01),
                     *at_rest(200.0), max_substep=2e-5)  # fmt: skip
    follow_plant(rotor, 1e-3 * np.arange(1, 101))
    heat = rotor["rb1.heat"] + rotor["rb2.heat"]
    assert heat > 1.0
    assert heat == pytest.approx(rotor["energy.friction"] + rotor["energy.impact"], rel=1e-9)


def test_speed_controller_and_drag_settle_the_free_spin_exponentially():
    """J Omega' = g (Omega_d - Omega) - d Omega."""
    inertia, gain, drag, demanded = 0.02, 0.3, 0.1, 120.0
    values = {"spin.free": 1.0, "spin.inertia": inertia, "drive.gain": gain, "drive.torque_limit": 1e3, "Omega": 40.0}
    rotor = plant(values | {"spin.drag": drag}, rigid_rotor(2 * HALF))
    rotor["Omega"] = demanded
    t = 0.01 * np.arange(1, 21)
    settled = gain / (gain + drag) * demanded
    expected = settled + (40.0 - settled) * np.exp(-(gain + drag) / inertia * t)
    np.testing.assert_allclose(run(rotor, 20, ["speed"], 0.01)[:, 0], expected, rtol=1e-8)


def test_base_acceleration_acts_on_journal_and_housing_alike():
    """Both float: from a base that accelerates they seem to move the other way together, and the gap stays."""
    model = TwoBodies(mass=HALF, clearance=CLEARANCE, housing_mass=3.0)
    rotor = plant_of(model, *at_rest(0.0))
    rotor["base.a_x"], rotor["base.a_y"] = 5.0, -2.0
    q = follow_plant(rotor, np.array([0.02])).q[0]
    np.testing.assert_allclose(q[:4], -0.5 * 0.02**2 * np.array([5.0, -2.0, 5.0, -2.0]), rtol=1e-9)
    assert rotor["rb1.gap"] == pytest.approx(CLEARANCE, rel=1e-9)
