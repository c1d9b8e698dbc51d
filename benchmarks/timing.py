"""Time several candidates in turn, form ratios, and describe the machine."""

from __future__ import annotations

import importlib.metadata
import os
import platform
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from statistics import median
from typing import Any

from llvmlite.binding import get_host_cpu_name

from amb_cosim.cosim.run.dataset import git_revision

Candidate = Callable[[], float]
Times = Mapping[str, list[float]]

_PACKAGES = ("numba", "numpy", "fmpy", "pythonfmu", "ziglang", "ecospy", "libcosimpy")


def interleaved_times(candidates: Mapping[str, Candidate], rounds: int) -> dict[str, list[float]]:
    """Run the candidates in turn, A B C A B C ..., and return the times (s) of each.

    Thus a disturbance of the machine affects all of them. A first round, in which code is loaded and compiled, does not
    count.
    """
    times: dict[str, list[float]] = {name: [] for name in candidates}
    for count in range(rounds + 1):
        for name, candidate in candidates.items():
            seconds = candidate()
            if count:
                times[name].append(seconds)
    return times


def ratio(times: Times, above: str, below: str) -> float | None:
    """Return the median of the ratios within a round; None if either candidate is missing."""
    both = ratios(times, above, below)
    return median(both) if both else None


def ratios(times: Times, above: str, below: str) -> list[float]:
    """Return the ratio in each round."""
    return [a / b for a, b in zip(times.get(above, ()), times.get(below, ()), strict=False)]


def environment() -> dict[str, Any]:
    """Return date, machine and versions."""
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "system": platform.platform(),
        "machine": platform.machine(),
        "processor": get_host_cpu_name(),
        "cores": os.cpu_count(),
        "load_average": [round(load, 2) for load in os.getloadavg()] if hasattr(os, "getloadavg") else None,
        "python": platform.python_version(),
        "versions": {name: _version(name) for name in _PACKAGES},
        "git_revision": git_revision(),
    }


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
