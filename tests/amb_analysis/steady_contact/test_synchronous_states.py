"""States of steady rub: equilibrium, and completeness."""

from dataclasses import replace

import numpy as np
import pytest
from jeffcott import CLEARANCE, DAMPING, MASS, OWN, STIFFNESS, dynamic_stiffness, jeffcott

from amb_analysis.steady_contact import forward_loop, synchronous_states
from amb_analysis.steady_contact.forward_loop import ComplexLaw
from amb_analysis.steady_contact.homotopy import solve_by_paths
from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.synchronous_states import all_sets, states_of, states_of_all


def some_rotor(n_sites, points, seed=0, size=3.0):
    """Return random receptances (passive or not), clearances of one, and orbits without contact."""
    random = np.random.default_rng(seed)
    R = random.normal(size=(points, n_sites, n_sites)) + 1j * random.normal(size=(points, n_sites, n_sites))
    r = size * (random.normal(size=(points, n_sites)) + 1j * random.normal(size=(points, n_sites)))
    return R, np.ones(n_sites), r


def residual(found, R, mu, c, r):
    """Return the largest error of q = r + R F and |q| = c in contact, with F = -N (1 + i mu) q/|q|."""
    at, points = list(found.contact), found.points
    F = np.zeros((len(points), R.shape[1]), dtype=complex)
    F[:, at] = -found.N * (1.0 + 1j * mu[at]) * found.q[:, at] / np.abs(found.q[:, at])
    motion = r[points] + np.einsum("nij,nj->ni", R[points], F)
    return max(np.abs(motion - found.q).max(), np.abs(np.abs(found.q[:, at]) - c[at]).max())


@pytest.mark.parametrize("n_sites", [1, 2, 3])
def test_states_are_in_equilibrium_press_outward_and_keep_gaps(n_sites):
    R, c, r = some_rotor(n_sites, 40)
    mu = np.array([0.0, 0.3, 0.1])[:n_sites]
    count = 0
    for contact in all_sets(n_sites)[1:]:
        result = states_of(contact, R, mu, c, r)
        count += len(result.points)
        if len(result.points):
            assert residual(result, R, mu, c, r) < 1e-8
            assert (result.N > 0.0).all()
            others = [k for k in range(n_sites) if k not in contact]
            assert (np.abs(result.q[:, others]) < c[others]).all()
    assert count > 10


def test_sets_of_equally_many_sites_are_solved_together(monkeypatch):
    """All sets with one site, then all with two, with the states that each set has alone."""
    solved, solve = [], synchronous_states._solutions
    monkeypatch.setattr(synchronous_states, "_solutions", lambda rho, c, r: solved.append(len(r)) or solve(rho, c, r))
    R, _, r = some_rotor(4, 200, size=1.0)
    mu, c, sets = np.array([0.0, 0.3, 0.1, 0.2]), np.array([1.0, 1.2, 0.8, 1.1]), all_sets(4, 2)
    together = states_of_all(sets, R, mu, c, r)
    assert sorted(solved) == [4 * 200, 6 * 200]
    for contact, states in zip(sets, together, strict=True):
        alone = states_of(contact, R, mu, c, r)
        assert (states.contact, states.points.tolist()) == (contact, alone.points.tolist())
        for name in ("N", "psi", "q", "force"):
            np.testing.assert_allclose(getattr(states, name), getattr(alone, name), rtol=1e-9, atol=1e-12)
    assert sum(len(states.points) for states in together if len(states.contact) == 2) > 10


def test_a_loop_samples_its_plant_once_for_all_frequencies(monkeypatch):
    sampled, held = [], forward_loop.held
    monkeypatch.setattr(forward_loop, "held", lambda *given: sampled.append(given) or held(*given))
    free = jeffcott(OWN)
    plant = ComplexLaw(
        free.plant.A,
        np.hstack([free.plant.B, [[0.0], [100.0 / MASS]]]),
        np.vstack([free.plant.C, free.plant.C]),
        np.zeros((2, 3), dtype=complex),
    )
    control = ComplexLaw(
        *(np.zeros(shape, dtype=complex) for shape in ((0, 0), (0, 1), (1, 0))), np.array([[-500.0 + 0j]])
    )
    loop = replace(free, plant=plant, controller=control, sample_time=1e-5, late=np.zeros(1), currents=("coil",))
    for omega in (0.5 * OWN, OWN, 2.0 * OWN):
        expected = 1.0 / dynamic_stiffness(omega, stiffness=STIFFNESS + 5e4)
        np.testing.assert_allclose(receptances(loop, omega).R, expected, rtol=1e-2)
    assert len(sampled) == 1


def test_resultant_and_paths_find_the_same_pairs():
    """Six complex solutions, of which both methods give the same real ones."""
    R, c, r = some_rotor(2, 60, seed=1)
    E = np.linalg.inv(R)
    s = np.einsum("njk,nk->nj", E, r)
    ends = solve_by_paths(E * c, s)
    assert ends.shape == (60, 6, 2)
    on_circle = (np.abs(np.abs(ends) - 1.0) < 1e-7).all(axis=2)
    N = ends.conj() * (s[:, None] - np.einsum("njk,npk->npj", E * c, ends))
    pressing = on_circle & (N.real > 0.0).all(axis=2)
    result = states_of((0, 1), R, np.zeros(2), c, r)
    assert len(result.points) == pressing.sum() > 20
    for point in range(60):
        ours = np.sort(result.N[result.points == point].sum(axis=1))
        theirs = np.sort(N.real[point][pressing[point]].sum(axis=1))
        np.testing.assert_allclose(ours, theirs, rtol=1e-6)


def test_an_orbit_that_magnets_cancel_has_no_states_and_changes_no_other():
    """Without a free orbit |s| is rounding, and a state could turn to any phase; paths of other points go on.

    They agree within rounding: products of libraries sum in an order that depends on the processor.
    """
    R, c, r = some_rotor(3, 4)
    at_three = np.linalg.inv(R)
    s = np.einsum("njk,nk->nj", at_three, r)
    cancelled = s * np.where(np.arange(4) == 2, 1e-15, 1.0)[:, None]
    ends, alone = (solve_by_paths(at_three * c, of) for of in (cancelled, s))
    assert not (np.abs(np.abs(ends[2]) - 1.0) < 1e-6).all(axis=1).any()
    for point in (0, 1, 3):
        np.testing.assert_allclose(ends[point], alone[point], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(("n_sites", "seed"), [(2, 3), (3, 4)])
def test_newtons_method_from_many_starts_yields_no_further_state(n_sites, seed):
    """Newton's method from hundreds of starts yields only the states of the polynomial method."""
    from scipy.optimize import fsolve

    R, c, r = some_rotor(n_sites, 3, seed)
    contact, random = tuple(range(n_sites)), np.random.default_rng(seed)
    result = states_of(contact, R, np.zeros(n_sites), c, r)
    for point in range(3):
        ours = result.N[result.points == point]

        def errors(x, point=point):
            p = np.exp(1j * x[n_sites:])
            error = c * p + R[point] @ (x[:n_sites] * p) - r[point]
            return np.concatenate([error.real, error.imag])

        for _ in range(300):
            start = np.concatenate([5.0 * random.random(n_sites), 2.0 * np.pi * random.random(n_sites)])
            x, _, success, _ = fsolve(errors, start, full_output=True)
            if success == 1 and np.abs(errors(x)).max() < 1e-9 and (x[:n_sites] > 1e-9).all():
                assert np.abs(ours - x[:n_sites]).max(axis=1).min() < 1e-6


def test_sites_without_cross_receptance_rub_as_each_alone():
    R, c, r = some_rotor(2, 50, seed=2)
    R = R * np.eye(2)
    both = states_of((0, 1), R, np.zeros(2), c, r)
    alone = [states_of((0,), R[:, [k]][:, :, [k]], np.zeros(1), c[:1], r[:, [k]]) for k in (0, 1)]
    for point in range(50):
        expected = {
            (round(a, 6), round(b, 6))
            for a in alone[0].N[alone[0].points == point, 0]
            for b in alone[1].N[alone[1].points == point, 0]
        }
        assert {(round(a, 6), round(b, 6)) for a, b in both.N[both.points == point]} == expected


def test_two_sites_in_the_same_plane_have_no_isolated_states():
    R, _, r = some_rotor(1, 20, seed=5)
    result = states_of((0, 1), np.broadcast_to(R, (20, 2, 2)), np.zeros(2), np.array([1.0, 1.1]), np.hstack([r, r]))
    assert len(result.points) == 0


def test_friction_turns_the_journal_back_and_takes_torque_from_the_spin():
    """At a speed below the critical one: friction points against the spin, and the contact lags behind."""
    Omega = 0.5 * OWN
    result = receptances(jeffcott(Omega))
    r = result.P * 4.0 * CLEARANCE * MASS * (OWN / Omega) ** 2 * Omega**2 * 0.4
    plain, rough = (states_of((0,), result.R, np.array([mu]), np.array([CLEARANCE]), r) for mu in (0.0, 0.2))
    assert len(plain.points) == len(rough.points) == 1
    assert rough.psi[0, 0] < plain.psi[0, 0]
    along = rough.force[0, 0] * np.exp(-1j * rough.psi[0, 0])
    np.testing.assert_allclose(along, -rough.N[0, 0] * (1.0 + 0.2j), rtol=1e-12)


@pytest.mark.parametrize("mu", [0.0, 0.02])
def test_jeffcott_rotor_stays_in_contact_from_the_closed_form_speed(mu):
    """Above the critical speed the contact exists beside the free orbit from the speed where its two roots meet.

    With D = k - m Omega^2 + i Omega d, u Omega^2 = |c D + N (1 + i mu)|: the line of N misses the circle while
    c |Im(D (1 - i mu))| > u Omega^2 |1 + i mu|; without friction up to Omega = d c/u, at which the phase is 90 degrees.
    """
    jump = 1.67 * OWN
    u = DAMPING * CLEARANCE / jump
    a, b, e = u / CLEARANCE * np.hypot(1.0, mu) - mu * MASS, -DAMPING, mu * STIFFNESS
    closed = (-b + np.sqrt(b * b - 4.0 * a * e)) / (2.0 * a)
    assert closed == pytest.approx(jump) if mu == 0.0 else closed > 1.5 * jump
    result = []
    for Omega in (closed * (1.0 - 1e-5), closed * (1.0 + 1e-5)):
        assert u * Omega**2 < CLEARANCE * abs(dynamic_stiffness(Omega))  # it can turn without contact
        at = receptances(jeffcott(Omega))
        result.append(states_of((0,), at.R, np.array([mu]), np.array([CLEARANCE]), at.P * u * Omega**2))
    assert [len(states.points) for states in result] == [0, 2]
    if mu == 0.0:
        np.testing.assert_allclose(np.degrees(result[1].psi[:, 0]), -90.0, atol=0.5)


def test_jeffcott_rotor_jumps_up_where_its_orbit_fills_the_gap():
    u = 0.5 * MASS * CLEARANCE
    speeds = np.linspace(0.5, 0.99, 50) * OWN
    for Omega in speeds:
        result = receptances(jeffcott(Omega))
        contact = states_of((0,), result.R, np.zeros(1), np.array([CLEARANCE]), result.P * u * Omega**2)
        touches = u * Omega**2 > CLEARANCE * abs(dynamic_stiffness(Omega))
        assert len(contact.points) == int(touches)
