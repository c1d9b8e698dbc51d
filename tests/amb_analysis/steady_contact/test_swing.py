"""A fall in the retainers that friction drives over their top: closed form, the plant itself, mounts, drag, weight."""

import math

import numpy as np
import pytest
from fall_over_top import RIGID, friction_over_top
from flexible_touchdown import FREE, SLIDING
from scipy.optimize import brentq
from touchdown_cases import follow_plant, plant_of
from two_bodies import THETA, X_H, Y_H, TwoBodies, X, Y

from amb_analysis.steady_contact.swing import MOST, WhirlForces, least_swinging_friction, whirl_forces

G, CLEARANCE, HALF = 9.81, 0.5e-3, 10.0
PENDULUM = math.sqrt(G / CLEARANCE)
SOFT = HALF * G / (0.2 * CLEARANCE)  # N/m, of a mount on which the rotor sinks by a fifth of the clearance
DAMPED = 0.6 * SOFT / PENDULUM
MOUNT = {"housing_mass": 0.5, "mount_stiffness": (SOFT, SOFT), "mount_damping": (DAMPED, DAMPED)}


def rotor_and_mount(model):
    """Receptance of a free mass at a frequency, and that of its retainer."""

    def relative(omega):
        mount = 0.0
        if model.housing_mass is not None:
            k, d = model.mount_stiffness[0], model.mount_damping[0]
            mount = 1.0 / (k - model.housing_mass * omega**2 + 1j * omega * d)
        return np.array([[-1.0 / (model.mass * omega**2) + mount]])

    return relative


def friction_of(model, g=G):
    c = np.array([model.clearance])
    return least_swinging_friction(whirl_forces(rotor_and_mount(model), [0], c, g), model.mass * g, g)


@pytest.mark.parametrize(("mass", "clearance", "g"), [(10.0, 5e-4, 9.81), (123.0, 2e-4, 9.81), (1.0, 1e-3, 1.6)])
def test_rigid_rotor_in_rigid_retainers_matches_the_closed_form(mass, clearance, g):
    """12 mu^2 exp(2 pi mu) = 3, whatever its mass, its clearance and gravity."""
    assert friction_of(TwoBodies(mass=mass, clearance=clearance), g) == pytest.approx(RIGID, rel=1e-3)


@pytest.mark.parametrize("h", [0.5, 1.0, 1.8])
def test_a_higher_fall_whirls_with_less_friction(h):
    forces = whirl_forces(rotor_and_mount(TwoBodies(mass=HALF, clearance=CLEARANCE)), [0], np.array([CLEARANCE]), G)
    assert least_swinging_friction(forces, HALF * G, G, h) == pytest.approx(friction_over_top(h), rel=1e-3)


@pytest.mark.parametrize("share", [0.1, 0.6, 1.0])
def test_a_seal_that_holds_the_rotor_acts_as_a_lower_fall(share):
    """u - k/m obeys the equation of a rotor without seals that falls by h = 1 - k c/(m g)."""
    k, h = share * HALF * G / CLEARANCE, 1.0 - share

    def relative(omega):
        return np.array([[1.0 / (k - HALF * omega**2) + 0j]])

    forces = whirl_forces(relative, [0], np.array([CLEARANCE]), G, held=True)
    assert least_swinging_friction(forces, HALF * G, G) == pytest.approx(friction_over_top(h, most=2.0), rel=1e-3)


def test_a_rotor_that_its_seals_hold_above_the_lowest_point_does_not_whirl():
    """It falls by 2 m g/k, less than the clearance."""
    k = 2.1 * HALF * G / CLEARANCE
    forces = whirl_forces(
        lambda omega: np.array([[1.0 / (k - HALF * omega**2) + 0j]]), [0], np.array([CLEARANCE]), G, held=True
    )
    assert least_swinging_friction(forces, HALF * G, G) == MOST


@pytest.mark.parametrize("share", [0.38, 0.42, 0.7])
def test_a_journal_that_carries_little_of_its_mass_passes_the_top_without_friction(share):
    """N + W cos theta = M (2 g h - 4 g share) - W > 0 at the top with mu = 0, so that share < 2/5."""
    forces = whirl_forces(rotor_and_mount(TwoBodies(mass=HALF, clearance=CLEARANCE)), [0], np.array([CLEARANCE]), G)
    least = least_swinging_friction(forces, share * HALF * G, G)
    assert (least == 0.0) == (share < 0.4)
    assert least < RIGID


@pytest.mark.parametrize("Omega", [0.0, 1e3, 5e3])
def test_gyroscopic_moments_do_not_act_on_journals_that_swing_side_by_side(Omega):
    """A rigid rotor with J_p Omega/(J_t sqrt(g/c)) up to 10 has the closed form at all speeds: it does not tilt."""
    mass, polar, transverse, arms = 2.0 * HALF, 0.02, 0.07, np.array([-0.15, 0.15])

    def relative(omega):
        tilting = transverse * omega**2 - polar * Omega * omega
        return -np.ones((2, 2)) / (mass * omega**2) - np.outer(arms, arms) / tilting

    forces = whirl_forces(relative, [0, 1], np.full(2, CLEARANCE), G)
    np.testing.assert_allclose(forces.N, mass * CLEARANCE * forces.omega**2, rtol=1e-9)
    assert least_swinging_friction(forces, mass * G, G) == pytest.approx(RIGID, rel=1e-3)


def swing_up(mu, **mount):
    """Return the angle from the lowest point at each time, and the mode of contact, of a fall from the centre."""
    model = TwoBodies(mass=HALF, clearance=CLEARANCE, force=-1j * HALF * G, mu=mu, **mount)
    q, v = np.zeros(6), np.zeros(6)
    q[Y], v[X], v[THETA] = -CLEARANCE, -math.sqrt(2.0 * G * CLEARANCE), 400.0
    motion = follow_plant(plant_of(model, q, v, SLIDING, max_substep=1e-4), 0.04 / PENDULUM * np.arange(1, 201))
    x, y = motion.q[:, X] - motion.q[:, X_H], motion.q[:, Y] - motion.q[:, Y_H]
    return -np.unwrap(np.angle(1j * (x + 1j * y))), motion.mode


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_the_plant_stays_in_contact_up_to_the_top_with_this_friction(share):
    angle, mode = swing_up(share * RIGID)
    before = mode[: np.argmax(angle >= math.pi)]
    assert len(before) > 20
    assert bool((before != FREE).all()) is (share > 1.0)


@pytest.mark.parametrize("share", [0.9, 1.25])
def test_the_plant_swings_over_the_top_at_about_the_least_friction(share):
    """Receptances assume steady whirl, while this one accelerates and decelerates: 15 % to the safe side."""
    angle, _ = swing_up(share * friction_of(TwoBodies(mass=HALF, clearance=CLEARANCE, **MOUNT)), **MOUNT)
    assert bool(angle.max() >= math.pi) is (share > 1.0)


def test_a_damped_mount_raises_the_friction_and_a_stiff_one_does_not():
    soft, stiff = (
        friction_of(
            TwoBodies(mass=HALF, clearance=CLEARANCE, housing_mass=0.5, mount_stiffness=(k, k), mount_damping=(d, d))
        )
        for k, d in ((SOFT, DAMPED), (1e4 * SOFT, DAMPED))
    )
    assert soft > 1.5 * RIGID
    assert stiff == pytest.approx(RIGID, rel=2e-3)


@pytest.mark.parametrize("share", [-0.1, 0.1])
def test_a_force_against_backward_whirl_raises_the_friction(share):
    """Cross coupling that drives forward whirl is such a force, L = Q c; one that drives backward whirl lowers it.

    With l = L/W, N + W cos theta at the top is W ((2 - A - l/mu) exp(2 pi mu) - A + l/mu - 1) = 0, where A = (2 - 4
    mu^2)/(1 + 4 mu^2).
    """

    def at_top(mu):
        A = (2.0 - 4.0 * mu**2) / (1.0 + 4.0 * mu**2)
        return (2.0 - A - share / mu) * math.exp(2.0 * math.pi * mu) - A + share / mu - 1.0

    omega = PENDULUM * np.linspace(0.01, 8.0, 400)
    forces = WhirlForces(CLEARANCE, omega, HALF * CLEARANCE * omega**2, np.full(400, share * HALF * G))
    found = least_swinging_friction(forces, HALF * G, G)
    assert found == pytest.approx(brentq(at_top, 0.02, 0.6), rel=2e-3)
    assert (found > RIGID) is (share > 0.0)


def test_least_friction_is_zero_without_weight_and_infinite_if_free():
    light = whirl_forces(rotor_and_mount(TwoBodies(mass=HALF, clearance=CLEARANCE)), [0], np.array([CLEARANCE]), G)
    assert least_swinging_friction(light, 0.0, G) == 0.0
    held = whirl_forces(lambda omega: np.array([[1e-9 + 0j]]), [0], np.array([CLEARANCE]), G)  # a spring to the centre
    assert least_swinging_friction(held, HALF * G, G) == MOST
