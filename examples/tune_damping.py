"""Tune the damping of a controller over 64 rotors at once, whose friction and restitution nobody knows exactly.

    pip install 'amb-cosim[gym]'
    python examples/tune_damping.py

An optimiser of scipy asks for the mean reward of a damping: no contact, and little current, while an unbalance comes
and goes.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.optimize import minimize_scalar

from amb_cosim.gym import RotorVectorEnv

DAMPING = [f"rolac_controller.{bearing}.c_b_{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
LOWEST, HIGHEST = 500.0, 6000.0  # N s/m


def tune(
    scenario: str | Path = "fig4_9", n: int = 64, names: list[str] = DAMPING, decisions: int = 600, trials: int = 12
) -> tuple[float, float]:
    """Return the best damping (N s/m) and its mean reward for each decision of 1 ms."""
    random = np.random.default_rng(1)
    env = RotorVectorEnv(
        scenario,
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
    damping, reward = tune()
    print(f"{damping:.0f} N s/m, mean reward {reward:.4f}")
