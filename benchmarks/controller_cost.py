"""Time of a sample of `linear_controller` over its size: `python -m benchmarks.controller_cost`.

The least of many short bursts of fmi2DoStep, called from Python; that of a law without states is what the call costs.
"""

from __future__ import annotations

import time
from ctypes import CFUNCTYPE, c_double, c_int, c_void_p

import control
import numpy as np

from amb_cosim.controllers.linear_controller import linear_controller
from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmus import provide

SAMPLE_TIME = 1e-4  # s
BURST, BURSTS = 10, 3000
# States, signals and demands, and speeds (rad/s) of the table; the controller runs at 150 rad/s.
CASES = {
    "no states, 8 signals, 8 demands": (0, 8, (0.0,)),
    "28 states dense, 4 signals, 4 demands": (28, 4, (0.0,)),
    "100 states dense, 8 signals, 8 demands": (100, 8, (0.0,)),
    "the same between two speeds of a table": (100, 8, (100.0, 200.0)),
}


def running(n_states: int, n_ports: int, speeds: tuple[float, ...]) -> FmuComponent:
    """Return an instance of a controller with dense, stable matrices, after its initialisation."""
    rng = np.random.default_rng(1)
    laws = {}
    for speed in speeds:
        A = rng.normal(size=(n_states, n_states)) / max(2.0 * n_states**0.5, 1.0)
        B, C = rng.normal(size=(n_states, n_ports)), rng.normal(size=(n_ports, n_states))
        laws[speed] = control.ss(A, B, C, rng.normal(size=(n_ports, n_ports)), SAMPLE_TIME)
    signals, demands = ([f"{kind}{k}.x" for k in range(n_ports)] for kind in ("signal", "demand"))
    fmu = provide(linear_controller(laws, signals, demands).__fspath__())
    interface = read_interface(fmu.folder, "controller", fmu.path)
    start = {"enable": 1.0, "Omega": 150.0}
    component = FmuComponent("controller", fmu.folder, interface, signals, demands, start)
    component.enter(0.0)
    component.write()
    component.leave()
    return component


def measure() -> dict[str, float]:
    """Return the least time of a call for each case (s), bursts of all cases in turn."""
    components = {name: running(*case) for name, case in CASES.items()}
    least = dict.fromkeys(components, float("inf"))
    for burst in range(BURSTS):
        for name, component in components.items():
            entry = component.entry_points()
            do_step, instance = CFUNCTYPE(c_int, c_void_p, c_double, c_double, c_int)(entry.do_step), entry.instance
            begin = time.perf_counter()
            for n in range(burst * BURST, (burst + 1) * BURST):
                do_step(instance, n * SAMPLE_TIME, SAMPLE_TIME, 1)
            least[name] = min(least[name], (time.perf_counter() - begin) / BURST)
    for component in components.values():
        component.close()
    return least


if __name__ == "__main__":
    found = measure()
    call = next(iter(found.values()))
    for name, seconds in found.items():
        print(f"{name}: {1e6 * seconds:.2f} us a call, {1e6 * (seconds - call):.2f} us more than without states")
