"""Measure time over simulated time, sites in contact and recorded variables, and memory over simulated time."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, make_scenario
from amb_cosim.scenario.simulation import execute
from benchmarks import cases
from benchmarks.process import run_function

SITES = ("rb1", "rb2", "eb1", "eb2")
LOADS = {"mb1.f_x": 2e4, "mb2.f_x": 2e4, "d1.f_x": 5e3, "d4.f_x": 5e3}  # N, at the sites
RECORDED: tuple[list[str], ...] = (  # besides the variables that are always recorded
    [],
    ["rotor_contact.*"],
    ["rotor_contact.*", "amb_actuator.*"],
    ["*"],
    ["*", "rolac_controller.r.*"],
)


@dataclass(frozen=True)
class LinearFit:
    """Values `y` over `x`, and their straight line of least squares."""

    x: list[float]
    y: list[float]

    @property
    def coefficients(self) -> tuple[float, float]:
        """Slope, and value at x = 0."""
        slope, start = np.polyfit(self.x, self.y, 1)
        return float(slope), float(start)

    @property
    def deviation(self) -> float:
        """Largest distance from the line, over the largest value."""
        slope, start = self.coefficients
        return float(np.max(np.abs(np.array(self.y) - slope * np.array(self.x) - start)) / np.max(self.y))

    def as_data(self, x: str, y: str) -> dict[str, Any]:
        """Return the values, under the names of both quantities, and the line, for JSON."""
        slope, start = self.coefficients
        return {x: self.x, y: self.y, "slope": slope, "at_zero": start, "largest_deviation": self.deviation}


def cost_over_time(options: RunOptions, durations: Sequence[float], rounds: int) -> dict[str, Any]:
    """Measure the time (s) of the rubbing case over its simulated time (s), after 40 cycles of settling."""
    runs = [cases.rubbing_case(seconds, options, settle_cycles=40) for seconds in durations]
    return LinearFit(list(durations), _median_times(runs, rounds)).as_data("simulated_s", "seconds")


def cost_over_sites(options: RunOptions, seconds: float, rounds: int) -> dict[str, Any]:
    """Measure the time (s) of a step of the plant over the number of sites that loads press it onto."""
    runs = [prepare_run(pressed_rotor(count, seconds), options=options) for count in range(len(SITES) + 1)]
    steps = runs[0].last
    return LinearFit(_mean_sites_in_contact(runs), [t / steps for t in _median_times(runs, rounds)]).as_data(
        "sites_in_contact", "step_s"
    )


def cost_over_variables(options: RunOptions, seconds: float, rounds: int) -> dict[str, Any]:
    """Measure the time (s) of a step of the rubbing case over the number of recorded variables."""
    runs = [cases.rubbing_case(seconds, options, record={"variables": patterns}) for patterns in RECORDED]
    counts, steps = [float(len(prepared.recorded)) for prepared in runs], runs[0].last
    return LinearFit(counts, [t / steps for t in _median_times(runs, rounds)]).as_data("variables", "step_s")


def memory_over_time(flavour: Flavour, durations: Sequence[float]) -> dict[str, Any] | None:
    """Measure peak memory (bytes) over the simulated time (s) of the rubbing case, with all variables recorded.

    `over_recorder` is its slope over that of the memory of the recorded numbers. None on Windows.
    """
    if sys.platform == "win32":
        return None
    memory = [
        run_function(sys.executable, __file__, "peak_memory_in_new_process", flavour=flavour, seconds=t)
        for t in durations
    ]
    peak = LinearFit(list(durations), [bytes_of["peak"] for bytes_of in memory])
    recorder = LinearFit(list(durations), [bytes_of["recorder"] for bytes_of in memory])
    growth = peak.coefficients[0] / recorder.coefficients[0]
    return peak.as_data("simulated_s", "peak_bytes") | {"over_recorder": growth}


def peak_memory_in_new_process(flavour: Flavour, seconds: float) -> Any:
    """Call `peak_memory` from a small process: on Linux a process inherits the peak of the one that starts it."""
    return run_function(sys.executable, __file__, "peak_memory", flavour=flavour, seconds=seconds)


def peak_memory(flavour: Flavour, seconds: float) -> dict[str, float]:
    """Return the peak memory of this process after the rubbing case, and the size of the recorded numbers, in bytes."""
    import resource

    prepared = cases.rubbing_case(seconds, RunOptions(flavour=flavour), record={"variables": ["*"]})
    execute(prepared)
    unit = 1 if sys.platform == "darwin" else 1024
    peak = unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {"peak": peak, "recorder": 8.0 * (prepared.last + 1) * (len(prepared.recorded) + 1)}


def pressed_rotor(count: int, seconds: float) -> Scenario:
    """Return a scenario in which loads press the rotor on springs onto `count` sites of equal clearance."""
    plant: dict[str, Any] = {f"{site}.enabled": site in SITES[:count] for site in SITES}
    return make_scenario(
        {
            "description": "A rotor that is pressed onto its retainers",
            "system": "passive",
            "Omega": cases.SPEED,
            "communication_step": cases.STEP,
            "settle_cycles": 40,
            "end_time": seconds,
            "inputs": {"rotor_contact": LOADS},
            "parameters": {
                "rotor_contact": plant | {"eb?.clearance": cases.CLEARANCE, "rb?.clearance": cases.CLEARANCE}
            },
            "record": {"variables": ["rotor_contact.*.mode"]},
        },
        "pressed",
    )


def _mean_sites_in_contact(runs: Sequence[ScenarioPlan]) -> list[float]:
    """Return the number of sites in contact, averaged over each run."""
    datasets = [execute(prepared).dataset for prepared in runs]
    return [sum(float((d[f"rotor_contact.{site}.mode"] > 0).mean()) for site in SITES) for d in datasets]


def _median_times(runs: Sequence[ScenarioPlan], rounds: int) -> list[float]:
    """Return the median stepping time (s) of each run over rounds in which each runs once."""
    times = [[float(execute(prepared).dataset.attrs["wall_s"]) for prepared in runs] for _ in range(rounds + 1)]
    return [median(column) for column in zip(*times[1:], strict=True)]
