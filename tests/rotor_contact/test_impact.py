"""Impacts: bouncing in closed form, momentum, energy, simultaneous impacts."""

import itertools
import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotor_cases import BEARINGS, CLEARANCE, both, masters, place, plant, rigid_rotor, run, size_of, workspace

from rotor_contact.contact.impact import mark_touching, newton_impact, nodal_impact
from rotor_contact.contact.site import locate_journal, slip_velocity
from rotor_contact.shaft.structure import structure_of
from rotor_contact.variables.enumerations import FREE, NEWTON, NODAL, ROLLING, SLIDING

RING, G = 0.05, 9.81
rig = cache(plant)
N_SITES = 4


def blows(e, drop):
    """Times of the blows of a mass that falls from rest by `drop`, and its speed after each: g t = 2 v in a flight."""
    t, speed = math.sqrt(2 * drop / G), e * math.sqrt(2 * G * drop)
    while speed > 1e-12:
        yield t, speed
        t, speed = t + 2 * speed / G, e * speed


def bounce_height(t, e, drop):
    """Height above the bottom of that mass."""
    before = [blow for blow in blows(e, drop) if blow[0] <= t]
    if not before:
        return drop - 0.5 * G * t**2
    begin, speed = before[-1]
    return speed * (t - begin) - 0.5 * G * (t - begin) ** 2


def dropped(e):
    return plant(both("rb.clearance", RING) | both("rb.restitution", e) | {"base.a_y": G}, rigid_rotor(20.0))


def test_bouncing_rotor_follows_the_closed_form_flight_by_flight():
    e, h = 0.9, 1e-3
    x = dropped(e)
    steps = 1000  # 15 flights and more
    record = run(x, steps, ["mb1.y", "mb2.y", "rb1.impulse", "rb2.impulse"], h=h)
    expected = [bounce_height((n + 1) * h, e, RING) - RING for n in range(steps)]
    np.testing.assert_allclose(record[:, 0], expected, atol=1e-8)
    np.testing.assert_allclose(record[:, 1], expected, atol=1e-8)
    impulses = record[record[:, 2] > 0, 2]
    v1 = math.sqrt(2 * G * RING)
    np.testing.assert_allclose(impulses, 10.0 * (1 + e) * v1 * e ** np.arange(len(impulses)), rtol=1e-7)
    assert len(impulses) >= 5
    np.testing.assert_allclose(record[:, 3], record[:, 2], rtol=1e-7)


def test_impact_times_match_the_published_bouncing_ball():
    """h0 = 1 m, e = 0.9."""
    times = [t for t, _ in itertools.islice(blows(0.9, 1.0), 3)]
    np.testing.assert_allclose(times, [0.451523641, 1.264266195, 1.995734493], atol=1e-9)


@pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
def test_bouncing_accumulates_and_ends_at_rest_on_the_ring(e):
    x = dropped(e)
    end = math.sqrt(2 * RING / G) * (1 + 2 * e / (1 - e))
    run(x, math.ceil(1.02 * end / 1e-3), h=1e-3)
    assert (x["rb1.mode"], x["rb2.mode"], x["contact_state"]) == (1, 1, 3)
    assert x["mb1.y"] == pytest.approx(-RING, abs=1e-12)
    assert np.max(np.abs(masters(x)[1])) < 1e-12
    assert x["rb1.f_n"] == pytest.approx(10.0 * G, rel=1e-6)
    assert x["energy.dissipated"] == pytest.approx(20.0 * G * RING, rel=1e-4 if e else 1e-7)


@pytest.mark.parametrize("max_substep", [5e-4, 5e-5, 1e-5, 1e-6])
@pytest.mark.parametrize("e", [0.2, 0.5, 0.8])
def test_bounces_of_one_end_that_die_out_leave_the_other_its_rebound(e, max_substep):
    """Each end is a mass of its own, and all happens in one step; the first end has lifted by less than 1 um."""
    x = plant(both("rb.restitution", e) | {"base.a_y": G, "solver.max_substep": max_substep}, rigid_rotor(20.0))
    near, far = 5e-9, 5e-6
    place(x, -1j * (CLEARANCE - np.array([near, far])), np.zeros(2))
    x.step(0.0, 1.5e-3)
    assert x["mb1.y"] == pytest.approx(-CLEARANCE, abs=1e-12)
    assert x["mb2.y"] + CLEARANCE == pytest.approx(bounce_height(1.5e-3, e, far), abs=1e-11)
    speed = math.sqrt(2 * G * near)
    assert x["rb1.impulse"] == pytest.approx(10.0 * speed * (1 + e) / (1 - e), rel=1e-2)


# One impact of the rig, on the kernel itself.

angles = st.floats(0.0, 2 * math.pi)


def touching(seed, angle_1, angle_2, mu=0.0, e=0.0, Omega=0.0, sites=(0, 1), static=0.0):
    """The rig with the given journals on their rings, and random velocities that bring these outward."""
    rng = np.random.default_rng(seed)
    n = size_of(rig())
    rows = structure_of(rig().constants).sites
    rig().initialise()
    for k in (1, 2):
        rig()[f"rb{k}.mu"], rig()[f"rb{k}.mu_static"], rig()[f"rb{k}.restitution"] = mu, static, e
    q, v = 1e-4 * rng.normal(size=n), rng.normal(size=n)
    for k, angle in enumerate((angle_1, angle_2)):
        if k in sites:
            i = int(rows[k])
            normal = np.array([math.cos(angle), math.sin(angle)])
            q[i : i + 2] = CLEARANCE * normal * (1 + 1e-11)
            v[i : i + 2] += (abs(normal @ v[i : i + 2]) + 0.01 - normal @ v[i : i + 2]) * normal
    w = workspace(rig())
    assert mark_touching(w.sites, q, v, 1.0)
    assert [bool(site.touching) for site in w.sites] == [k in sites for k in range(N_SITES)]
    return w, w.sites, q, v


def mass(w):
    """The mass matrix of the shaft."""
    return w.forms[: len(w.Minv)]


def directions(contact):
    """Rows n_k and t_k that take a velocity to its radial and forward components."""
    N, T = np.zeros((2, N_SITES, size_of(rig())))
    for k, site in enumerate(contact[:2]):
        rows = slice(site.row, site.row + 2)
        N[k, rows], T[k, rows] = (site.n_x, site.n_y), (-site.n_y, site.n_x)
    return N, T


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), angles, angles, st.sampled_from([(0,), (1,), (0, 1)]))
def test_elastic_impact_conserves_energy_and_momentum_plus_impulse(seed, a, b, sites):
    w, contact, _, v = touching(seed, a, b, e=1.0, sites=sites)
    before = v.copy()
    assert newton_impact(w, v, 100.0)
    N, _ = directions(contact)
    np.testing.assert_allclose(mass(w) @ (v - before), -N.T @ contact["p_n"], atol=1e-9)
    assert v @ mass(w) @ v == pytest.approx(before @ mass(w) @ before, rel=1e-10)
    for k in sites:
        rebound = -N[k] @ before
        if contact[k].p_n > 0.0:
            assert N[k] @ v == pytest.approx(rebound, rel=1e-9)
        else:  # the blow at the other site threw it off faster still
            assert N[k] @ v <= rebound + 1e-12
        assert contact[k].impulse == contact[k].p_n
    assert np.any(contact["p_n"] > 0.0)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), angles, st.floats(0.0, 1.0), st.sampled_from([0, 1]))
def test_impact_loses_one_minus_e_squared_of_the_energy_of_approach(seed, angle, e, k):
    w, contact, _, v = touching(seed, angle, angle, e=e, sites=(k,))
    before = v.copy()
    assert newton_impact(w, v, 0.0)
    N, _ = directions(contact)
    effective_mass = 1.0 / (N[k] @ w.Minv @ N[k])
    lost = 0.5 * (before @ mass(w) @ before - v @ mass(w) @ v)
    assert lost == pytest.approx(0.5 * effective_mass * (1 - e**2) * (N[k] @ before) ** 2, rel=1e-7, abs=1e-9)
    assert contact["impact_heat"].sum() == pytest.approx(lost, rel=1e-7, abs=1e-9)


@settings(max_examples=100)
@given(
    st.integers(0, 2**32 - 1), angles, angles, st.floats(0.0, 5.0), st.floats(0.0, 1.0), st.floats(-600.0, 600.0),
    st.sampled_from([(0,), (1,), (0, 1)]),
)  # fmt: skip
def test_impact_with_friction_creates_no_energy_pull_or_driven_slip(seed, a, b, mu, e, Omega, sites):
    w, contact, _, v = touching(seed, a, b, mu, e, Omega, sites)
    before = v.copy()
    assert newton_impact(w, v, Omega)
    N, T = directions(contact)
    np.testing.assert_allclose(mass(w) @ (v - before), -N.T @ contact["p_n"] + T.T @ contact["p_t"], atol=1e-9)
    assert np.all(contact["p_n"] >= 0.0)
    assert np.all(np.abs(contact["p_t"]) <= mu * contact["p_n"] * (1 + 1e-9) + 1e-300)
    spin_work = -sum(contact[k].p_t * Omega * 0.025 for k in range(2))
    heat = 0.5 * (before @ mass(w) @ before - v @ mass(w) @ v) + spin_work
    assert heat >= -1e-9
    assert contact["impact_heat"].sum() == pytest.approx(heat, rel=1e-7, abs=1e-8)
    for k in sites:
        assert N[k] @ v <= 1e-9  # leaves or stays
        assert contact[k].p_t * slip_velocity(contact[k], v, Omega) <= 1e-9
        if len(sites) == 1:
            slip_before, slip = (slip_velocity(contact[k], u, Omega) for u in (before, v))
            assert slip * slip_before >= -1e-9
            assert abs(slip) <= abs(slip_before) + 1e-12


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), angles, st.floats(0.05, 2.0), st.floats(-600.0, 600.0), st.sampled_from([0, 1]))
def test_friction_impulse_ends_the_slip_or_is_mu_times_the_normal_one(seed, angle, mu, Omega, k):
    w, contact, _, v = touching(seed, angle, angle, mu, 0.0, Omega, (k,))
    assert newton_impact(w, v, Omega)
    slip = slip_velocity(contact[k], v, Omega)
    if abs(slip) > 1e-9:
        assert contact[k].p_t == pytest.approx(-mu * contact[k].p_n * math.copysign(1.0, slip), rel=1e-9)


@pytest.mark.parametrize("Omega", [-40.0, 40.0])
@pytest.mark.parametrize("stribeck_velocity", [0.0, 1.5])
def test_an_impact_slides_if_kinetic_friction_cannot_end_the_slip(Omega, stribeck_velocity):
    """Static friction, ten times as large, holds no journal that slides: v+ = v + M^-1 (-n - mu s t) p, n . v+ = 0.

    The coefficient is that of the slip velocity before the impact.
    """
    kinetic, slid = 0.05, 0
    for seed in range(20):
        w, contact, _, v = touching(seed, 0.3 * seed, 0.3 * seed, kinetic, 0.0, Omega, (0,), 10.0 * kinetic)
        contact["stribeck_velocity"] = stribeck_velocity
        N, T = directions(contact)
        before = slip_velocity(contact[0], v, Omega)
        sign, mu = math.copysign(1.0, before), kinetic
        if stribeck_velocity > 0.0:
            mu += 9.0 * kinetic * math.exp(-((before / stribeck_velocity) ** 2))
        response = w.Minv @ (-N[0] - mu * sign * T[0])
        blow = -(N[0] @ v) / (N[0] @ response)
        slides = blow > 0.0 and sign * slip_velocity(contact[0], v + response * blow, Omega) > 0.0
        assert newton_impact(w, v, Omega)
        if slides:
            assert contact[0].p_n == pytest.approx(blow, rel=1e-9)
            assert contact[0].p_t == pytest.approx(-mu * sign * blow, rel=1e-9)
            slid += 1
    assert slid >= 5


def test_rolling_journal_obeys_coulombs_law_in_an_impact_elsewhere():
    """It keeps rolling if static friction suffices, and slides or separates otherwise."""
    mu, static, Omega = 0.1, 0.3, 50.0
    outcomes = set()
    for seed in range(60):
        angle, rolling_angle = np.random.default_rng(seed).uniform(0.0, 2 * math.pi, 2)
        w, contact, q, v = touching(seed, angle, rolling_angle, mu, 0.0, Omega, (0,), static)
        rolls = contact[1]
        normal = np.array([math.cos(rolling_angle), math.sin(rolling_angle)])
        q[rolls.row : rolls.row + 2] = CLEARANCE * normal
        v[rolls.row : rolls.row + 2] = -Omega * rolls.journal_radius * np.array([-normal[1], normal[0]])
        rolls.mode = ROLLING
        locate_journal(rolls, q)
        assert newton_impact(w, v, Omega)
        slip = slip_velocity(rolls, v, Omega)
        if rolls.mode == ROLLING:
            assert abs(slip) < 1e-9
            assert abs(rolls.p_t) <= static * rolls.p_n * (1 + 1e-9)
        else:
            assert rolls.p_t == pytest.approx(-mu * rolls.p_n * math.copysign(1.0, slip), rel=1e-9)
        outcomes.add((int(rolls.mode), bool(abs(rolls.p_t) > mu * rolls.p_n * (1 + 1e-9))))
    assert outcomes == {(FREE, False), (SLIDING, False), (ROLLING, False), (ROLLING, True)}


@pytest.mark.parametrize("seed", [7, 26, 180, 237])
def test_no_journal_enters_its_ring_in_an_impact_elsewhere(seed):
    """The blow throws a sliding journal off its ring; friction at the other site then drives it back."""
    Omega, angle, sliding_angle = np.random.default_rng(seed).uniform([-300.0, 0.0, 0.0], [300.0, 6.28318, 6.28318])
    w, contact, q, v = touching(seed, angle, sliding_angle, 2.0, 0.5, Omega, (0,))
    slides = contact[1]
    rows, normal = slice(slides.row, slides.row + 2), np.array([math.cos(sliding_angle), math.sin(sliding_angle)])
    q[rows] = CLEARANCE * normal
    v[rows] -= (normal @ v[rows]) * normal
    locate_journal(slides, q)
    slides.mode, slides.slip_sign = SLIDING, math.copysign(1.0, slip_velocity(slides, v, Omega))
    assert newton_impact(w, v, Omega)
    assert np.all(directions(contact)[0] @ v <= 1e-9)


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), angles, angles, st.sampled_from([(0,), (1,), (0, 1)]))
def test_nodal_law_stops_only_the_radial_motion_of_touching_nodes(seed, a, b, sites):
    w, contact, _, v = touching(seed, a, b, mu=0.5, e=0.7, sites=sites)
    before = v.copy()
    nodal_impact(w, v, 100.0)
    N, _ = directions(contact)
    expected = before - sum(N[k] * (N[k] @ before) for k in sites)
    np.testing.assert_allclose(v, expected, atol=1e-14)
    assert [contact[k].mode for k in range(2)] == [1 if k in sites else 0 for k in range(2)]
    assert contact["impact_heat"].sum() == pytest.approx(
        0.5 * (before @ mass(w) @ before - v @ mass(w) @ v), rel=1e-9, abs=1e-12
    )


def test_impact_at_one_site_loads_or_releases_the_other_but_never_pulls():
    for side in (1.0, -1.0):
        w, contact, q, v = touching(0, 0.0, 0.0, sites=(0,))
        i, j = contact[0].row, contact[1].row
        v[:] = 0.0
        v[i] = 1.0
        q[j : j + 2] = (side * CLEARANCE, 0.0)
        contact[1].mode = 1
        locate_journal(contact[1], q)
        assert newton_impact(w, v, 0.0)
        alone = -side * w.Minv[j, i] / w.Minv[i, i]  # outward velocity the blow alone would give MB2
        released = alone < 0.0
        assert (contact[1].mode == 0) == released
        assert (contact[1].p_n > 0.0) == (not released)


def test_a_run_uses_the_chosen_impact_law():
    """First impact of the rig from a given flight: newton moves the neighbours' velocities, nodal does not."""
    jumps = {}
    for law in (NEWTON, NODAL):
        x = plant(BEARINGS | {"contact.impact_law": law, "solver.max_substep": 1e-6})
        r = np.zeros(6, dtype=complex)
        r[2] = 0.999999 * CLEARANCE
        place(x, r, np.array([0, 0, 0.1, 0, 0, 0]))
        x.step(0.0, 2e-8)
        jumps[law] = np.abs(masters(x)[1][[0, 1, 3]])
        assert x["rb1.impulse"] > 0.0
    assert np.max(jumps[NODAL]) < 1e-3 * np.max(jumps[NEWTON])
