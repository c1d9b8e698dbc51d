"""Entries of `amb-cosim list`: ready sweeps, and the outcomes of scenarios with their robustness."""

from __future__ import annotations

from collections.abc import Iterator

from amb_cosim.commands.listing import ListedItem, readable
from amb_files.packs import files_of
from amb_sweeps.ready import read_sweep
from amb_sweeps.stored_robustness import stored_outcomes


def entries() -> Iterator[ListedItem]:
    """Yield the ready sweeps of all packs; an invalid one is skipped with a warning."""
    for name, file in files_of("sweeps").items():
        if (ready := readable(file, read_sweep, name, file)) is not None:
            yield ListedItem(name, file, "sweeps", ready.description, "", f"sweep of {ready.scenario}", "sweep")


def outcomes() -> dict[str, str]:
    """Return the outcomes of scenarios, by name, and how robust they are."""
    return {name: f"{item.outcome}; {item.verdict}" for name, item in stored_outcomes().items()}
