"""Positions of a system's values in a single flat array."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from array_types import Array, Indices


@dataclass(frozen=True)
class SignalMap:
    """Positions of all signals in the value array, and the inputs that read them.

    Parameters
    ----------
    names
        Name of each position of `values`.
    n_exogenous
        Number of exogenous inputs, which have the first positions.
    sources
        For each component, the positions from which its inputs are gathered.
    depends_on
        For each position, the positions that reach it without delay.
    weights
        For each component and each of its inputs, the weight of the value at the end of a step; see `iteration`.
    inputs, outputs
        Names of the exchanged inputs and outputs of each component.
    """

    names: tuple[str, ...]
    n_exogenous: int
    sources: tuple[Indices, ...]
    depends_on: tuple[tuple[int, ...], ...]
    weights: tuple[Array, ...] = ()
    inputs: Mapping[str, Sequence[str]] = field(default_factory=dict)
    outputs: Mapping[str, Sequence[str]] = field(default_factory=dict)
