"""Times on the grid of a master with equal steps."""

from __future__ import annotations

import math
import sys
from typing import NamedTuple

import numpy as np

from array_types import Array, Indices

MOST_STEPS = 10**12  # of a run, which would take a month
ROUNDING = 1e-9  # relative, of times that are whole numbers of steps
NEAR_STEP = 1e-6  # of a step; times closer than this are the same
EPSILON = sys.float_info.epsilon


def in_steps(time: float, h: float, origin: float = 0.0) -> float:
    """Return the time since `origin` (s) in steps of h (s); whole and half numbers of steps are exact.

    Use this function for all quotients of times. Otherwise, 3 steps of 1e-4 s are 3.0000000000000004 steps, and the
    step nearest to 3.5 depends on the last bit. Times of 1.7e9 s (seconds since 1970) are rounded to 2.4e-7 s, and so
    are their differences.
    """
    rounding = 4.0 * EPSILON * max(abs(time), abs(origin)) / h if origin else 0.0
    time -= origin
    halves = 2.0 * time / h
    if not math.isfinite(halves):
        return halves
    whole = round(halves)
    return 0.5 * (whole if abs(halves - whole) <= max(NEAR_STEP, 8.0 * EPSILON * abs(whole), rounding) else halves)


class TimeGrid(NamedTuple):
    """Communication points t_n = t_0 + n h, except that the last step may be shorter.

    `start` is t_0. Unless `last` is None, the point with the number `last` is at the time `stop`, less than h after the
    previous point.
    """

    step_size: float
    start: float = 0.0
    last: int | None = None
    stop: float = 0.0

    def time(self, n: int) -> float:
        """Return the time of a point (s); it is not a sum of steps, in which rounding errors would accumulate."""
        return self.stop if n == self.last else self.start + n * self.step_size

    def is_at(self, n: int, time: float) -> bool:
        """Return whether a time (s) is the time of a point, within rounding."""
        return abs(time - self.time(n)) <= max(NEAR_STEP * self.step_size, 4.0 * EPSILON * abs(time))

    def times(self, points: Indices) -> Array:
        """Return the times of points (s)."""
        times = np.asarray(self.start + points * self.step_size, np.float64)
        times[points == self.last] = self.stop
        return times

    def position(self, n: int) -> float:
        """Return the time of point n after t_0 in steps: n, or less than n if the step before the point is shorter."""
        return in_steps(self.stop, self.step_size, self.start) if n == self.last else n

    def nearest(self, name: str, time: float) -> int:
        """Return the point nearest to a time (s); raises ValueError like `nearest_point`."""
        n = nearest_point(name, time, self.step_size, self.start)
        if self.last is None or n not in (self.last - 1, self.last):
            return n
        return min(self.last - 1, self.last, key=lambda point: abs(self.time(point) - time))


def nearest_point(name: str, time: float, h: float, start: float = 0.0) -> int:
    """Return the communication point nearest to a time (s), for communication steps of h (s) from `start` (s).

    Raises
    ------
    ValueError
        If it is not a time, or is more than `MOST_STEPS` steps away.
    """
    if not abs((time - start) / h) <= MOST_STEPS:
        limit = f"{MOST_STEPS * h:g} s ({MOST_STEPS:.0e} steps of {h:g} s)"
        raise ValueError(f"{name} = {time:g} s is not allowed; it must be within {limit}")
    return round(in_steps(time, h, start))


def nearest_steps(name: str, time: float, h: float) -> int:
    """Return the number of communication steps of h (s) nearest to a time (s); raises ValueError if it is zero."""
    if not 0.0 < time < math.inf:
        raise ValueError(f"{name} = {time:g} s is not allowed; it must be > 0 s")
    n = nearest_point(name, time, h)
    if n < 1:
        raise ValueError(f"{name} = {time:.12g} s is not allowed; it must be at least the communication step {h:g} s")
    return n


def is_on_grid(n: int, time: float, h: float) -> bool:
    """Return whether n communication steps of h (s) equal a time (s), within rounding."""
    return math.isclose(n * h, time, rel_tol=ROUNDING)


def whole_steps(name: str, time: float, h: float) -> int:
    """Return the number of communication steps of h (s) in a time (s); raises ValueError if it is not whole."""
    n = nearest_steps(name, time, h)
    if not is_on_grid(n, time, h):
        raise ValueError(
            f"{name} = {time:.12g} s is not allowed; it must be a whole multiple of the communication step {h:g} s"
        )
    return n
