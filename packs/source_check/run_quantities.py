"""Quantities of a run; each is a function of its signals that returns a number in SI units, a text, or None.

A window from `begin` to `end` is given in cycles of the initial speed; by default, it covers the run from cycle 0.
Quantities of a thinned record are those of its steps (see `thinned.judged`).
"""

from __future__ import annotations

import json
from typing import Annotated

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.results import contact_forces, contact_history
from amb_cosim.results.orbits import When, radius, settled_amplitude, support
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import cycles, displacements, parameters, signal, speed
from amb_cosim.results.thinned import judged
from array_types import Array, Bools

HERTZ = 2.0 * np.pi  # rad/s
BOUNCE = 0.1  # cycles; a break of the contact that is shorter is a bounce


def contact_force(run: Signals, site: str, begin: float = 0.0, end: float = np.inf) -> Annotated[float | None, "N"]:
    """Return the largest contact force at a site (N): the largest 1 ms mean of the normal force, including impacts."""
    return contact_forces.largest_averaged_force(run, site, begin, end)


def peak_force(run: Signals, site: str, begin: float = 0.0, end: float = np.inf) -> Annotated[float | None, "N"]:
    """Return the largest force between impacts at a site (N), including forces within steps but not impact impulses."""
    return contact_forces.peak_force(run, site, begin, end)


def contact_share(
    run: Signals, states: str, begin: float | None = None, end: float | None = None
) -> Annotated[float | None, "1"]:
    """Return the share (1) of the time that the run is in the named contact states, such as `none, both`.

    By default, the time extends from the step to its removal, or to the end of the run.
    """
    run = judged(run)
    step, removal = contact_history.loaded_interval(run)
    state = signal(run, "contact_state")
    within = _window(run, step if begin is None else begin, removal if end is None else end)
    return None if state is None or not within.any() else float(np.mean(_is_in(run, states)[within]))


def longest_spell(run: Signals, states: str, begin: float = 0.0, end: float = np.inf) -> Annotated[float | None, "1"]:
    """Return the longest time (cycles) in the named contact states without a break of more than a tenth of a cycle."""
    run = judged(run)
    if signal(run, "contact_state") is None:
        return None
    spells = _spells(cycles(run), _is_in(run, states) & _window(run, begin, end))
    return max((last - first for first, last in spells), default=0.0)


def first_contact(run: Signals, since: float = 0.0) -> Annotated[float | None, "1"]:
    """Return the cycle of the first sample in contact at or after cycle 0, relative to `since`."""
    first = contact_history.contact_cycles(run)[0]
    return None if first is None else first - since


def second_site_after(run: Signals) -> Annotated[float | None, "1"]:
    """Return the cycles between the first contacts at the two retainers touched first; None if fewer are touched."""
    run = judged(run)
    state, from_0 = signal(run, "contact_state"), cycles(run) >= 0.0
    if state is None:
        return None
    at_site = [from_0 & (np.asarray(state, int) >> k & 1 > 0) for k in range(len(places(run).bearings))]
    first = sorted(float(cycles(run)[np.argmax(touching)]) for touching in at_site if touching.any())
    return first[1] - first[0] if len(first) > 1 else None


def last_contact(run: Signals, since: float = 0.0) -> Annotated[float | None, "1"]:
    """Return the cycle of the last sample in contact, relative to `since`; 0 without contact after `since`."""
    last = contact_history.contact_cycles(run)[1]
    return 0.0 if last is None else max(0.0, last - since)


def contact_duration(run: Signals) -> Annotated[float | None, "1"]:
    """Return the number of cycles from the first to the last contact; 0 without contact."""
    first, last = contact_history.contact_cycles(run)
    return 0.0 if first is None or last is None else last - first


def first_spell(
    run: Signals, bounce: float = BOUNCE, states: str = "", begin: float = 0.0
) -> Annotated[float | None, "1"]:
    """Return the duration (cycles) of the first contact after cycle `begin`, in the named states or in any state.

    A break longer than `bounce` (cycles) ends the contact.
    """
    run = judged(run)
    inside = _is_in(run, states) if states else _is_in_any(run)
    spells = _spells(cycles(run), inside & _window(run, begin, np.inf), bounce)
    return spells[0][1] - spells[0][0] if spells else None


def first_site(run: Signals, begin: float = 0.0) -> str:
    """Return the name of the retainer that is touched first, or `both` or `none`."""
    run = judged(run)
    touching = _is_in_any(run) & _window(run, begin, np.inf)
    state = signal(run, "contact_state")
    if state is None or not touching.any():
        return "none"
    return _states(run)[int(state[np.argmax(touching)])]


def sites_touched(run: Signals, begin: float = 0.0, end: float = np.inf) -> str:
    """Return the names of the touched retainers, joined by `and`, or `none`."""
    touched = [name_label(site) for site in places(run).retainers if (peak_force(run, site, begin, end) or 0.0) > 0.0]
    return " and ".join(touched) or "none"


def site_of_largest_force(run: Signals, begin: float = 0.0, end: float = np.inf) -> str | None:
    """Return the site (a retainer or any other) with the largest normal contact force, if any."""
    forces = {name_label(site): peak_force(run, site, begin, end) or 0.0 for site in places(run).sites}
    return max(forces, key=lambda site: forces[site]) if any(forces.values()) else None


def states_seen(run: Signals, begin: float = 0.0, end: float = np.inf) -> str:
    """Return all contact states that occur in a window, in the order of their numbers."""
    run = judged(run)
    state = signal(run, "contact_state")
    within = _window(run, begin, end)
    seen = [] if state is None else sorted({int(value) for value in state[within]})
    return ", ".join(_states(run)[value] for value in seen)


def outcome(run: Signals) -> str | None:
    """Return the outcome of the step, such as `prevented`, `recovered`, `landed`, `rolled` or `trapped`."""
    return contact_history.recovery(judged(run))


def rolling_from(run: Signals, since: float = 0.0) -> Annotated[float | None, "1"]:
    """Return the cycle, relative to `since`, from which the rotor rolls on a site for at least one turn of whirl."""
    rolling = contact_history.rolling_from(run)
    return None if rolling is None else rolling - since


def contact_to_rolling(run: Signals) -> Annotated[float | None, "s"]:
    """Return the time (s) from the first contact to the beginning of rolling."""
    first, rolling = contact_history.contact_cycles(run)[0], contact_history.rolling_from(run)
    return None if first is None or rolling is None else (rolling - first) * float(run.attrs["period_s"])


def whirl_at_end(run: Signals, site: str) -> Annotated[float | None, "rad/s"]:
    """Return the whirl speed (rad/s) at a site at the end of the run."""
    return contact_history.whirl_at_the_end(run, site)


def rolls_at_end(run: Signals, site: str = "") -> bool:
    """Return whether the rotor rolls on `site`, or by default on any site, at the end of the run."""
    run = judged(run)
    modes = [signal(run, f"{item}.mode") for item in ([site] if site else places(run).sites)]
    return any(mode is not None and int(mode[-1]) == contact_history.ROLLING for mode in modes)


def largest_radius(run: Signals, bearing: str, begin: float = 0.0, end: float = np.inf) -> Annotated[float | None, "1"]:
    """Return the largest radial displacement in a bearing's retainer, divided by the clearance (1)."""
    run = judged(run)
    values = radius(run, support(run, bearing))
    within = _window(run, begin, end)
    return None if values is None or not within.any() else float(values[within].max()) / _clearance(run, bearing)


def orbit_amplitude(run: Signals, bearing: str, when: When) -> Annotated[float | None, "m"]:
    """Return the synchronous amplitude (m) at a bearing `before` the step or ROLAC's start, or at the `end`."""
    run = judged(run)
    return settled_amplitude(run, displacements(run, f"{bearing}.x", f"{bearing}.y"), when)


def amplitude_left(run: Signals, bearing: str) -> Annotated[float | None, "1"]:
    """Return the ratio (1) of the final synchronous amplitude at a bearing to that before the step or ROLAC's start."""
    before, end = orbit_amplitude(run, bearing, "before"), orbit_amplitude(run, bearing, "end")
    return None if not before or end is None else end / before


def sensor_amplitude(run: Signals, x: str, y: str, when: When) -> Annotated[float | None, "m"]:
    """Return the synchronous amplitude (m) in the plane of two sensors, at the times that `orbit_amplitude` uses."""
    run = judged(run)
    return settled_amplitude(run, displacements(run, x, y), when)


def bearings_that_calm(run: Signals) -> str:
    """Return the bearings whose synchronous amplitude is smaller at the end than before the step or ROLAC's start."""
    calm = []
    for bearing in places(run).bearings:
        before, end = orbit_amplitude(run, bearing, "before"), orbit_amplitude(run, bearing, "end")
        if before is not None and end is not None and end < before:
            calm.append(name_label(bearing))
    return " and ".join(calm) or "none"


def speed_of_largest_radius(
    run: Signals, bearing: str, lowest: float, highest: float
) -> Annotated[float | None, "rad/s"]:
    """Return the spin speed (rad/s), in a range (Hz), at which the orbit at a bearing is largest before any contact."""
    run = judged(run)
    values, Omega = radius(run, bearing), speed(run)
    if values is None:
        return None
    first, _ = contact_history.contact_cycles(run)
    within = _window(run, 0.0, np.inf if first is None else first)
    within &= (Omega >= lowest * HERTZ) & (Omega <= highest * HERTZ)
    if not within.any():
        return None
    return float(Omega[within][np.argmax(values[within])])


def _window(run: Signals, begin: float, end: float) -> Bools:
    return np.asarray((cycles(run) >= max(begin, 0.0)) & (cycles(run) < end))


def _states(run: Signals) -> tuple[str, ...]:
    return places(run).contact_states


def _is_in(run: Signals, states: str) -> Bools:
    names = [name.strip() for name in states.split(",")]
    unknown = [name for name in names if name not in _states(run)]
    if unknown:
        raise ValueError(f"contact state {unknown[0]!r} is not allowed; it must be one of {', '.join(_states(run))}")
    return np.isin(np.asarray(signal(run, "contact_state")), [_states(run).index(name) for name in names])


def _is_in_any(run: Signals) -> Bools:
    state = signal(run, "contact_state")
    return np.zeros(run.sizes["time"], bool) if state is None else np.asarray(state > 0)


def _spells(when: Array, inside: Bools, bounce: float = BOUNCE) -> list[tuple[float, float]]:
    """Return begin and end (cycles) of intervals in which `inside` is true; breaks up to `bounce` do not count."""
    spells: list[tuple[float, float]] = []
    for cycle in when[inside].tolist():
        if spells and cycle - spells[-1][1] <= bounce:
            spells[-1] = (spells[-1][0], cycle)
        else:
            spells.append((cycle, cycle))
    return spells


def _clearance(run: Signals, bearing: str) -> float:
    site = places(run).bearings[bearing]
    return float(parameters(run)[f"{site}.clearance"])


def parameter(run: Signals, component: str, name: str) -> float | None:
    """Return the value of a component's parameter, in the unit of the parameter."""
    value = json.loads(run.attrs["parameters"]).get(component, {}).get(name)
    return None if value is None else float(value)
