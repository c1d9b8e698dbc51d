"""Whirl of a rotor that stands on a face: growth by its closed form, its sign, and a race that follows."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from instances import initialised
from rotor_cases import memory, state

from amb_analysis.linear.linear_source import source_of_run
from amb_analysis.steady_contact.face_whirl import StandingRotor, standing_rotor
from amb_cosim.model_constants import plant_data
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.rotor_file import load_rotor

PUMP = Path(__file__).parents[2] / "system" / "upright_pump"
M, J_P, J_T, HEIGHT, R, G = 7.41, 0.02501, 0.02929, 0.115, 0.014, 9.81
OMEGA = 1200.0 * np.pi


def rigid(stiffness=3e7, restitution=0.9999, side=1.0, height=-HEIGHT, slip=OMEGA, **race):
    """A rigid rotor in (x, y, x', y') of its centre of mass, whose face is `height` above it."""
    A, n = np.zeros((8, 8)), 4
    A[:n, n:] = np.eye(n)
    A[6, 7], A[7, 6] = -J_P * slip / J_T, J_P * slip / J_T
    place, lean = np.hstack([np.eye(2), height * np.eye(2)]), np.hstack([np.zeros((2, 2)), np.eye(2)])
    inverse = np.diag([1.0 / M, 1.0 / M, 1.0 / J_T, 1.0 / J_T])
    rows = np.vstack([place, lean, place @ inverse, lean @ inverse])
    of_race = {"race_inertia": 0.0, "race_drag": 0.0} | race
    return StandingRotor(A, M, rows, side, height, stiffness, restitution, R, slip, M * G, **of_race)


def closed_form(mu, damping=0.0, slip=OMEGA, side=1.0, stiffness=3e7):
    """J_t l^2 - (i J_p Omega - d_t (1 - i kappa)) l + k_t (1 - i kappa) + n N h = 0, kappa = -n mu h/R sgn(Omega)."""
    kappa = side * mu * HEIGHT / R * np.sign(slip)
    k_t, d_t, turned = 0.5 * stiffness * R * R, 0.5 * damping * R * R, 1.0 - 1j * kappa
    roots = np.roots([J_T, -(1j * J_P * slip - d_t * turned), k_t * turned - side * M * G * HEIGHT])
    return max(roots.real)


@pytest.mark.parametrize(("mu", "growth"), [(0.12, 30.2), (0.2, 50.3)])
@pytest.mark.parametrize("slip", [OMEGA, -OMEGA], ids=["forward", "backward spin"])
def test_growth_without_loss_is_that_of_the_closed_form(mu, growth, slip):
    found = rigid(restitution=1.0, slip=slip).whirl(mu).growth
    assert found == pytest.approx(growth, rel=5e-3)  # of creep of the face across the shaft, too
    assert found == pytest.approx(closed_form(mu, slip=slip), rel=5e-3)


@pytest.mark.parametrize(("stiffness", "growth"), [(1e7, 10.0), (3e7, 38.0), (1e8, 137.0)])
def test_growth_depends_on_the_stiffness_of_the_face(stiffness, growth):
    """The numbers are those of an independent computation, with a restitution of 0.7 and a friction of 0.2."""
    assert rigid(stiffness, 0.7).whirl(0.2).growth == pytest.approx(growth, rel=0.05)
    assert rigid(restitution=0.7).whirl(0.2, stiffness / 3e7).growth == pytest.approx(growth, rel=0.05)


def test_a_seat_above_the_centre_that_pushes_up_drives_slow_backward_whirl():
    """kappa < 0: nutation is damped, and precession grows slowly."""
    above = rigid(restitution=1.0, height=HEIGHT).whirl(0.2).growth
    kappa = -0.2 * HEIGHT / R
    k_t = 0.5 * 3e7 * R * R
    roots = np.roots([J_T, -1j * J_P * OMEGA, k_t * (1.0 - 1j * kappa) + M * G * HEIGHT])
    assert above == pytest.approx(max(roots.real), rel=2e-3)
    assert above > 0.0


def test_a_lossy_face_lets_no_whirl_grow():
    assert rigid(restitution=0.3).whirl(0.12).growth == 0.0


def test_a_race_that_follows_ends_the_drive():
    """J_r Omega/(mu W R - M): 0.19 s; the balls of a stiff drag never let it follow."""
    free = {"race_inertia": 6e-6, "race_drag": 5e-3}
    assert rigid(**free).whirl(0.12).follows_after == pytest.approx(0.19, rel=0.03)
    assert rigid(race_inertia=6e-6, race_drag=1.0).whirl(0.12).follows_after == np.inf
    assert rigid().whirl(0.12).follows_after == np.inf


def test_the_least_friction_is_where_whirl_begins_to_grow_enough():
    fixed = rigid(restitution=0.5)
    least = fixed.least_driving()
    assert not fixed.whirl(0.99 * least).is_driven
    assert fixed.whirl(1.01 * least).is_driven
    followed = replace(fixed, race_inertia=6e-6, race_drag=1e-4)
    assert followed.least_driving() > least


def test_a_drift_by_cross_coupling_is_not_whirl_that_friction_drives():
    """m z'' = i Q z grows with sqrt(Q/(2 m)), although nothing rubs."""
    free, Q = rigid(restitution=0.5), 4700.0
    A = free.A.copy()
    A[4, 1], A[5, 0] = -Q / M, Q / M
    coupled = replace(free, A=A)
    assert free.drift == 0.0
    assert coupled.drift == pytest.approx(np.sqrt(Q / (2.0 * M)), rel=1e-3)
    assert not coupled.topples
    assert coupled.whirl(0.0).growth == 0.0
    assert coupled.least_driving() == pytest.approx(free.least_driving(), rel=0.05)


def test_a_rotor_topples_on_a_face_softer_than_its_weight_needs():
    """It stands upright above k = 2 N |h|/R^2, which is 85 kN/m."""
    assert rigid(8e4, slip=1.0).topples
    assert rigid(8e4, slip=1.0).drift > 1.0
    assert not rigid(9e4, slip=1.0).topples


def test_growth_of_a_flexible_rotor_is_that_of_its_simulation():
    source = source_of_run(prepare_run(load_scenario(str(PUMP / "landing.toml"))))
    found = standing_rotor(source, 0, OMEGA, M * G)
    assert (found.side, found.height) == (1.0, pytest.approx(-HEIGHT, rel=0.01))
    assert (found.race_inertia, found.race_drag, found.radius) == (6e-6, 5e-3, R)
    rotor = load_rotor(PUMP / "rotor.toml")
    values = {"gravity": G, "thrust.tilt": np.pi / 2, "Omega": OMEGA, "seat.mu": 0.12, "seat.restitution": 1.0}
    values |= {f"{site.name}.enabled": 0.0 for site in rotor.sites}
    x = initialised(*plant_data.plant(rotor), values)
    memory(x).axial[0].z = -(x["seat.clearance"] + found.mass * G / found.stiffness)
    memory(x).faces[0].is_pressed = 1.0
    state(x)[0] = 1e-9
    size = []
    for n in range(4000):
        x.step(n * 50e-6, 50e-6)
        size.append(np.hypot(x["seat.centre_x"], x["seat.centre_y"]))
    early, late = np.mean(size[1900:2000]), np.mean(size[3900:])
    assert replace(found, restitution=1.0).whirl(0.12).growth == pytest.approx(np.log(late / early) / 0.1, rel=0.01)
