"""Conditions that end a run early: a signal has been above or below a limit for a certain time.

They are checked at every communication point, with the values recorded there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.grid.time_grid import TimeGrid, nearest_point
from amb_cosim.cosim.system.values import Raw, convert
from array_types import Array, Indices


@dataclass(frozen=True)
class StopCondition:
    """Ends the run when `variable` has been `above` or `below` a limit for `hold` (s) without a break.

    One of `above` and `below` is None. The condition is checked from `begin` (s) or, by default, from the beginning of
    the run; with a `hold` of 0, a single point is sufficient.
    """

    variable: str
    above: Raw | None
    below: Raw | None
    hold: float = 0.0
    begin: float | None = None

    def __post_init__(self) -> None:
        if (self.above is None) == (self.below is None):
            raise ValueError(f"stop on {self.variable} must set either 'above' or 'below'")

    def on_grid(self, port: Port, grid: TimeGrid, beginning: int = 0) -> Condition:
        """Convert the condition to the unit of its variable and to communication steps, from point `beginning`."""
        side, raw = ("below", self.below) if self.above is None else ("above", self.above)
        limit = convert(raw or 0.0, port, f"stop: {self.variable} {side}")
        first = beginning if self.begin is None else grid.nearest("from_time of stop", self.begin)
        hold = nearest_point("hold_time of stop", self.hold, grid.step_size)
        text = f"{self.variable} {side} {limit:.9g}{port.display_unit}"
        text += f" for {hold * grid.step_size:.9g} s" if hold else ""
        return Condition(self.variable, side == "above", limit, first, hold, text)


class Condition(NamedTuple):
    """A signal has been above (or below) a limit for `hold` steps, checked from point `first`; `text` describes it."""

    signal: str
    above: bool
    limit: float
    first: int
    hold: int
    text: str


class Conditions(NamedTuple):
    """Conditions as arrays, met if sign * value > sign * limit at all points from `since` to `since` + `hold`."""

    positions: Indices
    signs: Array
    limits: Array
    since: Indices
    hold: Indices


class Stopped(Exception):
    """The condition with this index is met at this communication point."""

    def __init__(self, index: int, point: int) -> None:
        super().__init__(f"condition {index} is met at point {point}")
        self.index = index
        self.point = point


class StopObserver:
    """An observer that raises `Stopped` at the first point at which a condition is met.

    `positions` are the positions of the conditions' signals in the value array. The compiled loop does the same with
    the arrays `conditions`.
    """

    def __init__(self, conditions: Sequence[Condition] = (), positions: Sequence[int] = ()) -> None:
        self.conditions = Conditions(
            positions=np.array(positions, np.intp),
            signs=np.array([1.0 if c.above else -1.0 for c in conditions], np.float64),
            limits=np.array([c.limit for c in conditions], np.float64),
            since=np.array([c.first for c in conditions], np.intp),
            hold=np.array([c.hold for c in conditions], np.intp),
        )

    def __call__(self, n: int, values: Array) -> None:
        for k, (position, sign, limit, since, hold) in enumerate(zip(*self.conditions, strict=True)):
            if n < since:
                continue
            if not sign * values[position] > sign * limit:
                self.conditions.since[k] = n + 1
            elif n - since >= hold:
                raise Stopped(k, n)
