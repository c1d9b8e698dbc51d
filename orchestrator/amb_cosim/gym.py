"""Rotors as environments of gymnasium: gains or other inputs are actions, displacements observations.

It requires the extra `gym`. The environments are the members of a `Batch`, stepped together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from amb_cosim.results.component_names import CONTROLLER, PLANT
from amb_cosim.scenario.batch import Batch
from amb_cosim.scenario.scenario import Scenario
from array_types import Array, Bools

CONTACT = f"{PLANT}.contact_state"
CURRENTS = (f"{CONTROLLER}.*.i_x", f"{CONTROLLER}.*.i_y")


class RotorVectorEnv(VectorEnv[Array, Array, Any]):
    """Members of a scenario, from cycle 0 on, as a vectorised environment.

    An action holds for `decision_steps` communication steps. The reward of a decision is

        r = -c - w sum(i^2)

    with c = 1 if the rotor is in contact at its end and 0 otherwise, the currents i (A) of all controller axes at its
    end, and their weight w (1/A^2). An episode is terminated if a step fails, with reward `failure_reward`, and
    truncated after `decisions`. Members that end are reset in the same call (`AutoresetMode.SAME_STEP`), and their last
    observations are `infos["final_obs"]`.

    Parameters
    ----------
    scenario, num_envs, options
        As for `amb_cosim.Batch`; members differ through `set`.
    actions
        Lowest and highest value of each input or tunable parameter that an action sets, in the unit of the variable.
    observations
        Names of the observed variables, in their units.
    decision_steps, decisions
        Communication steps of a decision, and decisions of an episode.
    current_weight, failure_reward
        w (1/A^2), and the reward of a step that fails.

    Raises
    ------
    ValueError
        As for `Batch`, and if the range of an action is invalid.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.SAME_STEP}  # noqa: RUF012 (gymnasium has it so)

    def __init__(
        self,
        scenario: str | Path | Scenario,
        num_envs: int,
        *,
        actions: Mapping[str, tuple[float, float]],
        observations: Sequence[str],
        decision_steps: int = 4,
        decisions: int = 1000,
        current_weight: float = 1e-3,
        failure_reward: float = -100.0,
        **options: Any,
    ) -> None:
        low, high = np.array([*actions.values()], np.float64).reshape(-1, 2).T
        if not np.all((low < high) & np.isfinite(low) & np.isfinite(high)):
            raise ValueError(f"actions {dict(actions)} are not allowed; each must have a lowest and a highest value")
        for name, number in (("decision_steps", decision_steps), ("decisions", decisions)):
            if not (isinstance(number, int | np.integer) and number >= 1):
                raise ValueError(f"{name} = {number!r} is not allowed; it must be a whole number, 1 or more")
        if not (np.isfinite(current_weight) and current_weight >= 0.0):
            raise ValueError(f"current_weight = {current_weight} 1/A^2 is not allowed; it must be finite, 0 or more")
        if not np.isfinite(failure_reward):
            raise ValueError(f"failure_reward = {failure_reward} is not allowed; it must be finite")
        variables = (*observations, CONTACT, *CURRENTS)
        self.batch = Batch(scenario, num_envs, inputs=list(actions), variables=variables, **options)
        self._actions, self._seen = list(actions), [self.batch.get(name) for name in observations]
        self._contact = self.batch.get(CONTACT)
        names = [name for name in self.batch.names if name.startswith(f"{CONTROLLER}.")]
        self._currents = [self.batch.get(name) for name in names if name.endswith((".i_x", ".i_y"))]
        self._decision_steps, self._decisions = decision_steps, decisions
        self._weight, self._failure_reward = current_weight, failure_reward
        self._made = np.zeros(num_envs, np.intp)  # decisions so far in the episode
        self.num_envs = num_envs
        self.single_action_space = gym.spaces.Box(low, high, dtype=np.float64)
        self.single_observation_space = gym.spaces.Box(-np.inf, np.inf, (len(observations),), np.float64)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Reset all members to cycle 0; nothing is random, so the seed has no effect."""
        super().reset(seed=seed if isinstance(seed, int) else None)
        self.batch.reset()
        self._made[:] = 0
        return self._observe(), {}

    def step(self, actions: Array) -> tuple[Array, Array, Bools, Bools, dict[str, Any]]:
        """Set actions, shape (members, actions), and run the steps of a decision."""
        values, shape = np.asarray(actions, np.float64), (self.num_envs, len(self._actions))
        if values.shape != shape:
            raise ValueError(f"actions of shape {values.shape} are not allowed; it must be {shape}: members, actions")
        for name, column in zip(self._actions, values.T, strict=True):
            self.batch.set(name, column)
        self.batch.step(self._decision_steps)
        self._made += 1
        failed = self.batch.failed.copy()
        squares = sum((i * i for i in self._currents), np.zeros(self.num_envs))
        rewards = np.where(
            failed, self._failure_reward, -np.where(self._contact != 0.0, 1.0, 0.0) - self._weight * squares
        )
        cut = (self._made >= self._decisions) & ~failed
        infos: dict[str, Any] = {}
        if (ended := failed | cut).any():
            infos = {"final_obs": self._observe(), "_final_obs": ended}
            self.batch.reset(ended)
            self._made[ended] = 0
        return self._observe(), rewards, failed, cut, infos

    def _observe(self) -> Array:
        return np.column_stack(self._seen) if self._seen else np.zeros((self.num_envs, 0))

    def close_extras(self, **_: Any) -> None:
        """Free the FMUs."""
        self.batch.close()
