"""How cost grows with simulated time, sites in contact and recorded variables, and memory with simulated time."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from amb_cosim.cosim.fmus import Flavour
from amb_cosim.scenario import Scenario, make_scenario
from amb_cosim.simulation import Prepared, prepare, run_prepared
from benchmarks import cases
from benchmarks.process import call

SITES = ("rb1", "rb2", "eb1", "eb2")
LOADS = {"mb1.f_x": 2e4, "mb2.f_x": 2e4, "d1.f_x": 5e3, "d4.f_x": 5e3}  # N, at the sites
RECORDED: tuple[list[str], ...] = (
    [],
    ["rotor_contact.*"],
    ["rotor_contact.*", "amb_actuator.*"],
    ["*"],
    ["*", "rolac_controller.r.*"],
)  # besides what figures need


@dataclass(frozen=True)
class Line:
    """Costs `y` over `x`, and the straight line that fits them best."""

    x: list[float]
    y: list[float]

    @property
    def coefficients(self) -> tuple[float, float]:
        """Slope, and cost at x = 0."""
        slope, start = np.polyfit(self.x, self.y, 1)
        return float(slope), float(start)

    @property
    def deviation(self) -> float:
        """Largest distance from the line, over the largest cost."""
        slope, start = self.coefficients
        return float(np.max(np.abs(np.array(self.y) - slope * np.array(self.x) - start)) / np.max(self.y))

    def as_data(self, x: str, y: str) -> dict[str, Any]:
        """For JSON, under the names of both quantities."""
        slope, start = self.coefficients
        return {x: self.x, y: self.y, "slope": slope, "at_zero": start, "largest_deviation": self.deviation}


def over_time(flavour: Flavour, durations: Sequence[float], rounds: int) -> dict[str, Any]:
    """Seconds that runs of RUB take, over their simulated time (s), after the rotor has settled to its rubbing."""
    runs = [cases.rub(flavour, seconds, settle_cycles=40) for seconds in durations]
    return Line(list(durations), _medians(runs, rounds)).as_data("simulated_s", "seconds")


def over_sites(flavour: Flavour, seconds: float, rounds: int) -> dict[str, Any]:
    """Seconds for a step of the plant, over the number of sites that a load presses it onto."""
    runs = [prepare(pressed(count, seconds), flavour=flavour) for count in range(len(SITES) + 1)]
    steps = runs[0].plan.last
    return Line(_touching(runs), [t / steps for t in _medians(runs, rounds)]).as_data("sites_in_contact", "step_s")


def over_variables(flavour: Flavour, seconds: float, rounds: int) -> dict[str, Any]:
    """Seconds for a step of RUB, over the number of variables that are recorded."""
    runs = [cases.rub(flavour, seconds, record={"variables": patterns}) for patterns in RECORDED]
    counts, steps = [float(len(prepared.plan.recorded)) for prepared in runs], runs[0].plan.last
    return Line(counts, [t / steps for t in _medians(runs, rounds)]).as_data("variables", "step_s")


def memory(flavour: Flavour, durations: Sequence[float]) -> dict[str, Any] | None:
    """Peak memory of a process (bytes) over the simulated time (s) of its run of RUB, with all variables recorded.

    `over_recorder` is its growth over what the recorded numbers alone take. None where the system does not tell.
    """
    if sys.platform == "win32":
        return None
    found = [call(sys.executable, __file__, "apart", flavour=flavour, seconds=t) for t in durations]
    line = Line(list(durations), [f["peak"] for f in found])
    recorder = Line(list(durations), [f["recorder"] for f in found])
    growth = line.coefficients[0] / recorder.coefficients[0]
    return line.as_data("simulated_s", "peak_bytes") | {"over_recorder": growth}


def apart(flavour: Flavour, seconds: float) -> Any:
    """`peak_memory` in a process that a small one has started: on Linux its peak begins with that of who starts it."""
    return call(sys.executable, __file__, "peak_memory", flavour=flavour, seconds=seconds)


def peak_memory(flavour: Flavour, seconds: float) -> dict[str, float]:
    """Largest memory of this process after a run of RUB, and what its recorded numbers take, in bytes."""
    import resource

    prepared = cases.rub(flavour, seconds, record={"variables": ["*"]})
    run_prepared(prepared)
    unit = 1 if sys.platform == "darwin" else 1024
    peak = unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {"peak": peak, "recorder": 8.0 * (prepared.plan.last + 1) * (len(prepared.plan.recorded) + 1)}


def pressed(count: int, seconds: float) -> Scenario:
    """The rotor on its springs, pressed onto so many sites of equal clearance by loads at all of them."""
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


def _touching(runs: Sequence[Prepared]) -> list[float]:
    """Number of sites in contact, on average over each run."""
    datasets = [run_prepared(prepared).dataset for prepared in runs]
    return [sum(float((d[f"rotor_contact.{site}.mode"] > 0).mean()) for site in SITES) for d in datasets]


def _medians(runs: Sequence[Prepared], rounds: int) -> list[float]:
    """Median time (s) that each run steps, when they take turns."""
    times = [[float(run_prepared(prepared).dataset.attrs["wall_s"]) for prepared in runs] for _ in range(rounds + 1)]
    return [median(column) for column in zip(*times[1:], strict=True)]
