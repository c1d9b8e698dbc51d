"""The part of a run that its figures enlarge: the first impacts of a fall, or the large forces of a short contact."""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.contact_history import in_contact
from amb_cosim.results.signal_arrays import at_every_step
from amb_cosim.results.touchdown import touchdown
from array_types import Array

FIRST = 0.05  # s, of a fall that is enlarged
LONG, BEFORE = (
    0.025,
    0.005,
)  # s, a longer fall is enlarged from this time before its first touch on
LARGE = 0.1  # of the largest force
SMALL_PART = 0.15  # of the time, in which large forces are enlarged
MANY = 40  # contacts, from which the first part of the time after the first is enlarged

Interval = tuple[float, float]


def first_impacts(dataset: Signals) -> Interval | None:
    """Return the limits (s) of the 50 ms with the first impacts of a fall; None for a run without a fall.

    If no fall precedes the contact, as in a shock, the interval begins shortly before the first touch.
    """
    fall, steps = touchdown(dataset), at_every_step(dataset)
    contact, times = in_contact(steps), steps["time"].values
    if fall is None or contact is None:
        return None
    touch = float(times[np.argmax(contact & (times >= fall.release))])
    begin = fall.release if touch - fall.release < LONG else touch
    begin = max(min(begin, touch - BEFORE), float(times[0]))
    return begin, min(begin + FIRST, float(times[-1]))


def large_forces(times: Array, forces: list[Array]) -> Interval | None:
    """Return the limits (s) of the time with large forces, if it is only a small part of the run.

    Forces above the share `LARGE` of the largest force count as large. If the large forces last longer, the interval
    contains the first contacts, provided that the run has at least `MANY` contacts.
    """
    force = np.nanmax(np.abs(np.nan_to_num(forces)), axis=0) if forces else np.zeros(len(times))
    large = times[force > LARGE * force.max(initial=0.0)]
    first, last = (float(large[0]), float(large[-1])) if len(large) > 1 else (0.0, 0.0)
    if len(large) < 2 or last - first > SMALL_PART * (times[-1] - times[0]):
        if np.count_nonzero((force[1:] > 0.0) & (force[:-1] == 0.0)) < MANY:
            return None
        last = first + 0.04 * float(times[-1] - first)
    width = max(last - first, 20.0 * float(times[1] - times[0]))
    return max(first - 0.5 * width, float(times[0])), min(last + 1.5 * width, float(times[-1]))
