"""Where the values of a system stand in one flat array."""

from __future__ import annotations

from dataclasses import dataclass

from amb_cosim.cosim.basics.schedules import Array, IntArray


@dataclass(frozen=True)
class SignalMap:
    """Positions of all signals in the value array, and which inputs read them.

    Parameters
    ----------
    names
        Name of each position of `values`.
    n_exogenous
        How many positions, from the first, hold exogenous inputs.
    sources
        For each component, the positions that its inputs are gathered from.
    depends_on
        For each position, the positions that reach it without delay.
    weights
        For each component, how much the value at the end of a step counts for each input; see `iteration`.
    """

    names: tuple[str, ...]
    n_exogenous: int
    sources: tuple[IntArray, ...]
    depends_on: tuple[tuple[int, ...], ...]
    weights: tuple[Array, ...] = ()
