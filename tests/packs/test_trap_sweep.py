"""The map of traps against co-simulations: 400 runs of the rig over speed and unbalance, half of them knocked.

A run that is not at rest after 8 s is repeated over 40 s.
"""

from dataclasses import replace

import numpy as np
import pytest

import amb_cosim
from amb_analysis.steady_contact.rubbing_rotor import rubbing_rotor
from amb_analysis.steady_contact.trap_map import states_at
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario

SPEEDS, AMOUNTS = np.linspace(45.0, 235.0, 20), np.linspace(3e-3, 60e-3, 20)  # rad/s, kg m on D1
TIMES = (8.0, 40.0)  # s
UNSTEADY = ("settling", "unsteady", "failed")  # how runs may end where the map has no stable state
AT_REST = 0.02  # standard deviation of a force, over the largest mean, that counts as none


def run_of(Omega, u, is_knocked, time):
    """Return time (s) and forces (N) of a run: at rest with 0.5 u, then u, or 2 u for ten turns and then u."""
    more = [
        {
            "label": "step",
            "role": "disturbance",
            "cycle": 2.0,
            "set": {"rotor_contact": {"d1.u": 2.0 * u if is_knocked else u}},
        }
    ]
    less = [{"role": "relief", "cycle": 12.0, "set": {"rotor_contact": {"d1.u": u}}}] if is_knocked else []
    cycles = float(np.ceil(time * Omega / (2.0 * np.pi)))
    changes = {"Omega": float(Omega), "event": (*more, *less), "end_cycle": cycles, "unbalance_factor": 1.0}
    changes["record"] = {"every": 4, "variables": ["rotor_contact.rb?.f_n_mean"]}
    scenario = as_scenario("fig5_6_pid", None).changed(**changes)
    result = amb_cosim.run(scenario, set={"rotor_contact.d1.u": 0.5 * u}, progress=False)
    data = result.dataset
    forces = np.array([data[f"rotor_contact.{site}.f_n_mean"].values for site in ("rb1", "rb2")])
    return data["time"].values, forces, result.outcome.status


def end_of(Omega, u, is_knocked):
    """Return the ending of a run (free, steady, settling, unsteady or failed) and its mean forces (N)."""
    for time in TIMES:
        t, N, status = run_of(Omega, u, is_knocked, time)
        if status != "completed":
            return "failed", np.zeros(2)
        last, before = t > t[-1] - 1.0, (t > 0.5 * t[-1] - 1.0) & (t <= 0.5 * t[-1])
        mean, spread = N[:, last].mean(axis=1), N[:, last].std(axis=1).max()
        if not N[:, last].any():
            return "free", mean
        if spread < AT_REST * mean.max():
            return "steady", mean
    decays = spread < 0.7 * N[:, before].std(axis=1).max()
    return ("settling" if decays else "unsteady"), mean


def agrees(rig, Omega, u, is_knocked):
    """Return whether the map has the state in which a run ends."""
    states = states_at(replace(rig, unbalance=np.array([u, *np.zeros(5)], dtype=complex)), Omega)
    free = any(not state.contact for state in states)
    traps = [state for state in states if state.contact and state.small.is_stable]
    resting = [state for state in traps if state.small.settles(Omega)]
    lasts = len(traps) > len(resting) or not (free or traps)  # it may vibrate in contact for more than a thousand turns
    end, mean = end_of(Omega, u, is_knocked)
    stable = [[s.N.get(site, 0.0) for site in rig.sites] for s in traps]
    near = any(np.abs(np.array(N) - mean).max() < 0.02 * max(N) for N in stable)
    return {"free": free, "steady": near, "settling": near}.get(end, False) or (lasts and end in UNSTEADY)


@pytest.mark.slow
def test_runs_end_in_states_of_the_map(is_long):
    """Every run, or every tenth, spread over speed and unbalance."""
    rig, every = rubbing_rotor(prepare_run(as_scenario("fig5_6_pid", None))), 1 if is_long else 10
    chosen = [(i, j) for i in range(len(SPEEDS)) for j in range(len(AMOUNTS)) if (i + 3 * j) % every == 0]
    agreement = [agrees(rig, float(SPEEDS[i]), float(AMOUNTS[j]), (i + j) % 2 == 0) for i, j in chosen]
    assert sum(agreement) >= 0.95 * len(agreement)
