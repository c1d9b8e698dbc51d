"""The classical contact laws: one blow against a wall in closed form, energy, friction, and the limit of a stiff law.

A rigid rotor of two times 10 kg flies along x into the rings of both sites, so each site is a mass of 10 kg.
"""

import math

import numpy as np
import pytest
from rotor_cases import H, bearing_positions, both, masters, place, plant, rigid_rotor, run

from rotor_contact.contact.compliant import normal_force
from rotor_contact.contact.friction import SLIP_SCALE, compliant_friction, compliant_friction_damping
from rotor_contact.contact.site import SITE
from rotor_contact.variables.contact_laws import COMPLIANT, LAWS, compliant_response

RING, MASS, SPEED = 0.05, 10.0, 0.2
K = 1e8
FINE = {"solver.max_substep": 1e-6}
LOSSLESS = ["linear", "hertz", "kirk", "switched_kelvin_voigt"]
DAMPING = {
    "kelvin_voigt": {"c_c": 1e4},
    "kirk": {"c_c": 1e4, "delta_c": 2e-5},
    "hunt_crossley": {"alpha_c": 1.0},
    "ulbrich": {"eta": 0.3},
    "switched_kelvin_voigt": {"c_c": 1e4, "delta_c": 2e-6},
}


def sites(law, **values):
    settings = {"law": LAWS.index(law), "clearance": RING, "k_c": K} | values
    return {name: value for key, v in settings.items() for name, value in both(f"rb.{key}", v).items()}


def blow(law, speed=SPEED, h=2e-6, steps=3000, **values):
    """Time, penetration, normal force and radial velocity at site 1, from just before an impact to well after it."""
    x = plant(sites(law, **values) | FINE, rigid_rotor(2 * MASS))
    place(x, np.full(2, RING - 1e-9 + 0j), np.full(2, speed + 0j))
    names = ["rb1.gap", "rb1.f_n", "rb2.f_n", "energy.impact", "energy.balance", "energy.strain"]
    record, velocity = np.empty((steps, len(names))), np.empty(steps)
    for n in range(steps):
        x.step(n * h, h)
        record[n] = [x[name] for name in names]
        velocity[n] = masters(x)[1][0].real
    return h * np.arange(1, steps + 1), record, velocity


def restitution(law, speed=SPEED, **values):
    _, record, velocity = blow(law, speed, **values)
    assert record[-1, 0] > 0.0  # it has left
    return -velocity[-1] / speed


def site_under(law, **values):
    site = np.zeros(1, SITE).view(np.recarray)[0]
    for name, value in ({"k_c": K, "delta_c": 2e-5, "law": LAWS.index(law)} | DAMPING.get(law, {}) | values).items():
        setattr(site, name, value)
    return site


def test_each_number_selects_the_formula_of_its_law():
    formulas, depth, rate = dict(zip(LAWS[1:], COMPLIANT, strict=True)), 3e-5, 0.004
    responses = {}
    for law, (formula, _) in formulas.items():
        site = site_under(law, c_c=1e4, alpha_c=1.0, eta=0.3)
        responses[law] = normal_force(site, depth, rate)
        assert formula.__name__ == law
        assert compliant_response(site, depth, rate) == formula(site, depth, rate)
    assert len(set(responses.values())) == len(LAWS) - 1


@pytest.mark.parametrize("law", LAWS[1:])
def test_stored_energy_is_the_integral_of_the_elastic_force(law):
    site, depths = site_under(law), np.linspace(0.0, 6e-5, 4001)
    elastic = np.array([compliant_response(site, depth, 0.0).elastic for depth in depths])
    stored = [compliant_response(site, depth, 0.0).stored for depth in depths]
    work = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(depths) * (elastic[1:] + elastic[:-1]))])
    np.testing.assert_allclose(stored, work, rtol=1e-5, atol=1e-6 * work[-1])


@pytest.mark.parametrize("law", LAWS[1:])
def test_normal_force_is_at_most_twice_as_steep_as_its_bounds(law):
    """The length of substeps rests on them."""
    site, h = site_under(law), 1e-6
    for depth in np.linspace(1e-6, 6e-5, 40):
        for rate in np.linspace(-0.1, 0.1, 21):
            at = compliant_response(site, depth * (1 + h), abs(rate))
            deeper, faster = normal_force(site, depth * (1 + h), rate), normal_force(site, depth, rate + h)
            now = normal_force(site, depth, rate)
            assert (deeper - now) / (depth * h) <= 2.0 * at.stiffness
            assert (faster - now) / h <= 2.0 * at.damping + 1e-3


@pytest.mark.parametrize("law", LOSSLESS)
def test_impact_without_damping_is_elastic(law):
    _, record, velocity = blow(law)
    assert np.max(record[:, 1]) > 1e3
    assert -velocity[-1] == pytest.approx(SPEED, rel=1e-6 if law != "switched_kelvin_voigt" else 1e-5)
    assert record[-1, 3] == pytest.approx(0.0, abs=1e-4 * MASS * SPEED**2)


@pytest.mark.parametrize("law", DAMPING)
def test_damping_of_a_law_warms_the_retainers_where_it_acts(law):
    """Both ends lose half of the energy that the blow takes, as in an impact of rigid rings."""
    x = plant(sites(law, heat_capacity=2.0, **DAMPING[law]) | FINE, rigid_rotor(2 * MASS))
    place(x, np.full(2, RING - 1e-9 + 0j), np.full(2, SPEED + 0j))
    run(x, 3000, h=2e-6)
    lost = 0.5 * MASS * (SPEED**2 - masters(x)[1][0].real ** 2)
    assert lost > 0.1 * MASS * SPEED**2
    assert [x["rb1.heat"], x["rb2.heat"]] == pytest.approx([lost, lost], rel=1e-3)
    assert x["rb1.temperature"] - x["ambient_temperature"] == pytest.approx(0.5 * lost, rel=1e-3)


def test_linear_spring_holds_the_mass_for_half_a_period():
    _, record, _ = blow("linear")
    omega = math.sqrt(K / MASS)
    inside = record[:, 0] < 0.0
    assert np.count_nonzero(inside) * 2e-6 == pytest.approx(math.pi / omega, abs=4e-6)
    assert np.min(record[:, 0]) == pytest.approx(-SPEED / omega, rel=1e-5)
    np.testing.assert_allclose(record[inside, 1], -K * record[inside, 0], rtol=1e-9)


def test_hertz_contact_has_the_depth_and_duration_of_hertz():
    """delta_max = (5 m v^2/(4 K))^(2/5), duration 2.9432 delta_max/v, with K = k_c/sqrt(delta_c) (N/m^1.5)."""
    delta_c = 4e-5
    _, record, _ = blow("hertz", delta_c=delta_c)
    deepest = (5 * MASS * SPEED**2 / (4 * K / math.sqrt(delta_c))) ** 0.4
    assert -np.min(record[:, 0]) == pytest.approx(deepest, rel=1e-5)
    assert np.count_nonzero(record[:, 0] < 0.0) * 2e-6 == pytest.approx(2.9432 * deepest / SPEED, abs=4e-6)
    at = np.argmin(np.abs(record[:, 0] + delta_c))
    assert record[at, 1] == pytest.approx(K * delta_c, rel=0.05)  # k_c is the secant stiffness there


@pytest.mark.parametrize("zeta", [0.05, 0.3])
def test_kelvin_voigt_restitution_is_the_closed_form_without_tension(zeta):
    """The mass leaves when N = 0: e = exp(-zeta (pi - 2 asin zeta)/sqrt(1 - zeta^2))."""
    c_c = 2 * zeta * math.sqrt(K * MASS)
    expected = math.exp(-zeta * (math.pi - 2 * math.asin(zeta)) / math.sqrt(1 - zeta**2))
    _, record, velocity = blow("kelvin_voigt", c_c=c_c)
    assert np.min(record[:, 1]) >= 0.0
    assert -velocity[-1] / SPEED == pytest.approx(expected, rel=1e-8)
    first = np.argmax(record[:, 1] > 0.0)
    assert record[first, 1] == pytest.approx(c_c * SPEED, rel=0.1)  # it hits the damper first


def test_hunt_crossley_restitution_falls_linearly_with_approach_speed():
    """e = 1 - alpha_c delta'(0), to first order in it."""
    errors = [restitution("hunt_crossley", speed, alpha_c=0.5) - (1 - 0.5 * speed) for speed in (0.1, 0.2, 0.4)]
    assert errors[-1] < 0.05
    np.testing.assert_allclose(np.log2(np.array(errors[1:]) / errors[:-1]), 2.0, atol=0.2)


def test_restitution_of_ulbrich_follows_from_its_two_branches():
    """Compression takes (1 + 3/2 eta) times the elastic work, expansion returns (1 - 3/2 eta) times it."""
    eta = 0.2
    expected = math.sqrt((1 - 1.5 * eta) / (1 + 1.5 * eta))
    assert restitution("ulbrich", 1.0, eta=eta) == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("law", ["kirk", "hunt_crossley", "ulbrich", "switched_kelvin_voigt"])
def test_force_of_the_smooth_laws_grows_from_zero(law):
    _, record, _ = blow(law, h=1e-7, steps=40, **DAMPING[law])
    first = record[np.argmax(record[:, 0] < 0.0), 1]
    peak = np.max(blow(law, **DAMPING[law])[1][:, 1])
    assert 0.0 <= first < 0.03 * peak


@pytest.mark.parametrize("law", DAMPING)
def test_damped_impact_turns_the_lost_kinetic_energy_into_heat(law):
    _, record, velocity = blow(law, **DAMPING[law])
    lost = MASS * (SPEED**2 - velocity[-1] ** 2)  # both sites
    assert 0.05 * MASS * SPEED**2 < lost < 0.95 * MASS * SPEED**2
    assert record[-1, 3] == pytest.approx(lost, rel=1e-4)
    assert np.max(np.abs(record[:, 4])) < 1e-4 * MASS * SPEED**2
    assert np.min(record[:, 1]) >= 0.0
    np.testing.assert_allclose(record[:, 1], record[:, 2], rtol=1e-6, atol=1e-6 * np.max(record[:, 1]))


@pytest.mark.parametrize("law", LAWS[1:])
def test_hard_impact_is_resolved_without_a_setting_for_substeps(law):
    """2 m/s into 5e9 N/m lasts less than a communication step; the rebound is that of very short substeps."""

    def rebound(**solver):
        x = plant(sites(law, **DAMPING.get(law, {}) | {"k_c": 5e9}) | solver, rigid_rotor(2 * MASS))
        place(x, np.full(2, RING - 1e-4 + 0j), np.full(2, 2.0 + 0j))
        run(x, 8)
        assert abs(x["energy.balance"]) < 1e-3 * MASS * 2.0**2
        return masters(x)[1][0].real

    assert rebound() == pytest.approx(rebound(**FINE), rel=1e-3)
    assert rebound() < 0.0


@pytest.mark.parametrize("law", LAWS[1:])
@pytest.mark.parametrize("Omega", [100.0, -100.0])
def test_friction_of_a_compliant_contact_opposes_the_slip(law, Omega):
    values = sites(law, mu=0.2) | {"Omega": Omega, "mb1.f_x": 1e3, "mb2.f_x": 1e3}
    x = plant(values, rigid_rotor(2 * MASS))
    place(x, np.full(2, RING + 1e-5 + 0j), np.zeros(2))
    run(x, 1)
    assert x["rb1.f_n"] > 0.0
    assert x["rb1.f_t"] == pytest.approx(-math.copysign(0.2, Omega) * x["rb1.f_n"], rel=1e-6)
    assert math.copysign(1.0, masters(x)[1][0].imag) == -math.copysign(1.0, Omega)


@pytest.mark.parametrize("law", LAWS[1:])
def test_stiff_law_carries_the_rubbing_rotor_as_the_constraint_does(law):
    """A ring carries m c omega^2 of a rotor that whirls in it, and yields slightly."""
    deep = MASS * 1.0 / RING / 1e10
    x = plant(sites(law, k_c=1e10, delta_c=deep), rigid_rotor(2 * MASS))
    place(x, np.full(2, RING + deep + 0j), np.full(2, 1j))
    record = run(x, 40, ["rb1.f_n", "rb1.whirl_speed", "rb1.mode"])
    np.testing.assert_allclose(np.mean(record[:, 0]), MASS * 1.0 / RING, rtol=0.02)
    np.testing.assert_allclose(record[:, 1], 20.0, rtol=1e-3)
    assert np.all(np.abs(np.abs(bearing_positions(x)) - RING) < 1e-6)


def test_journal_in_compliant_contact_creeps_into_rolling():
    """Friction has a slope instead of sticking: the slip left is below its scale, and the mode says rolling."""
    x = plant(sites("linear", mu=0.5) | {"Omega": 80.0}, rigid_rotor(2 * MASS))
    place(x, np.full(2, RING + 1e-6 + 0j), np.full(2, -1j))
    record = run(x, round(0.4 / H), ["rb1.mode", "rb1.slip_velocity", "rb1.whirl_speed"])
    assert record[0, 0] == 1
    assert record[-1, 0] == 2
    assert abs(record[-1, 1]) < 1e-2
    assert record[-1, 2] == pytest.approx(-0.025 / RING * 80.0, rel=5e-3)


def test_compliant_and_rigid_sites_can_be_combined():
    values = both("rb.clearance", RING) | {"rb2.law": LAWS.index("linear"), "mb1.f_x": 500.0, "mb2.f_x": 500.0}
    x = plant(values | both("mb.c_b", 2e3), rigid_rotor(2 * MASS))
    run(x, 4000)
    assert x["rb1.gap"] == 0.0
    assert x["rb2.gap"] == pytest.approx(-500.0 / K, rel=1e-3)
    assert (x["rb1.f_n"], x["rb2.f_n"]) == (pytest.approx(500.0, rel=1e-3), pytest.approx(500.0, rel=1e-3))
    assert x["contact_state"] == 3


@pytest.mark.parametrize("stribeck_velocity", [0.0, 0.05])
def test_friction_of_a_compliant_contact_is_no_steeper_than_its_bound(stribeck_velocity):
    """The length of substeps rests on it. Beyond 3 v_r, where tanh has all but a hundredth of its slope behind it, the
    bound is that of the Stribeck curve alone."""
    normal, mu, static = 100.0, 0.1, 0.3
    site = np.zeros(1, SITE)[0]
    site.mu, site.mu_static, site.stribeck_velocity, site.f_n = mu, static, stribeck_velocity, normal
    ends = np.linspace(-0.2, 0.2, 4000)
    slips = 0.5 * (ends[1:] + ends[:-1])
    slopes = np.diff([compliant_friction(site, normal, slip) for slip in ends]) / np.diff(ends)
    bounds = np.array([compliant_friction_damping(site, slip) for slip in slips])
    flat = 0.01 * static * normal / SLIP_SCALE
    assert np.all(np.abs(slopes) <= bounds + flat)
    assert bounds.max() <= 1.2 * np.abs(slopes).max()
    far = np.abs(slips) > 3 * SLIP_SCALE
    assert bounds[far].max() <= (1.3 * np.abs(slopes[far]).max() if stribeck_velocity else 0.0)
