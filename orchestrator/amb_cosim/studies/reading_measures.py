"""What the thesis states of a run, measured on ours: each function takes a data set and returns a number or a text.

Times are in cycles, amplitudes in mm, forces in N. None stands for what did not happen.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from amb_cosim import contact_history
from amb_cosim.contact_history import FREE, contact_cycles, loaded_interval, rolling_from
from amb_cosim.cosim.signals import Signals
from amb_cosim.orbits import settled_amplitudes, synchronous_amplitude
from amb_cosim.series import change, cycles, signal

Found = float | str | None
RETAINERS = ("rb1", "rb2")
BOTH = 3  # of contact_state
SENSORS = {"end1": ("s7", "s8"), "end2": ("s1", "s2")}  # at the shaft's ends
MOST = math.log(10.0)  # what a number can add to the misfit


def misfit(found: Found, wanted: float | str, kind: str = "value") -> float:
    """Return how far a finding is from a statement; 0 is agreement.

    A number adds |ln(found / wanted)|, at most ln 10, and one that may be smaller (`at_most`) or larger (`at_least`)
    adds nothing if it is. A text that differs adds 1, as much as a factor of e.
    """
    if isinstance(wanted, str):
        return float(found != wanted)
    if found is None or isinstance(found, str) or found <= 0.0:
        return 0.0 if kind == "at_most" and found == 0.0 else MOST
    distance = math.log(found / wanted)
    if kind != "value":
        distance = max(0.0, distance if kind == "at_most" else -distance)
    return min(abs(distance), MOST)


def first_site(dataset: Signals) -> str | None:
    """Return the retainer that is touched first."""
    first = {site: when for site in RETAINERS if (when := _first_contact(dataset, site)) is not None}
    return min(first, key=lambda site: first[site]) if first else None


def touched(dataset: Signals) -> str:
    """Return which retainers are touched: rb1, rb2, both or none."""
    sites = [site for site in RETAINERS if _first_contact(dataset, site) is not None]
    return "both" if len(sites) == len(RETAINERS) else (sites or ["none"])[0]


def recovery(dataset: Signals) -> str | None:
    """Return what the step led to: prevented, recovered or trapped."""
    return contact_history.recovery(dataset)


def peak(dataset: Signals, site: str) -> float | None:
    """Return the largest contact force (N)."""
    return contact_history.peak(dataset, f"{site}.f_n")


def settled(dataset: Signals, site: str) -> float | None:
    """Return the median contact force in the cycle before the removal (N)."""
    _, end = loaded_interval(dataset)
    force, cycle = signal(dataset, f"{site}.f_n"), cycles(dataset)
    within = (cycle >= end - 1.0) & (cycle < end)
    return None if force is None or not within.any() else float(np.median(force[within]))


def share(dataset: Signals, site: str) -> float | None:
    """Return the share of the time in contact from the first contact to the removal."""
    first, mode = _first_contact(dataset, site), signal(dataset, f"{site}.mode")
    if first is None or mode is None:
        return 0.0
    within = (cycles(dataset) >= first) & (cycles(dataset) < loaded_interval(dataset)[1])
    return float(np.mean(mode[within] != FREE))


def together(dataset: Signals) -> float | None:
    """Return for how many cycles between step and removal the rotor touches both retainers at once."""
    state, cycle = signal(dataset, "contact_state"), cycles(dataset)
    begin, end = loaded_interval(dataset)
    if state is None:
        return None
    within = (cycle >= begin) & (cycle < end) & (state == BOTH)
    return float(np.sum(np.diff(cycle, prepend=cycle[0])[within]))


def states(dataset: Signals) -> str | None:
    """Return `all` if the cycle from the first contact on has seen every contact state, else those that it has."""
    state, first = signal(dataset, "contact_state"), contact_cycles(dataset)[0]
    if state is None or first is None:
        return None
    within = (cycles(dataset) >= first) & (cycles(dataset) < first + 1.0)
    seen = sorted({int(value) for value in state[within]})
    return "all" if len(seen) == BOTH + 1 else ", ".join(map(str, seen))


def touched_after(dataset: Signals) -> float | None:
    """Return the cycles from the step to the first contact."""
    return _after(contact_cycles(dataset)[0], loaded_interval(dataset)[0])


def rolls_after(dataset: Signals) -> float | None:
    """Return the cycles from the step to the beginning of rolling."""
    return _after(rolling_from(dataset), loaded_interval(dataset)[0])


def joined_after(dataset: Signals) -> float | None:
    """Return the cycles from the first contact at one retainer to the first at the other."""
    first = [_first_contact(dataset, site) for site in RETAINERS]
    return None if first[0] is None or first[1] is None else abs(first[1] - first[0])


def after_removal(dataset: Signals) -> float | None:
    """Return the cycles from the removal to the last contact."""
    return _after(contact_cycles(dataset)[1], loaded_interval(dataset)[1])


def duration(dataset: Signals) -> float | None:
    """Return the cycles from the first to the last contact."""
    first, last = contact_cycles(dataset)
    return _after(last, first)


def amplitude(dataset: Signals, place: str, when: str) -> float | None:
    """Return the synchronous amplitude at a bearing or an end of the shaft `before` the change or at the `end` (mm)."""
    if place not in SENSORS:
        return settled_amplitudes(dataset)[when][place]
    x, y = (signal(dataset, name) for name in SENSORS[place])
    end = change(dataset) if when == "before" else float(cycles(dataset)[-1])
    if x is None or y is None or end is None:
        return None
    within = (cycles(dataset) > end - 1.0) & (cycles(dataset) <= end)
    return 1e3 * synchronous_amplitude(x[within], y[within], 2.0 * np.pi * cycles(dataset)[within])


def bearings(dataset: Signals) -> str:
    """Return at which bearings the synchronous amplitude falls: `both fall`, or those where it does."""
    fall = [
        mb
        for mb in ("mb1", "mb2")
        if (end := amplitude(dataset, mb, "end")) is not None
        and (before := amplitude(dataset, mb, "before")) is not None
        and end < before
    ]
    return "both fall" if len(fall) == len(RETAINERS) else ", ".join(fall) or "none falls"


def ends(dataset: Signals) -> float | None:
    """Return the largest radius at the shaft's ends from the step on (mm)."""
    after = cycles(dataset) >= loaded_interval(dataset)[0]
    pairs = [[signal(dataset, name) for name in pair] for pair in SENSORS.values()]
    radii = [np.hypot(x[after], y[after]).max() for x, y in pairs if x is not None and y is not None]
    return 1e3 * float(max(radii)) if radii else None


def _after(moment: float | None, start: float | None) -> float | None:
    return None if moment is None or start is None or math.isinf(start) else moment - start


def _first_contact(dataset: Signals, site: str) -> float | None:
    """Return the cycle of the first contact at a site from cycle 0 on."""
    touching: NDArray[np.bool_] = np.zeros(len(cycles(dataset)), bool)
    for name in ("mode", "impulse"):
        values = signal(dataset, f"{site}.{name}")
        if values is not None:
            touching |= values > 0
    when = cycles(dataset)[touching & (cycles(dataset) >= 0.0)]
    return float(when[0]) if len(when) else None


MEASURES: dict[str, Callable[..., Found]] = {
    f.__name__: f
    for f in (
        *(first_site, touched, recovery, peak, settled, share, together, states, touched_after, rolls_after),
        *(joined_after, after_removal, duration, amplitude, bearings, ends),
    )
}
