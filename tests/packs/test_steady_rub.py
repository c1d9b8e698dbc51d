"""Steady rub of the thesis's rig: states by the continuous loop, and forces of the sampled one in co-simulation."""

from dataclasses import replace

import numpy as np
import pytest

import amb_cosim
from amb_analysis.linear.components import frequency_response
from amb_analysis.linear.linear_source import source_of_run
from amb_analysis.steady_contact.contact_whirl import contact_forces, contact_whirls
from amb_analysis.steady_contact.forward_loop import contact_pair, flat, parts_in_contact
from amb_analysis.steady_contact.freeing import smallest_demand, smallest_freeing
from amb_analysis.steady_contact.receptances import receptances
from amb_analysis.steady_contact.rolling import rolling
from amb_analysis.steady_contact.rubbing_rotor import rubbing_rotor
from amb_analysis.steady_contact.stability import Dynamics
from amb_analysis.steady_contact.synchronous_states import all_sets, states_of
from amb_analysis.steady_contact.trap_map import Regime, states_at, trap_map
from amb_analysis.steady_contact.whirl import whirls
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario

SPRINGS = {"rotor_contact.*.k_b": 1e6, "rotor_contact.*.c_b": 5000.0}  # N/m, N s/m
SPEED = 2.0 * np.pi * 16.0
CASES = (  # rad/s, kg m on D1, mu; forces (N) of all states at RB1 and RB2, 0 where there is no contact
    (SPEED, 0.03125, 0.0, [(1481.0, 785.3)]),
    (SPEED, 0.03125, 0.1, [(1339.1, 703.2)]),
    (140.0, 0.005, 0.0, [(0.0, 0.0), (2044.1, 0.0), (3415.7, 0.0)]),
    (140.0, 0.040, 0.0, [(9768.5, 0.0), (10028.0, 1506.0), (9054.3, 3148.8)]),
    (160.0, 0.015, 0.1, [(0.0, 0.0), (6114.4, 4336.4), (6587.8, 7902.9)]),
    (120.0, 0.020, 0.1, [(873.5, 0.0), (2089.4, 1364.5), (819.6, 36.3), (316.9, 193.2), (1002.8, 1093.5)]),
)


@pytest.fixture(scope="module")
def rig():
    return rubbing_rotor(prepare_run(as_scenario("fig5_6_pid", None).changed(unbalance_factor=1.25)))


@pytest.fixture(scope="module")
def springs():
    return source_of_run(prepare_run(as_scenario("fig5_6_pid", None), SPRINGS))


def receptance_on_springs(springs, Omega, sites):
    """Forward receptance (m/N) of the sites to contact forces and to a force on D1, without the controller."""
    (rotor,), _ = parts_in_contact(springs.at(Omega), ["rotor_contact"])
    forces = [*(contact_pair(site) for site in sites), ("rotor_contact.d1.f_x", "rotor_contact.d1.f_y")]
    displacements = [f"rotor_contact.{site}.{axis}" for site in sites for axis in "xy"]
    H = frequency_response(rotor.selected(flat(forces), displacements).law, 1j * Omega)
    return 0.5 * (H[0::2, 0::2] + H[1::2, 1::2] + 1j * (H[1::2, 0::2] - H[0::2, 1::2]))


@pytest.mark.parametrize(("Omega", "u", "mu", "expected"), CASES)
def test_every_state_of_the_continuous_loop_is_found(rig, springs, Omega, u, mu, expected):
    """Found before from starts on a grid of phases and forces, with K_b = 1e6 N/m and C_b = 5000 N s/m."""
    R, P = np.split(receptance_on_springs(springs, Omega, rig.sites), [2], axis=1)
    r = P.T * u * Omega**2
    result = []
    for contact in all_sets(2):
        for N in states_of(contact, R, np.full(2, mu), rig.c, r).N:
            forces = np.zeros(2)
            forces[list(contact)] = N
            result.append(tuple(forces))
    np.testing.assert_allclose(sorted(result), sorted(expected), atol=0.06)


def test_trapped_rotor_rubs_with_the_forces_of_its_single_state(rig):
    """16 Hz, 31.25 g m on D1: no free orbit, one state in contact at both; the run of 8 s has its mean forces to 0.1 %.

    Its vibration decays as the small motion about the state does.
    """
    at = rig.receptances(rig.Omega)
    r = (at.P @ rig.unbalance * rig.Omega**2)[None]
    states_in = {contact: states_of(contact, at.R, np.zeros(2), rig.c, r) for contact in all_sets(2)}
    assert {contact: len(states.points) for contact, states in states_in.items()} == {
        (): 0,
        (0,): 0,
        (1,): 0,
        (0, 1): 1,
    }
    state = states_in[0, 1]
    none = np.zeros(2)
    small = Dynamics(rig.loop(rig.Omega), rig.c, none, none).about((0, 1), state.N[0], state.psi[0])
    assert small.is_stable
    scenario = as_scenario("fig5_6_pid", None).changed(unbalance_factor=1.25)
    run = amb_cosim.run(scenario, until=8.0, progress=False).dataset
    time = run["time"].values
    for k, site in enumerate(rig.sites):
        force = run[f"rotor_contact.{site}.f_n_mean"].values
        np.testing.assert_allclose(force[time > 7.0].mean(), state.N[0, k], rtol=1e-3)
    force = run["rotor_contact.rb1.f_n_mean"].values
    spans = [np.ptp(force[(time > end - 0.5) & (time <= end)]) for end in (4.0, 8.0)]
    np.testing.assert_allclose(np.log(spans[1] / spans[0]) / 4.0, small.growth, rtol=0.05)


def on_d1(rig, u):
    return replace(rig, unbalance=np.array([u, *np.zeros(5)], dtype=complex))


def test_smallest_freeing_currents_just_remove_all_contact_states(rig):
    freeing = smallest_freeing(rig, rig.Omega)
    currents = np.array(list(freeing.injected.values()))
    assert freeing.largest == pytest.approx(0.427, abs=0.002)
    sizes = list(map(abs, currents))
    assert sizes == pytest.approx([freeing.largest] * 2, rel=0.01)  # either bearing gives its share
    assert [state.contact for state in states_at(rig, rig.Omega, currents)] == [()]
    assert any(state.contact for state in states_at(rig, rig.Omega, 0.9 * currents))


def test_smallest_demand_is_below_that_of_the_smallest_injection(rig):
    """The feedback demands less current if the injected currents are not the smallest."""
    least = smallest_demand(rig, rig.Omega, np.array([4.43, 4.43]))
    added = np.array(list(least.injected.values()))
    assert [state.contact for state in states_at(rig, rig.Omega, added)] == [()]
    whole = smallest_freeing(rig, rig.Omega)
    assert max(map(abs, least.demanded.values())) < max(map(abs, whole.demanded.values()))


def test_opposite_currents_of_the_same_size_free_nothing(rig):
    """The sign of a control force counts: turned by half a turn it presses harder."""
    freeing = smallest_freeing(rig, rig.Omega)
    currents = np.array(list(freeing.injected.values()))
    pressed, now = states_at(rig, rig.Omega, -currents), states_at(rig, rig.Omega)
    assert [state.contact for state in pressed] == [("rb1", "rb2")]
    assert sum(pressed[0].N.values()) > sum(now[0].N.values())


@pytest.mark.parametrize(
    ("Omega", "u", "kind"),
    [
        (60.0, 0.020, Regime.FREE),
        (SPEED, 0.005, Regime.FREE),
        (SPEED, 0.025, Regime.BOTH),
        (SPEED, 0.03125, Regime.CONTACT),
        (140.0, 0.010, Regime.BOTH),
        (170.0, 0.010, Regime.FREE),
        (170.0, 0.030, Regime.WHIRL),
    ],
)
def test_map_agrees_with_runs_of_the_rig(rig, Omega, u, kind):
    """Points within the areas that runs over speed and unbalance show."""
    result = trap_map(on_d1(rig, u), np.array([Omega]), np.ones(1))
    assert result.regimes()[0, 0] == kind


def test_without_friction_and_rotating_damping_no_slow_whirl_lasts(rig):
    assert [whirl for whirl in whirls(rig, rig.Omega) if abs(whirl.frequency) < 1000.0] == []


@pytest.mark.slow
@pytest.mark.parametrize(("u", "stays"), [(0.01775, False), (0.0179, True)])
def test_rotor_is_released_where_its_contact_state_ends(rig, u, stays):
    """The trap of 16 Hz ends in a fold at 17.81 g m; unloaded in steps, a run leaves it within 0.1 g m of that."""
    loads = ((2.0, 0.031), (100.0, 0.026), (180.0, 0.022), (260.0, 0.020), (340.0, 0.019), (420.0, 0.0184), (500.0, u))
    events = tuple({"cycle": cycle, "set": {"rotor_contact": {"d1.u": load}}} for cycle, load in loads)
    record = {"every": 4, "variables": ["rotor_contact.rb?.f_n_mean"]}
    changes = {"event": events, "end_cycle": 800, "unbalance_factor": 1.0, "record": record}
    scenario = as_scenario("fig5_6_pid", None).changed(**changes)
    run = amb_cosim.run(scenario, set={"rotor_contact.d1.u": 0.01}, progress=False).dataset
    forces = [run[f"rotor_contact.{site}.f_n_mean"].values[-100:].mean() for site in rig.sites]
    states = [s for s in states_at(on_d1(rig, u), rig.Omega) if s.contact]
    assert len(states) == (2 if stays else 0)
    expected = next((list(s.N.values()) for s in states if s.small.is_stable), [0.0, 0.0])
    np.testing.assert_allclose(forces, expected, rtol=1e-6)


@pytest.mark.parametrize("case", ["rolling_90", "rolling_220"])
def test_runs_that_roll_have_the_computed_frequency_and_forces(case):
    """N over the angle between the journals, which is free, is mean + swing cos(angle); friction is 2."""
    rig = rubbing_rotor(prepare_run(as_scenario(case, None)))
    result = next(result for result in rolling(rig, rig.Omega) if len(result.contact) == 2)
    assert 0.05 < result.friction < 0.15
    run = amb_cosim.run(case, progress=False).dataset
    last = run["time"].values > run["time"].values[-1] - 0.05
    first, second = (run[f"rotor_contact.{s}.x"].values + 1j * run[f"rotor_contact.{s}.y"].values for s in rig.sites)
    angle = np.angle(second[-1] / first[-1])
    for site in rig.sites:
        np.testing.assert_allclose(run[f"rotor_contact.{site}.whirl_speed"].values[last], result.frequency, rtol=1e-9)
        force = run[f"rotor_contact.{site}.f_n_mean"].values[last].mean()
        assert force == pytest.approx(result.N[site] + result.swing[site] * np.cos(angle), rel=5e-3)


def test_relieved_rotor_keeps_whirling_in_contact_at_its_frequency():
    """140 rad/s, 40 g m for ten turns, then 5: no synchronous state, but a whirl in both retainers at 145.4 rad/s.

    At its frequency, which is within the band that the study reports, the run has the computed forces to 2 %.
    """
    events = tuple(
        {"role": role, "cycle": cycle, "set": {"rotor_contact": {"d1.u": u}}}
        for role, cycle, u in (("disturbance", 2.0, 0.040), ("relief", 12.0, 0.005))
    )
    record = {"every": 1, "variables": ["rotor_contact.rb?.?", "rotor_contact.rb?.f_n_mean"]}
    changes = {"Omega": 140.0, "event": events, "end_cycle": 67, "unbalance_factor": 1.0, "record": record}
    scenario, start = as_scenario("fig5_6_pid", None).changed(**changes), {"rotor_contact.d1.u": 0.0025}
    relieved = rubbing_rotor(prepare_run(scenario, start))
    run = amb_cosim.run(scenario, set=start, progress=False).dataset
    time = run["time"].values
    late = time > 1.0
    z = run["rotor_contact.rb1.x"].values[late] + 1j * run["rotor_contact.rb1.y"].values[late]
    frequency = np.polyfit(time[late], np.unwrap(np.angle(z)), 1)[0]
    assert frequency == pytest.approx(145.4, abs=0.2)
    bands = [whirl for whirl in contact_whirls(relieved, 140.0) if whirl.signs == (1, 1)]
    assert [whirl.frequencies[0] < frequency < whirl.frequencies[1] for whirl in bands] == [True]
    at = receptances(relieved.loop(140.0), frequency)
    forces = contact_forces(at.R[None], (0, 1), (1, 1), relieved.c)[0][0].real
    means = [run[f"rotor_contact.{site}.f_n_mean"].values[late].mean() for site in relieved.sites]
    np.testing.assert_allclose(means, forces, rtol=0.02)
