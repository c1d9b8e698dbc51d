"""Small motion about states of steady rub, against closed forms of a Jeffcott rotor."""

import numpy as np
import pytest
from jeffcott import CLEARANCE, DAMPING, MASS, OWN, STIFFNESS, jeffcott

from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.rubbing_rotor import rubbing_rotor
from amb_analysis.steady_contact.stability import Dynamics, slowest_decay
from amb_analysis.steady_contact.synchronous_states import states_of
from amb_analysis.steady_contact.trap_map import Regime, trap_map
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario

C = np.array([CLEARANCE])


def small_motion(Omega, N, mu, slope=0.0):
    return Dynamics(jeffcott(Omega), C, np.array([mu]), np.array([slope])).about((0,), np.array([N]), np.zeros(1))


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("N", [0.0, 5.0, 40.0])
def test_journal_swings_on_its_circle_with_the_closed_forms_rates(mu, N):
    """On the circle only b is free; the Coriolis force presses, and friction is proportional to that:

    m b'' + (d + 2 mu m Omega) b' + (k - m Omega^2 + mu d Omega + (1 + mu^2) N/c) b = 0.
    """
    Omega = 1.5 * OWN
    spring = STIFFNESS - MASS * Omega**2 + mu * DAMPING * Omega + (1.0 + mu**2) * N / CLEARANCE
    expected = np.roots([MASS, DAMPING + 2.0 * mu * MASS * Omega, spring])
    small = small_motion(Omega, N, mu)
    np.testing.assert_allclose(small.growth, expected.real.max(), rtol=1e-8)
    assert small.is_stable == (spring > 0.0)
    if expected[0].imag:
        assert min(abs(abs(small.frequency - Omega) - abs(root.imag)) for root in expected) < 1e-6 * Omega


@pytest.mark.parametrize("slope", [-0.05, 0.02])
def test_friction_that_falls_with_slip_drives_the_swing_on_the_circle(slope):
    """The slip grows by b', the friction mu N by mu' N b' against it:

    m b'' + (d + 2 mu m Omega + mu' N) b' + (k - m Omega^2 + mu d Omega + (1 + mu^2) N/c) b = 0.
    """
    Omega, N, mu = 1.5 * OWN, 8000.0, 0.3
    spring = STIFFNESS - MASS * Omega**2 + mu * DAMPING * Omega + (1.0 + mu**2) * N / CLEARANCE
    damping = DAMPING + 2.0 * mu * MASS * Omega + slope * N
    small = small_motion(Omega, N, mu, slope)
    assert small.growth == pytest.approx(np.roots([MASS, damping, spring]).real.max(), rel=1e-8)
    assert small.is_stable == (damping > 0.0)


@pytest.mark.parametrize("contact", [(), (0,)], ids=["free", "in contact"])
@pytest.mark.parametrize("scenario", [None, "compressor_levitated"], ids=["continuous", "sampled"])
def test_growth_is_that_of_the_full_eigenproblem(scenario, contact):
    """Eigenvalues without their vectors, as the maps take them."""
    dynamics = Dynamics(jeffcott(1.5 * OWN), C, np.array([0.3]), np.array([0.02]))
    if scenario is not None:
        rotor = rubbing_rotor(prepare_run(as_scenario(scenario, None)))
        friction = rotor.mu(rotor.Omega), rotor.mu_slope(rotor.Omega)
        dynamics = Dynamics(rotor.loop(rotor.Omega), rotor.c, *friction)
    state = (contact, np.full(len(contact), 30.0), np.full(len(contact), 0.4))
    assert dynamics.growth(*state) == pytest.approx(dynamics.about(*state).growth, rel=1e-8)


def test_regimes_are_those_of_the_growth_rates_of_all_states():
    """Over free rotation, rub beside it, and rub alone, about saddles, too."""
    rotor = rubbing_rotor(prepare_run(as_scenario("compressor_levitated", None)))
    speeds, factors = rotor.Omega * np.array([0.9, 1.0, 1.1]), np.array([3.0, 10.0, 20.0, 30.0, 50.0])
    found = trap_map(rotor, speeds, factors)
    free, trapped, settled = (np.zeros((3, 5), dtype=bool) for _ in range(3))
    for states in found.states:
        (trapped if states.contact else free)[states.speed[states.stable], states.amount[states.stable]] = True
        settles = states.growth < slowest_decay(speeds[states.speed])
        if states.contact:
            settled[states.speed[settles], states.amount[settles]] = True
    both = np.where(trapped, Regime.BOTH, Regime.FREE)
    expected = np.where(free, both, np.where(settled, Regime.CONTACT, Regime.WHIRL))
    assert {*expected.ravel().tolist()} == {*Regime}
    assert np.array_equal(found.regimes(), expected)
    in_trap = np.isin(expected, (Regime.BOTH, Regime.CONTACT))
    first = np.where(in_trap.any(axis=1), factors[in_trap.argmax(axis=1)], np.nan)
    np.testing.assert_array_equal(found.least_trapping(), first)


@pytest.mark.parametrize("mu", [0.0, 0.1])
def test_the_sign_of_a_determinant_recognises_a_saddle_without_eigenvalues(mu, monkeypatch):
    Omega, u = 1.5 * OWN, 3.0 * DAMPING * CLEARANCE / OWN
    at = receptances(jeffcott(Omega))
    found = states_of((0,), at.R, np.array([mu]), C, at.P * u * Omega**2)
    saddle, stable = np.argsort(found.N[:, 0])
    dynamics = Dynamics(jeffcott(Omega), C, np.array([mu]), np.zeros(1))
    assert dynamics.grows_below(0.0, (0,), found.N[stable], found.psi[stable])
    assert not dynamics.grows_below(-1e9, (0,), found.N[stable], found.psi[stable])
    monkeypatch.setattr(Dynamics, "_growth", lambda *_: pytest.fail("eigenvalues of a saddle"))
    assert not dynamics.grows_below(0.0, (0,), found.N[saddle], found.psi[saddle])


@pytest.mark.parametrize("mu", [0.0, 0.1])
def test_of_two_contact_states_the_one_with_more_force_is_stable(mu):
    """They meet in a fold, where the swing on the circle has no stiffness."""
    Omega, u = 1.5 * OWN, 3.0 * DAMPING * CLEARANCE / OWN
    at = receptances(jeffcott(Omega))
    result = states_of((0,), at.R, np.array([mu]), C, at.P * u * Omega**2)
    assert len(result.points) == 2
    assert abs(at.P[0, 0] * u * Omega**2) < CLEARANCE
    assert [small_motion(Omega, N, mu).is_stable for N in np.sort(result.N[:, 0])] == [False, True]


def test_free_rotor_has_its_own_eigenvalues():
    small = Dynamics(jeffcott(0.7 * OWN), C, np.zeros(1), np.zeros(1)).about((), np.zeros(0), np.zeros(0))
    damped = np.sqrt(STIFFNESS / MASS - (DAMPING / (2.0 * MASS)) ** 2)
    np.testing.assert_allclose(small.rates, -DAMPING / (2.0 * MASS), rtol=1e-9)
    np.testing.assert_allclose(np.sort(small.frequencies), [-damped, damped], rtol=1e-9)
