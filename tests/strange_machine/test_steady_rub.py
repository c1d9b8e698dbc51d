"""Steady rub of the expander: receptances against co-simulation, and states of four sites."""

from __future__ import annotations

import numpy as np
import pytest
from strange_machine import LEVITATION

import amb_cosim
from amb_cosim.rub.rubbing_rotor import rubbing_rotor
from amb_cosim.rub.synchronous_states import all_sets, states_of
from amb_cosim.scenario.scenario import given_scenario
from amb_cosim.scenario.simulation import prepare

STEADY = given_scenario(LEVITATION, None).changed(settle_cycles=300, event=(), end_cycle=3)
HEAVY = {"rotor_contact.turbine.u": "5 g.mm"}


@pytest.fixture(scope="module")
def expander():
    return rubbing_rotor(prepare(STEADY, HEAVY))


def test_receptances_of_the_loop_are_those_of_a_co_simulation(expander):
    """Amplitude and phase at all sites, to 4e-4; what is left is the magnets' square law."""
    run = amb_cosim.run(STEADY, set=HEAVY, progress=False).dataset
    period = 2.0 * np.pi / expander.Omega
    turns = (run["time"].values >= period - 1e-9) & (run["time"].values < 3.0 * period - 1e-9)
    theta = run["rotor_contact.theta"].values[turns]
    P = expander.receptances(expander.Omega).P
    for k, site in enumerate(expander.sites):
        z = run[f"rotor_contact.{site}.x"].values[turns] + 1j * run[f"rotor_contact.{site}.y"].values[turns]
        orbit = (z * np.exp(-1j * theta)).mean()
        assert abs(orbit / (P[k] @ expander.unbalance * expander.Omega**2) - 1.0) < 1e-3


def test_every_set_of_the_four_sites_is_solved_in_equilibrium(expander):
    """Sixteen sets at six unbalances, beyond the gaps of all; forces and motions obey the receptances."""
    Omega = expander.Omega
    R, mu = expander.receptances(Omega), expander.mu(Omega)
    np.testing.assert_allclose(mu, 0.08)
    r = np.outer(np.linspace(10.0, 60.0, 6), R.P @ expander.unbalance * Omega**2)
    sizes = set()
    for contact in all_sets(4):
        found = states_of(contact, R.R, mu, expander.c, r)
        motion = r[found.points] + found.force @ R.R.T
        np.testing.assert_allclose(found.q, motion, atol=1e-9)
        at = list(contact)
        np.testing.assert_allclose(
            np.abs(found.q[:, at]), np.broadcast_to(expander.c[at], (len(found.points), len(at)))
        )
        sizes |= {len(contact)} if len(found.points) else set()
    assert {0, 1} < sizes
