"""Contact: its detection, its share of a revolution, and contact-aware adaptation."""

import math

import numpy as np
import pytest
from rig import pack

from amb_cosim.model_constants.controller_data import inverse_receptance
from rolac_controller.enumerations import GIVEN, NO_SOURCE, OWN_SENSORS

CLEARANCE = 0.75e-3
SAMPLES = 40


@pytest.mark.parametrize(
    ("source", "radius", "state", "found"),
    [(NO_SOURCE, 2.0, 3, 0.0), (OWN_SENSORS, 0.999, 0, 1.0), (OWN_SENSORS, 0.97, 3, 0.0), (GIVEN, 0.999, 0, 0.0)],
)
def test_sensors_of_a_retainer_detect_a_journal_at_its_clearance(bench, speed_of, source, radius, state, found):
    b = bench(Omega=speed_of(SAMPLES), contact__source=source, contact_state=state)
    turning = np.array([0, 0, 1, -1j, 0, 0, 0, 0])
    b.follow(lambda theta: radius * CLEARANCE * (turning * np.exp(1j * theta)).real, 20 * SAMPLES)
    assert b["mb2.contact_share"] == pytest.approx(found, abs=1e-8)
    assert b["mb1.contact_share"] == 0.0


@pytest.mark.parametrize("duty", [0.1, 0.5])
def test_contact_share_is_the_fraction_of_the_revolution_in_contact(bench, speed_of, duty):
    b = bench(Omega=speed_of(SAMPLES), contact__source=GIVEN)
    shares = []
    for n in range(30 * SAMPLES):
        b["contact_state"] = 1.0 if n % SAMPLES < duty * SAMPLES else 0.0
        b.sample()
        shares.append(b["mb1.contact_share"])
    assert np.mean(shares[-SAMPLES:]) == pytest.approx(duty, rel=1e-3)


def test_contact_share_decays_to_1_over_e_in_a_revolution(bench, speed_of):
    b = bench(Omega=speed_of(400), contact__source=GIVEN)
    b["contact_state"] = 1.0
    for _ in range(20 * 400):
        b.sample()
    b["contact_state"] = 0.0
    for _ in range(400):
        b.sample()
    assert b["mb1.contact_share"] == pytest.approx(1.0 / math.e, rel=2e-3)


def test_contact_aware_adaptation_without_contact_is_rolac(adapting):
    aware = adapting(10, contact__source=OWN_SENSORS, contact__aware=1)
    np.testing.assert_array_equal(aware.forces(), adapting(10).forces())
    assert aware.forces().all()


def test_contact_turns_the_step_against_the_displacement_by_its_share(bench, receptance, speed_of):
    """U_b' = alpha [(1 - p) (H Q)_b - p exp(j psi) |(H Q)_b| q_b/|q_b|], bearing by bearing."""
    steps, lead, share = 100, 0.4, 0.3
    q = 1e-4 * np.exp(1j * np.arange(8.0))
    b = bench(
        pack([1.0], [receptance]), Omega=speed_of(400), contact__source=GIVEN, contact__aware=1, contact__lead=lead
    )
    n = 0

    def run(count):
        nonlocal n
        for _ in range(count):
            n += 1
            b["contact_state"] = 1.0 if n % 10 < 10 * share else 0.0
            b.follow(lambda theta: (q * np.exp(1j * theta)).real, 1)

    run(20 * 400)
    b["rolac_enable"] = 1.0
    run(steps)
    h = inverse_receptance(receptance) @ q
    at_mb1 = q[[4, 5]]
    turned = -np.exp(1j * lead) * np.linalg.norm(h[:2]) * at_mb1 / np.linalg.norm(at_mb1)
    expected = 7.0 * steps * b.h * np.concatenate([(1.0 - share) * h[:2] + share * turned, h[2:]])
    np.testing.assert_allclose(b.forces(), expected, rtol=1e-2)


def test_a_journal_without_vibration_is_adapted_as_in_rolac(bench, receptance, speed_of):
    def forces(state):
        values = {"contact__source": GIVEN, "contact__aware": 1, "rolac__check_sensors": 0, "contact_state": state}
        b = bench(pack([1.0], [receptance]), Omega=speed_of(SAMPLES), rolac_enable=1.0, **values)
        b.follow(lambda theta: 1e-4 * math.cos(theta) * np.array([1, 1, 0, 0, 0, 0, 1, 1.0]), 200)
        return b.forces()

    assert np.abs(forces(3.0)).min() > 0.0
    np.testing.assert_array_equal(forces(3.0), forces(0.0))


class Rubbing:
    """One mass in x and y, synchronous and above its critical speed, on its steady rub of a ring without friction.

    Free: D q = F + U, D = k - m Omega^2 + j c Omega. In contact |q| = clearance, (D + N/clearance) q = F + U.
    """

    mass, stiffness, damping = 50.0, 2e5, 2e3

    def __init__(self, Omega, unbalance):
        self.d = self.stiffness - self.mass * Omega**2 + 1j * self.damping * Omega
        self.unbalance = unbalance
        self.rubs = True

    def position(self, u):
        """q and the normal force N; it leaves the ring when no N >= 0 holds it there, and comes back when q gets large.

        |D + N/c| c = |F|: N = -c Re D + sqrt(|F|^2 - (c Im D)^2).
        """
        total = self.unbalance + u
        room = abs(total) ** 2 - (CLEARANCE * self.d.imag) ** 2
        normal = -CLEARANCE * self.d.real + math.sqrt(room) if room >= 0.0 else -1.0
        free = total / self.d
        self.rubs = normal >= 0.0 if self.rubs else abs(free) > CLEARANCE
        return (total / (self.d + normal / CLEARANCE), normal) if self.rubs else (free, 0.0)


def rubbing_case(bench, speed_of, aware):
    """Force on MB1 x, whether it rubs, after two seconds of adaptation that begin in a rub of all four axes."""
    speed = speed_of(SAMPLES)
    r = np.zeros((8, 4), dtype=complex)
    rotor = Rubbing(speed, 4000.0 + 0j)
    for k, sensor in enumerate((4, 5, 2, 3)):
        r[sensor, k] = r[(6, 7, 0, 1)[k], k] = 1.0 / rotor.d
    values = {"contact__source": GIVEN, "contact__aware": aware, "rolac__force_limit": 1e5, "rolac_enable": 1.0}
    b = bench(pack([1.0], [r]), Omega=speed, **values)
    trace = []
    for _ in range(8000):
        u = b.forces()[0]  # axes x of both bearings alike, y a quarter of a turn behind: a circular orbit
        q, normal = rotor.position(u)
        b["contact_state"] = 3.0 if normal > 0.0 else 0.0
        x, y = (q * np.exp(1j * b.theta)).real, (-1j * q * np.exp(1j * b.theta)).real
        b.sense([x, y] * 4)
        b.sample()
        trace.append((abs(u), normal))
    return rotor, np.array(trace)


def test_rolac_pumps_its_force_while_a_supercritical_journal_rubs(bench, speed_of):
    """Its force grows far beyond the unbalance force, 4 kN, that it should cancel, and the rub continues."""
    rotor, trace = rubbing_case(bench, speed_of, 0.0)
    assert rotor.rubs
    assert trace[-1, 0] > 5.0 * 4000.0
    assert trace[-1, 1] > trace[0, 1]


def test_contact_aware_adaptation_ends_that_rub_at_the_optimum(bench, speed_of):
    rotor, trace = rubbing_case(bench, speed_of, 1.0)
    assert trace[0, 1] > 1000.0
    assert not rotor.rubs
    assert trace[:, 0].max() < 2.0 * 4000.0
    assert trace[-1, 0] == pytest.approx(4000.0, rel=0.05)
