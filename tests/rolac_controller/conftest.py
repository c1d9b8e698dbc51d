"""A controller to drive with signals, and random receptances."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from fmi_export.model import Array, Instance
from rolac_controller.controller import MODEL, SENSOR_NAMES
from rolac_controller.table import NO_TABLE

Signal = Callable[[float], NDArray[np.float64]]

H = 250e-6


class Bench:
    """A controller under test; it counts its own samples and turns the rotor by `Omega` for each."""

    def __init__(self, constants: Array = NO_TABLE, **parameters: float) -> None:
        self.instance = Instance(MODEL, constants)
        for name, value in parameters.items():
            self.instance[name.replace("__", ".")] = value
        self.h = self.instance["sample_time"]
        self.n = 0
        self.theta = 0.0

    def __getitem__(self, name: str) -> float:
        return self.instance[name]

    def __setitem__(self, name: str, value: float) -> None:
        self.instance[name] = value

    def sense(self, displacements: NDArray[np.float64] | list[float]) -> None:
        """Set all eight sensors (m)."""
        for name, value in zip(SENSOR_NAMES, displacements, strict=True):
            self.instance[name] = float(value)

    def sample(self) -> None:
        """One sample with the present inputs, then turn the rotor."""
        self.instance["theta"] = self.theta
        self.instance.step(self.n * self.h, self.h)
        self.n += 1
        self.theta += self.instance["Omega"] * self.h

    def follow(self, signal: Signal, samples: int) -> None:
        """Drive all sensors by a signal of the rotor angle (8 values in m) for a number of samples."""
        for _ in range(samples):
            self.sense(signal(self.theta))
            self.sample()

    def components(self) -> NDArray[np.complex128]:
        """Synchronous displacements Q of s1 to s8 (m)."""
        return np.array([self[f"amplitude.{s}"] * np.exp(1j * self[f"phase.{s}"]) for s in SENSOR_NAMES])

    def forces(self) -> NDArray[np.complex128]:
        """Synchronous forces U of mb1.x, mb1.y, mb2.x, mb2.y (N)."""
        names = [(b, a) for b in ("mb1", "mb2") for a in "xy"]
        return np.array([self[f"{b}.u_{a}"] * np.exp(1j * self[f"{b}.u_phase_{a}"]) for b, a in names])


@pytest.fixture
def bench() -> Callable[..., Bench]:
    """Makes an initialised controller; parameters by name with `__` for the dot."""

    def make(constants: Array = NO_TABLE, Omega: float = 0.0, **parameters: float) -> Bench:
        made = Bench(constants, **parameters)
        made["Omega"] = Omega
        made.instance.initialise()
        return made

    return make


@pytest.fixture
def speed_of() -> Callable[[float], float]:
    """Speed (rad/s) at which a revolution takes so many samples at 4 kHz."""
    return lambda samples: 2.0 * math.pi / (samples * H)


@pytest.fixture
def receptance() -> NDArray[np.complex128]:
    """A random, well-conditioned 8 x 4 receptance of the size of the rig's (m/N)."""
    rng = np.random.default_rng(7)
    return 1e-6 * (rng.normal(size=(8, 4)) + 1j * rng.normal(size=(8, 4)))
