"""A linear controller that runs without FMI, and random laws."""

from typing import Any

import control
import numpy as np

from amb_cosim.controllers.linear_controller import LinearController
from fmi_export.model import Instance

T = 1e-4


class Bench:
    """An initialised controller; values of parameters and inputs by name with `__` for the dot."""

    def __init__(self, controller: LinearController, signals=None, **values: Any):
        self.controller, self.n = controller, 0
        self.instance = Instance(*controller.model_and_constants)
        self.set(**values)
        self.read(signals)
        self.instance.initialise()

    def set(self, **values: Any) -> None:
        for name, value in values.items():
            self.instance[name.replace("__", ".")] = value

    def read(self, signals) -> None:
        for name, value in zip(self.controller.ports.signals, () if signals is None else signals, strict=False):
            self.instance[name] = value

    def demands(self):
        return np.array([self.instance[name] for name in self.controller.ports.demands])

    def states(self):
        return np.array([self.instance[f"state.x{k + 1}"] for k in range(self.controller.ports.n_states)])

    def step(self, signals=None, **values: Any):
        """Demands after a step of a sample under these signals."""
        self.set(**values)
        self.read(signals)
        self.instance.step(self.n * self.controller.sample_time, self.controller.sample_time)
        self.n += 1
        return self.demands()

    def run(self, signals):
        """Demands after a step for each row of signals."""
        return np.array([self.step(row) for row in signals])


def names(kind: str, count: int) -> list[str]:
    return [f"{kind}{k + 1}.x" for k in range(count)]


def random_law(seed: int, n_states: int, n_demands: int, n_signals: int, fastest: float = 1.0):
    """A stable continuous law with poles up to `fastest` over the sample time (rad/s)."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n_states, n_states))
    if n_states:
        A -= (0.05 + np.linalg.eigvals(A).real.max()) * np.eye(n_states)
        A *= fastest / T / np.abs(np.linalg.eigvals(A)).max()
    B, C = rng.normal(size=(n_states, n_signals)) / T**0.5, rng.normal(size=(n_demands, n_states)) / T**0.5
    return control.ss(A, B, C, rng.normal(size=(n_demands, n_signals)))


def response(law, signals):
    """Demands of a sampled law by python-control, from states of zero."""
    times = np.arange(len(signals)) * law.dt
    result = control.forced_response(law, times, np.asarray(signals).T, squeeze=False)
    return result.outputs.T
