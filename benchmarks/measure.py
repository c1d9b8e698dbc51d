"""All of the benchmark, in one run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from amb_cosim.cosim.fmus import Flavour
from benchmarks import cases, contact_cost, scaling
from benchmarks.candidates import Missing, native_possible, on_fig4_9, on_ring, on_rub
from benchmarks.timing import environment, ratio, ratios, take_turns

# Each ratio, the two that it is made of, and the aim: at most that for the first, at least for the others.
RATIOS = {
    "native_over_floor": ("native", "floor", 1.3),
    "ecospy_over_native": ("ecospy", "rub_native", 3.0),
    "libcosimpy_over_native": ("libcosimpy", "rub_native", 5.0),
    "ross_over_native": ("ross", "ring_native", 100.0),
    "siconos_over_native": ("siconos", "ring_native", 30.0),
    "plain_over_compiled_python": ("python_plain", "python", 2.0),
}
AT_MOST = "native_over_floor"
REDUCED = ("siconos_reduced", "ring_native")  # Siconos with the reduced rotor: a ratio without an aim
REAL_TIME_FACTOR = 100.0  # of native, at least

Say = Callable[[str], None]


@dataclass(frozen=True)
class Effort:
    """How much is measured: rounds in which everyone has a turn, simulated times (s), repetitions."""

    rounds: int
    rub_s: float
    ring_s: float
    durations_s: tuple[float, ...]
    memory_s: tuple[float, ...]
    scaling_rounds: int
    contact_repeats: int


FULL = Effort(11, 1.0, 0.5, (1.0, 2.0, 4.0, 8.0), (2.0, 6.0, 10.0), 9, 5)
QUICK = Effort(1, 0.05, 0.05, (0.1, 0.2, 0.4), (1.0, 2.0, 4.0), 1, 1)


def measure(effort: Effort = FULL, say: Say = lambda _: None) -> dict[str, Any]:
    """Ratios, real-time factors and what they are made of, ready for JSON; what cannot be measured here is None."""
    native, missing = native_possible(), Missing()
    say("building the FMUs and looking for others (a first run compiles the models)")
    parts: dict[str, list[float]] = {}
    groups = [on_fig4_9("python", parts)]
    if native:
        groups += [on_fig4_9("native", parts), on_rub(effort.rub_s, missing), on_ring(effort.ring_s, missing)]
    else:
        missing["native"] = "ziglang is not installed (extra: native)"
    say("taking turns")
    times = take_turns({name: one for group in groups for name, one in group.items()}, effort.rounds)
    flavour: Flavour = "native" if native else "python"
    say("measuring how cost grows")
    growth = {
        "simulated_time": scaling.over_time(flavour, effort.durations_s, effort.scaling_rounds),
        "sites": scaling.over_sites(flavour, effort.ring_s, effort.scaling_rounds),
        "variables": scaling.over_variables(flavour, effort.rub_s, effort.scaling_rounds),
    }
    say("measuring memory")
    memory = scaling.memory(flavour, effort.memory_s)
    say("comparing contact laws")
    contact = contact_cost.compare(effort.contact_repeats)
    return {
        "ratios": {name: ratio(times, above, below) for name, (above, below, _) in RATIOS.items()},
        "real_time_factor": {
            name: cases.STEP / median(times[name]) if name in times else None
            for name in ("native", "python", "native_plain", "python_plain", "floor")
        },
        "environment": environment(),
        "siconos_reduced_over_native": ratio(times, *REDUCED),
        "spread": {name: _extremes(ratios(times, above, below)) for name, (above, below, _) in RATIOS.items()},
        "step_us": {name: [1e6 * t for t in (median(each), min(each), max(each))] for name, each in times.items()},
        "floor_us": {part: 1e6 * min(each) for part, each in parts.items()} if native else None,
        "linearity": growth,
        "memory": memory,
        "contact": contact,
        "missing": missing,
        "rounds": effort.rounds,
    }


def _extremes(values: Sequence[float]) -> list[float] | None:
    return [min(values), max(values)] if values else None
