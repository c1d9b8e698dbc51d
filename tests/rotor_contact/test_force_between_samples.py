"""The largest and the mean contact force of a step: closed forms, and the momentum that the contact gives the rotor."""

import math

import numpy as np
import pytest
from rotor_cases import H, both, memory, place, plant, rigid_rotor, run, scratch, size_of, symmetric_rotor

from rotor_contact.shaft.lobatto import LOBATTO_POINTS, greatest_of_cubic, greatest_of_parabola
from rotor_contact.shaft.structure import structure_of
from rotor_contact.variables.contact_laws import LAWS

RING, MASS, SPEED, K = 0.05, 10.0, 0.2, 1e8
G = 9.81
PEAKS, MEANS = ["rb1.f_n_peak", "rb2.f_n_peak"], ["rb1.f_n_mean", "rb2.f_n_mean"]


def against_wall(values):
    """Two masses of 10 kg, a step before they fly into the rings of both sites."""
    x = plant(both("rb.clearance", RING) | values, rigid_rotor(2 * MASS))
    return place(x, np.full(2, RING - 0.4 * SPEED * H + 0j), np.full(2, SPEED + 0j))


def momentum(x):
    """Momentum of the rotor in x (kg m/s): the base's unit acceleration is a force of minus the mass."""
    of_all, of_shaft = int(scratch(x).step_cache.n[0]), size_of(x)
    return -float(structure_of(x.constants).B_base[0] @ memory(x).z[of_all : of_all + of_shaft])


def test_peak_of_a_spring_force_between_samples_is_exact():
    """N = v sqrt(m k) sin(omega t): a half-sine of 1 ms, of which samples at 250 us miss up to 8 %."""
    x = against_wall(both("rb.law", LAWS.index("linear")) | both("rb.k_c", K))
    record = run(x, 10, [*PEAKS, *MEANS, "rb1.f_n"])
    assert record[:, 0].max() == pytest.approx(SPEED * math.sqrt(MASS * K), rel=2e-4)
    assert record[:, 0].max() > 1.02 * record[:, 4].max()
    np.testing.assert_allclose(record[:, 2:4].sum(axis=0) * H, 2.0 * MASS * SPEED, rtol=2e-5)


def test_impact_is_an_impulse_and_no_force():
    x = against_wall(both("rb.restitution", 0.5))
    record = run(x, 3, [*PEAKS, *MEANS])
    np.testing.assert_array_equal(record[:, :2], 0.0)
    np.testing.assert_allclose(record[:, 2:].sum(axis=0) * H, 1.5 * MASS * SPEED, rtol=1e-9)


@pytest.mark.parametrize("exact", [True, False], ids=["collocation", "runge_kutta"])
def test_steady_rub_has_one_force(exact):
    """N = m v^2/c of a mass that slides in its ring without friction, equal in sample, mean and peak."""
    x = plant(both("rb.clearance", RING) | {"solver.exact_motion": exact}, rigid_rotor(2 * MASS))
    place(x, np.full(2, RING + 0j), np.full(2, 1j * SPEED), modes=(1, 1))
    record = run(x, 80, ["rb1.f_n", *PEAKS, *MEANS])
    np.testing.assert_allclose(record, MASS * SPEED**2 / RING, rtol=1e-6)


@pytest.mark.parametrize("exact", [True, False], ids=["collocation", "runge_kutta"])
@pytest.mark.parametrize(
    "values",
    [
        {},
        both("rb.restitution", 0.4),
        both("rb.law", LAWS.index("hunt_crossley")) | both("rb.alpha_c", 0.3) | both("rb.k_c", 1e7),
        both("rb.housing_mass", 2.0) | both("rb.mount_stiffness_x", 1e7) | both("rb.mount_damping_x", 3e3),
        {"spin.free": 1.0} | both("rb.race_inertia", 1e-4),
    ],
    ids=["rigid", "bouncing", "yielding", "housings", "races"],
)
def test_mean_forces_sum_up_to_the_change_of_momentum(values, exact):
    """Sum of N_mean h over the sites and steps of a fall along x = change of momentum - m g t."""
    x = plant({"solver.exact_motion": exact} | values, symmetric_rotor())
    rotor, steps = structure_of(x.constants), 240
    mass = float(rotor.B_base[0] @ rotor.Minv @ rotor.B_base[0])
    x["base.a_x"] = -G  # the rotor falls towards x
    record = run(x, steps, [*MEANS, *PEAKS, "rb1.f_n", "rb2.f_n"])
    settings = record[:, :2].sum() * H
    assert record[:, :2].max() > mass * G  # it has touched
    assert settings == pytest.approx(mass * G * steps * H - momentum(x), rel=2e-4)
    assert (record[:, 2:4] >= record[:, 4:]).all()


@pytest.mark.parametrize("law", ["constraint", "kelvin_voigt"])
def test_peak_does_not_depend_on_the_communication_step(law):
    """The first impact of a flexible rotor, and the rub after it."""
    peaks = []
    for h in (250e-6, 20e-6):
        x = plant(both("rb.law", LAWS.index(law)) | both("rb.c_c", 2e4), symmetric_rotor())
        x["base.a_x"] = -G
        peaks.append(run(x, round(0.02 / h), PEAKS, h).max(axis=0))
    np.testing.assert_allclose(peaks[0], peaks[1], rtol=0.01)


def test_position_at_a_site_counts_from_the_centre_of_its_retainer():
    x = plant(both("rb.offset_x", 1e-4) | both("rb.housing_mass", 2.0) | both("rb.mount_stiffness_x", 1e6))
    x["base.a_x"], x["d1.f_y"] = -G, 40.0
    names = ["rb1.x", "rb1.y", "rb1.gap", "mb1.x", "mb1.y", "rb1.housing_x", "rb1.housing_y"]
    record = run(x, 100, names)
    X, Y, gap, x_b, y_b, h_x, h_y = record.T
    np.testing.assert_allclose(X, x_b - 1e-4 - h_x, atol=1e-15)
    np.testing.assert_allclose(Y, y_b - h_y, atol=1e-15)
    np.testing.assert_allclose(gap, 0.75e-3 - np.hypot(X, Y), atol=1e-12)
    assert np.ptp(h_x) > 1e-6


def test_greatest_values_of_cubic_and_parabola():
    rng = np.random.default_rng(3)
    s = np.linspace(0.0, 1.0, 20001)
    for scale in (1.0, 1e-12):
        for _ in range(50):
            c = rng.normal(size=4) * (1.0, 1.0, 1.0, scale)
            cubic = np.polynomial.Polynomial(c)
            assert greatest_of_cubic(*cubic(np.array(LOBATTO_POINTS))) == pytest.approx(cubic(s).max(), abs=1e-7)
            parabola = np.polynomial.Polynomial(c[:3])
            assert greatest_of_parabola(*parabola(np.array([0.0, 0.5, 1.0]))) == pytest.approx(
                parabola(s).max(), abs=1e-7
            )
