"""Robustness of a pack's outcomes, which `amb-cosim report --robustness` computes and saves in `robustness.toml`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

import tomli_w
from pydantic import Field

from amb_cosim.cosim.system.tables import Table
from amb_files.atomic import write_file
from amb_files.packs import packs
from amb_files.toml import read_toml, validate

FILE = "robustness.toml"
HEAD = """\
# Outcomes, and what flips them: H identified in the sampled loop, 1 % more and less of K_b, C_b, alpha, clearances and
# unbalances, one at a time. If magnets lose their power, also 20 % of friction, 0.1 of restitution, 1 % of mounts and
# races, and 32 phases of the loss. Written by `amb-cosim report --robustness --pack {pack}`.

"""


class StoredOutcome(Table):
    """Outcome of a run, outcomes of variations that end differently, by change, and decisive quantities not varied."""

    outcome: str
    flips: dict[str, str] = Field(default={})
    untested: list[str] = Field(default=[])

    @property
    def verdict(self) -> str:
        """The verdict of `Robustness`, of which only an undecided outcome of the run itself is stored."""
        if self.flips:
            return "fragile"
        return "undecided" if self.outcome.startswith("undecided") else "robust in part" if self.untested else "robust"

    @property
    def text(self) -> str:
        """The verdict, and the changes that flip the outcome."""
        flips = "; ".join(f"{changed}: {outcome}" for changed, outcome in self.flips.items())
        if flips:
            return f"fragile ({flips})"
        return f"{self.verdict} ({', '.join(self.untested)} not varied)" if self.untested else self.verdict


@cache
def load_robustness(pack: str) -> Mapping[str, StoredOutcome]:
    """Return the stored robustness of a pack's runs, by the name of a scenario or of one of the statements' `sources`.

    Raises
    ------
    ValueError
        If the file is malformed.
    """
    file = packs()[pack] / FILE
    if not file.is_file():
        return {}
    what = f"{FILE} of pack {pack}"
    return {name: validate(data, StoredOutcome, f"{what}, {name}") for name, data in read_toml(file, what).items()}


def stored_outcomes() -> dict[str, StoredOutcome]:
    """Return the stored robustness of all packs' runs, by name."""
    return {name: item for pack in packs() for name, item in load_robustness(pack).items()}


def write_robustness(pack: str, outcomes: Mapping[str, StoredOutcome]) -> Path:
    """Add outcomes to the file of a pack, sorted by name; return the path of the file."""
    file = packs()[pack] / FILE
    merged = {**load_robustness(pack), **outcomes}
    data = {name: merged[name].model_dump(exclude_defaults=True) for name in sorted(merged)}
    write_file(file, HEAD.format(pack=pack) + tomli_w.dumps(data))
    load_robustness.cache_clear()
    return file
