"""Tune the damping of a controller over 64 rotors at once, whose friction and restitution nobody knows exactly.

    pip install '.[gym]'
    python examples/tune_damping.py [SCENARIO]

The scenario is the packs' default without.

An optimiser of scipy asks for the mean reward of a damping: no contact, and little current, while an unbalance comes
and goes.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize_scalar

from amb_cosim.gym import RotorVectorEnv
from amb_cosim.scenario.scenario import Scenario, given_scenario
from rotor_analysis.rotor_file import load_rotor

LOWEST, HIGHEST = 500.0, 20000.0  # N s/m


def tune(
    scenario: Scenario | str | Path | None = None,
    n: int = 64,
    names: list[str] | None = None,
    decisions: int = 600,
    trials: int = 12,
) -> tuple[float, float]:
    """Return the best damping (N s/m) and its mean reward for each decision; of all bearings unless `names` says."""
    machine = given_scenario(scenario, None)
    bearings = [bearing.name for bearing in load_rotor(machine.rotor).bearings]
    names = names or [f"rolac_controller.{bearing}.c_b_{axis}" for bearing in bearings for axis in "xy"]
    random = np.random.default_rng(1)
    env = RotorVectorEnv(
        machine,
        n,
        actions={name: (LOWEST, HIGHEST) for name in names},
        observations=[],
        decisions=decisions + 1,
        set={
            "rotor_contact.*.mu": random.uniform(0.05, 0.2, n),
            "rotor_contact.*.restitution": random.uniform(0.3, 0.8, n),
        },
    )

    def loss(damping: float) -> float:
        env.reset()
        action = np.full((n, len(names)), damping)
        return -float(np.mean([env.step(action)[1].mean() for _ in range(decisions)]))

    found = minimize_scalar(loss, bounds=(LOWEST, HIGHEST), method="bounded", options={"maxiter": trials})
    env.close()
    return float(found.x), -float(found.fun)


if __name__ == "__main__":
    damping, reward = tune(*sys.argv[1:2])
    print(f"{damping:.0f} N s/m, mean reward {reward:.4f}")
