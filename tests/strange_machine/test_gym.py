"""The expander as an environment of gymnasium."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from strange_machine import RUB

import amb_cosim
from amb_cosim.scenario.scenario import Scenario
from tests.support.messages import raises_naming

pytest.importorskip("gymnasium")

SHORT = Scenario.load(RUB).changed(end_cycle=9)
DAMPING = [f"rolac_controller.{bearing}.c_b_{axis}" for bearing in ("north", "south") for axis in "xy"]
SEEN = ["rotor_contact.north.x", "rotor_contact.shroud.y"]
EXAMPLE = Path(__file__).parents[2] / "examples" / "tune_damping.py"


@pytest.fixture
def env():
    from amb_cosim.gym import RotorVectorEnv

    made = RotorVectorEnv(
        SHORT, 3, actions=dict.fromkeys(DAMPING, (100.0, 800.0)), observations=SEEN, decision_steps=8, decisions=60
    )
    yield made
    made.close()


def actions(env, damping=400.0):
    return np.full(env.action_space.shape, damping)


def test_observations_and_rewards_are_those_of_a_run(env):
    run = amb_cosim.run(SHORT).signals
    observed, _ = env.reset()
    assert env.observation_space.contains(observed)
    currents = [v.values for k, v in run.variables.items() if k.startswith("rolac_controller.") and k[-4:-1] == ".i_"]
    touched = 0.0
    for n in range(8, 8 * 60, 8):  # its damping is that of the action
        observed, rewards, failed, cut, infos = env.step(actions(env))
        assert np.array_equal(observed[1], [run[name].values[n] for name in SEEN])
        in_contact = float(run["rotor_contact.contact_state"].values[n] != 0)
        assert rewards[1] == pytest.approx(-in_contact - 1e-3 * sum(i[n] ** 2 for i in currents), rel=1e-12)
        touched += in_contact
    assert touched > 0.0
    assert not failed.any() | cut.any()
    assert infos == {}


def test_an_action_changes_the_motion_of_its_member_alone(env):
    env.reset()
    values = actions(env)
    values[2] = 700.0
    for _ in range(20):
        observed, *_ = env.step(values)
    assert np.array_equal(observed[0], observed[1])
    assert not np.array_equal(observed[0], observed[2])


def test_episodes_are_cut_and_begin_again(env):
    first, _ = env.reset()
    for _ in range(60):
        observed, _, failed, cut, infos = env.step(actions(env))
    assert cut.all()
    assert not failed.any()
    assert np.array_equal(observed, first)
    assert not np.array_equal(infos["final_obs"], first)


def test_a_range_that_is_none_is_refused():
    from amb_cosim.gym import RotorVectorEnv

    with raises_naming(ValueError, "lowest", "highest"):
        RotorVectorEnv(SHORT, 1, actions={DAMPING[0]: (2.0, 1.0)}, observations=SEEN)


@pytest.mark.slow
def test_the_example_tunes_the_damping_of_any_machine():
    spec = importlib.util.spec_from_file_location("tune_damping", EXAMPLE)
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    example.LOWEST, example.HIGHEST = 100.0, 800.0
    damping, reward = example.tune(SHORT, 4, DAMPING, decisions=130, trials=6)
    worst = min(example.tune(SHORT, 4, DAMPING, decisions=130, trials=1)[1], reward)
    assert 100.0 < damping < 800.0
    assert worst <= reward < 0.0
