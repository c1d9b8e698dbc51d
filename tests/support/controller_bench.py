"""A controller to drive with signals or to close the loop with, and a plant for it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from rig import CONTROLLER, LOOP
from scipy.signal import cont2discrete

from amb_cosim.model_constants.controller_data import no_table
from array_types import Complex
from fmi_export.model import Array, Instance
from rolac_controller.control_loop import ControlLoop
from rolac_controller.controller import model_for

Signal = Callable[[float], Array]


SAMPLES = 40  # per revolution


def synchronous(theta: float) -> Array:
    """A vibration of 0.1 mm at all sensors."""
    return 1e-4 * np.cos(theta + np.arange(8.0))


class Bench:
    """A controller under test; it counts its own samples and turns the rotor by `Omega` for each.

    Parameters are given by name with `__` for the dot. Without `pid` the gains of all axes are zero.
    """

    def __init__(
        self, constants: Array | None = None, loop: ControlLoop = LOOP, pid: bool = True, **parameters: float
    ) -> None:
        self.sensors, self.axes = loop.sensor_names, tuple((axis.bearing, axis.direction) for axis in loop.axes)
        model = CONTROLLER if loop is LOOP else model_for(loop)
        self.instance = Instance(model, no_table(loop) if constants is None else constants)
        gains = () if pid else ("k_b", "k_s", "c_b")
        none = {f"{b}__{gain}_{a}": 0.0 for b, a in self.axes for gain in gains}
        for name, value in (none | parameters).items():
            self[name.replace("__", ".")] = value
        self.h = self["sample_time"]
        self.n = 0
        self.theta = 0.0
        self.instance.initialise()

    def __getitem__(self, name: str) -> float:
        return self.instance[name]

    def __setitem__(self, name: str, value: float) -> None:
        self.instance[name] = value

    def sense(self, displacements: Array | list[float]) -> None:
        """Set all sensors (m)."""
        for name, value in zip(self.sensors, displacements, strict=True):
            self[name] = float(value)

    def sample(self) -> None:
        """One sample with the present inputs, then turn the rotor."""
        self["theta"] = self.theta
        self.instance.step(self.n * self.h, self.h)
        self.n += 1
        self.theta += self["Omega"] * self.h

    def follow(self, signal: Signal, samples: int) -> None:
        """Drive all sensors by a signal of the rotor angle (m) for a number of samples."""
        for _ in range(samples):
            self.sense(signal(self.theta))
            self.sample()

    def components(self) -> Complex:
        """Synchronous displacements Q of the sensors (m)."""
        return np.array([self[f"amplitude.{s}"] * np.exp(1j * self[f"phase.{s}"]) for s in self.sensors])

    def forces(self) -> Complex:
        """Synchronous forces U of the axes (N)."""
        return np.array([self[f"{b}.u_{a}"] * np.exp(1j * self[f"{b}.u_phase_{a}"]) for b, a in self.axes])

    def axis_forces(self) -> Array:
        """Forces K_i I that the demanded currents make (N)."""
        return np.array([self[f"{b}.k_i_{a}"] * self[f"{b}.i_{a}"] for b, a in self.axes])

    def receptance(self) -> Complex:
        """The receptance that was identified last, shape (sensors, axes) (m/N)."""
        elements = [[f"r.{s}.{b}_{a}" for b, a in self.axes] for s in self.sensors]
        return np.array([[complex(self[f"{r}.re"], self[f"{r}.im"]) for r in row] for row in elements])

    def copy(self) -> Bench:
        """A controller in the same state."""
        other = object.__new__(Bench)
        vars(other).update(vars(self), instance=Instance(self.instance.model, self.instance.constants))
        other.instance.values[:], other.instance.state[:] = self.instance.values, self.instance.state
        return other


class Plant:
    """A linear plant in discrete time, x+ = A x + B u, q = C x + disturbance(theta); u is held over a sample."""

    def __init__(self, a: Array, b: Array, c: Array) -> None:
        self.a, self.b, self.c = a, b, c
        self.x = np.zeros(len(a))
        self.disturbance: Signal = lambda theta: np.zeros(8)

    @classmethod
    def sampled(cls, a: Array, b: Array, c: Array, h: float) -> Plant:
        """x' = A x + B u, sampled every h (s)."""
        return cls(*cont2discrete((a, b, c, np.zeros((len(c), b.shape[1]))), h)[:3])

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
