"""Co-simulations of the thesis's rig started in a steady rub: they stay, or leave at the rate of the eigenvalue."""

import numpy as np
import pytest
from growing_vibration import growth_of

import amb_cosim
from amb_analysis.steady_contact.rubbing_rotor import rubbing_rotor
from amb_analysis.steady_contact.started import checkpoint_in
from amb_analysis.steady_contact.trap_map import states_at
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario

RECORD = {"every": 1, "variables": ["rotor_contact.rb?.f_n_mean"]}
SPEED = 2.0 * np.pi * 16.0


def case(Omega, u, mu, cycles):
    """Return scenario, settings and rotor with an unbalance on D1 (kg m) and friction of both retainers."""
    changes = {"Omega": Omega, "event": (), "unbalance_factor": 1.0, "record": RECORD, "end_cycle": cycles}
    scenario = as_scenario("fig5_6_pid", None).changed(**changes)
    settings = {"rotor_contact.d1.u": u, "rotor_contact.rb?.mu": mu, "rotor_contact.rb?.mu_static": mu}
    return scenario, settings, rubbing_rotor(prepare_run(scenario, settings))


def state_of(rotor, contact, growing):
    """Return the state of some sites with a growth rate nearest to one (1/s)."""
    of_these = [state for state in states_at(rotor, rotor.Omega) if state.contact == contact]
    return min(of_these, key=lambda state: abs(state.small.growth - growing))


def run_from(case, state):
    scenario, settings, rotor = case
    run = amb_cosim.run(scenario, set=settings, start=checkpoint_in(rotor, state), progress=False)
    assert run.outcome.status == "completed"
    data = run.dataset
    return np.array([data[f"rotor_contact.{site}.f_n_mean"].values[1:] for site in rotor.sites])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("Omega", "u", "mu", "contact"),
    [
        (140.0, 0.005, 0.0, ()),
        (140.0, 0.040, 0.0, ("rb1",)),
        (SPEED, 0.03125, 0.0, ("rb1", "rb2")),
        (SPEED, 0.03125, 0.01, ("rb1", "rb2")),
    ],
)
def test_run_started_in_a_stable_state_stays_in_it(Omega, u, mu, contact):
    """Forces to 2e-3 at all times, from the first step on."""
    of_case = case(Omega, u, mu, 20)
    state = state_of(of_case[2], contact, -1.0)
    assert state.small.is_stable
    for N, site in zip(run_from(of_case, state), ("rb1", "rb2"), strict=True):
        force = state.N.get(site, 0.0)
        assert np.abs(N - force).max() <= 2e-3 * force


@pytest.mark.slow
@pytest.mark.parametrize(
    ("Omega", "u", "mu", "contact", "growth", "cycles"),
    [
        (140.0, 0.005, 0.0, ("rb1",), 6.530, 25),
        (140.0, 0.005, 0.0, ("rb1", "rb2"), 23.25, 10),
        (140.0, 0.040, 0.0, ("rb1", "rb2"), 13.10, 10),
        (170.0, 0.030, 0.0, ("rb1",), 1.094, 120),
        (120.0, 0.020, 0.1, ("rb1", "rb2"), 4.574, 15),
    ],
)
def test_run_started_in_an_unstable_state_leaves_at_its_eigenvalue(Omega, u, mu, contact, growth, cycles):
    """N is there to 1e-3 first; then it grows away, straight or whirling, at the rate of the linear dynamics."""
    of_case = case(Omega, u, mu, cycles)
    state = state_of(of_case[2], contact, growth)
    assert state.small.growth == pytest.approx(growth, rel=1e-3)
    frequency = abs(state.small.frequency - Omega)
    N = run_from(of_case, state)[len(contact) - 1]
    away = N / state.N[contact[-1]] - 1.0
    assert abs(away[0]) < 1e-3
    first, last = (int(np.argmax(np.abs(away) > size)) for size in (5.0 * np.abs(away[:100]).max(), 1e-2))
    result = growth_of(away[first : last or None], 2.5e-4, frequency)
    np.testing.assert_allclose(result, (growth, frequency), rtol=0.02, atol=1e-6)
