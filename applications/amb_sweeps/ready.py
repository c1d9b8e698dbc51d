"""Named sweeps of the packs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import Field

from amb_cosim.cosim.system.tables import Table, Value
from amb_files.toml import read_toml, validate


class NamedSweep(Table):
    """A scenario and its variations: arguments of `amb_cosim.sweep`, and a one-line description."""

    description: str = ""
    scenario: str
    vary: dict[str, Any] = Field(min_length=1)
    sample: str | None = None
    boundary: str | None = None
    certainty: float | None = None
    until: Value | None = None

    @property
    def options(self) -> dict[str, Any]:
        """All arguments other than the scenario, by name."""
        return self.model_dump(exclude={"description", "scenario"}, exclude_none=True)


def read_sweep(name: str, file: Path) -> NamedSweep:
    """Read the sweep of a pack from its file; raises ValueError if the file cannot be read or is invalid."""
    what = f"sweep {name}"
    return validate(read_toml(file, what), NamedSweep, what)
