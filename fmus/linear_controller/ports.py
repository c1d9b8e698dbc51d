"""Ports of a linear controller: measured signals, demands, and the number of states."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

MAX_PORTS = 64  # signals, and demands: fault codes of the latter stay below 100
MAX_STATES = 1000

_NAME = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)


@dataclass(frozen=True)
class Ports:
    """Names of the measured signals (columns of the matrices) and of the demands (rows), in order.

    Raises
    ------
    ValueError
        If there are no signals or no demands, if there are too many, or if a name is not valid for a variable or occurs
        twice.
    """

    signals: tuple[str, ...]
    demands: tuple[str, ...]
    n_states: int

    def __post_init__(self) -> None:
        _check_names("measured signals", self.signals)
        _check_names("demands", self.demands)
        both = sorted(set(self.signals) & set(self.demands))
        if both:
            raise ValueError(f"{', '.join(both)} is a measured signal and a demand; names must differ")
        if not 0 <= self.n_states <= MAX_STATES:
            raise ValueError(f"{self.n_states} states is not allowed; there must be 0 to {MAX_STATES}")

    def layout(self) -> dict[str, Any]:
        """Return the names and the number of states as JSON types, for storage in an FMU."""
        return asdict(self)


def _check_names(kind: str, names: Sequence[str]) -> None:
    if not 1 <= len(names) <= MAX_PORTS:
        raise ValueError(f"{len(names)} {kind} is not allowed; there must be 1 to {MAX_PORTS}")
    for name in names:
        if not _NAME.fullmatch(name):
            raise ValueError(
                f"{name!r} is not allowed as a name of {kind}; it must consist of letters, digits and _, with dots "
                f"between them, such as mb1.x"
            )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"{', '.join(twice)} occurs twice among the {kind}; names must differ")
