"""Measure everything in one run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import RunOptions
from benchmarks import cases, contact_cost, scaling, step_times
from benchmarks.candidates import Missing, fig4_9_candidates, native_possible, retainer_candidates, rubbing_candidates
from benchmarks.timing import environment, interleaved_times, ratio, ratios

# Of each ratio: numerator, denominator, and the aim, an upper limit for AT_MOST and a lower one for the others.
RATIOS = {
    "native_over_floor": ("native", "floor", 1.25),
    "ecospy_over_native": ("ecospy", "rub_native", 4.0),
    "libcosimpy_over_native": ("libcosimpy", "rub_native", 5.0),
    "ross_over_native": ("ross", "ring_native", 40.0),
    "siconos_over_native": ("siconos", "ring_native", 75.0),
    "plain_over_compiled_python": ("python_plain", "python", 2.0),
}
AT_MOST = "native_over_floor"
REDUCED = ("siconos_reduced", "ring_native")  # Siconos with the reduced rotor: a ratio without an aim
REAL_TIME_FACTOR = 200.0  # of native, at least

ShowStatus = Callable[[str], None]


@dataclass(frozen=True)
class Effort:
    """How much is measured: rounds in which every candidate runs once, simulated times (s), repetitions."""

    rounds: int
    rubbing_s: float
    retainer_s: float
    durations_s: tuple[float, ...]
    memory_s: tuple[float, ...]
    scaling_rounds: int
    contact_repeats: int


FULL = Effort(11, 1.0, 0.5, (1.0, 2.0, 4.0, 8.0), (2.0, 6.0, 10.0), 9, 5)
QUICK = Effort(1, 0.05, 0.05, (0.1, 0.2, 0.4), (1.0, 2.0, 4.0), 1, 1)


def measure(effort: Effort = FULL, show_status: ShowStatus = lambda _: None) -> dict[str, Any]:
    """Return ratios, real-time factors and the underlying times, for JSON; None for values that cannot be measured."""
    native, missing = native_possible(), Missing()
    show_status("building the FMUs and finding other codes (the first run compiles the models)")
    parts: dict[str, list[float]] = {}
    groups = [fig4_9_candidates("python", parts)]
    if native:
        groups += [
            fig4_9_candidates("native", parts),
            rubbing_candidates(effort.rubbing_s, missing),
            retainer_candidates(effort.retainer_s, missing),
        ]
    else:
        missing["native"] = "ziglang is not installed (extra: native)"
    show_status("timing all candidates")
    times = interleaved_times({name: candidate for group in groups for name, candidate in group.items()}, effort.rounds)
    flavour: Flavour = "native" if native else "python"
    options = RunOptions(flavour=flavour)
    show_status("measuring cost over time, sites and variables")
    growth = {
        "simulated_time": scaling.cost_over_time(options, effort.durations_s, effort.scaling_rounds),
        "sites": scaling.cost_over_sites(options, effort.retainer_s, effort.scaling_rounds),
        "variables": scaling.cost_over_variables(options, effort.rubbing_s, effort.scaling_rounds),
    }
    show_status("timing single steps")
    single_steps = step_times.step_times(effort.rounds) if native else None
    show_status("measuring memory")
    memory = scaling.memory_over_time(flavour, effort.memory_s)
    show_status("comparing contact laws")
    contact = contact_cost.compare(effort.contact_repeats)
    return {
        "ratios": {name: ratio(times, above, below) for name, (above, below, _) in RATIOS.items()},
        "real_time_factor": {
            name: cases.STEP / median(times[name]) if name in times else None
            for name in ("native", "python", "native_plain", "python_plain", "floor")
        },
        "environment": environment(),
        "siconos_reduced_over_native": ratio(times, *REDUCED),
        "spread": {name: _limits(ratios(times, above, below)) for name, (above, below, _) in RATIOS.items()},
        "step_us": {name: [1e6 * t for t in (median(each), min(each), max(each))] for name, each in times.items()},
        "floor_us": {part: 1e6 * min(each) for part, each in parts.items()} if native else None,
        "single_steps_us": single_steps,
        "linearity": growth,
        "memory": memory,
        "contact": contact,
        "missing": missing,
        "rounds": effort.rounds,
    }


def _limits(values: Sequence[float]) -> list[float] | None:
    """Return the lowest and the highest value."""
    return [min(values), max(values)] if values else None
