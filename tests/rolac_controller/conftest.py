"""A controller to drive with signals or to close the loop with, and random receptances and plants."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from rig import AXES, CONTROLLER, NO_TABLE, SENSOR_NAMES

from fmi_export.model import Array, Instance

Signal = Callable[[float], NDArray[np.float64]]
Complex = NDArray[np.complex128]

H = 250e-6


class Bench:
    """A controller under test; it counts its own samples and turns the rotor by `Omega` for each."""

    def __init__(self, constants: Array = NO_TABLE, **parameters: float) -> None:
        self.instance = Instance(CONTROLLER, constants)
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

    def components(self) -> Complex:
        """Synchronous displacements Q of s1 to s8 (m)."""
        return np.array([self[f"amplitude.{s}"] * np.exp(1j * self[f"phase.{s}"]) for s in SENSOR_NAMES])

    def forces(self) -> Complex:
        """Synchronous forces U of mb1.x, mb1.y, mb2.x, mb2.y (N)."""
        return np.array([self[f"{b}.u_{a}"] * np.exp(1j * self[f"{b}.u_phase_{a}"]) for b, a in AXES])

    def axis_forces(self) -> NDArray[np.float64]:
        """Forces K_i I that the demanded currents make (N)."""
        return np.array([self[f"{b}.k_i_{a}"] * self[f"{b}.i_{a}"] for b, a in AXES])

    def receptance(self) -> Complex:
        """The receptance that was identified last, shape (8, 4) (m/N)."""
        return np.array(
            [[complex(self[f"r.{s}.{b}_{a}.re"], self[f"r.{s}.{b}_{a}.im"]) for b, a in AXES] for s in SENSOR_NAMES]
        )


class Plant:
    """A linear plant in discrete time, x+ = A x + B u, q = C x + disturbance(theta); u is held over a sample."""

    def __init__(self, a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64]) -> None:
        self.a, self.b, self.c = a, b, c
        self.x = np.zeros(len(a))
        self.disturbance: Signal = lambda theta: np.zeros(8)

    def run(self, bench: Bench, samples: int) -> None:
        """Close the loop with a controller for a number of samples."""
        for _ in range(samples):
            bench.sense(self.c @ self.x + self.disturbance(bench.theta))
            bench.sample()
            self.x = self.a @ self.x + self.b @ bench.axis_forces()

    def receptance(self, bench: Bench, order: int = 1) -> Complex:
        """C (z I - A)^-1 B at the speed of the controller: synchronous displacements by held forces (m/N)."""
        z = np.exp(1j * order * bench["Omega"] * bench.h)
        return self.c @ np.linalg.solve(z * np.eye(len(self.a)) - self.a, self.b.astype(complex))


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
def without_pid() -> dict[str, float]:
    """Parameters of a controller whose PID does nothing."""
    return {f"{b}__{name}_{a}": 0.0 for b, a in AXES for name in ("k_b", "k_s", "c_b")}


@pytest.fixture
def make_plant() -> type[Plant]:
    """Makes a plant of matrices A, B, C."""
    return Plant


@pytest.fixture
def discrete_plant() -> Callable[..., Plant]:
    """Makes a random stable plant with receptances of the size of the rig's; it forgets in about 20 samples."""

    def make(seed: int = 5) -> Plant:
        rng = np.random.default_rng(seed)
        a = np.zeros((12, 12))
        for k in range(6):
            radius, angle = rng.uniform(0.4, 0.8), rng.uniform(0.1, 2.5)
            block = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
            a[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = radius * np.array(block)
        return Plant(a, rng.normal(size=(12, 4)), 3e-7 * rng.normal(size=(8, 12)))

    return make


@pytest.fixture
def speed_of() -> Callable[[float], float]:
    """Speed (rad/s) at which a revolution takes so many samples at 4 kHz."""
    return lambda samples: 2.0 * math.pi / (samples * H)


@pytest.fixture
def receptance() -> Complex:
    """A random, well-conditioned 8 x 4 receptance of the size of the rig's (m/N)."""
    rng = np.random.default_rng(7)
    return 1e-6 * (rng.normal(size=(8, 4)) + 1j * rng.normal(size=(8, 4)))


@pytest.fixture
def unbalance_response() -> Complex:
    """Synchronous displacements Q_0 (m) that an unbalance causes at the sensors of the plant Q = Q_0 + R U."""
    return 1e-4 * np.exp(1j * np.linspace(0.0, 5.0, 8)) * np.linspace(0.5, 1.5, 8)


@pytest.fixture
def optimum(receptance: Complex, unbalance_response: Complex) -> Complex:
    """Least-squares optimum of the forces on that plant, by a solver that knows nothing of H."""
    return np.linalg.lstsq(receptance, -unbalance_response, rcond=None)[0]
