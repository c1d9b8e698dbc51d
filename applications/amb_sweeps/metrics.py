"""Key values of a run as numbers, for maps: contact, forces and orbits of the summary."""

from __future__ import annotations

import math

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results import contact_forces, contact_history, stability
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.contact_history import Recovery
from amb_cosim.results.orbits import orbit_largest
from amb_cosim.results.places import RotorPlaces, places
from amb_cosim.results.thinned import judged
from amb_cosim.results.touchdown import landing_whirl, touchdown

KEY_VALUES = {  # unit and, unless the name says it, description
    "contact": ("1", "1 if the rotor touched at any time from cycle 0 on"),
    "recovered": (
        "1",
        "1 if stable and free of contact for the last five cycles; NaN: neither disturbance nor contact",
    ),
    "rolling": ("1", "1 if the rotor rolled on a site through a full whirl revolution or more"),
    "contact_share": ("1", "Fraction of time in contact, from disturbance to relief"),
    "averaged_contact_force": ("N", ""),
    "peak_contact_force": ("N", ""),
    "peak_impulse": ("N s", "Largest normal impulse of the impacts within a step"),
    "orbit_largest": ("mm", ""),
    "rolling_from": ("cycle", ""),
    "last_contact": ("cycle", ""),
    "whirl_number": ("1", "Net backward turns of a landing about a site, at most; NaN: no landing"),
    "whirl_decided": (
        "1",
        "1 if a landing whirls, through 10 turns, or will not; 0 if the run ends before this is decided",
    ),
    "contact_time": ("s", "Time in contact after the release"),
    "heat": ("J", "Heat of friction, race drag and impacts"),
    "temperature": ("K", "Largest temperature; NaN without a heat capacity"),
}


def needed(places: RotorPlaces) -> tuple[str, ...]:
    """Return patterns of the variables that the key values need."""
    names = ("f_n*", "impulse", "mode", "whirl_speed", "race_speed", "heat", "temperature")
    site_variables = (f"{PLANT}.{site}.{name}" for site in places.contacts for name in names)
    displacements = (f"{PLANT}.{place}.[xy]" for place in (*places.bearings, *places.apart))
    return (f"{PLANT}.contact_state", *site_variables, *displacements, *stability.needed())


def evaluate(signals: Signals) -> tuple[Recovery | None, dict[str, float]]:
    """Return the outcome of a run, and its key values from cycle 0 on, with NaN for missing values.

    `contact`, `recovered` and `rolling` are 1 or 0. As in a `Summary`, `recovered` is 1 also if contact was prevented,
    and missing for a run with neither a disturbance nor contact. `contact_share` is the fraction of the time between
    disturbance and relief during which any site is in contact. Values of a site or bearing have its name as a suffix,
    as in `peak_contact_force.seal`; a value without a suffix is the largest of all sites or bearings.
    """
    whirl, fall = landing_whirl(signals), None
    if whirl is not None:
        fall = touchdown(signals)
    signals = judged(signals)
    _, last = contact_history.contact_cycles(signals)
    rolls = contact_history.rolling_from(signals)
    free, recovery = contact_history.freed_after(signals, last)
    sites = places(signals).contacts
    values = {
        "contact": _nan(None if free is None else last is not None),
        "recovered": _nan(None if last is None and recovery is None else free),
        "rolling": float(rolls is not None),
        "contact_share": _nan(contact_history.share_in_contact(signals)),
        "rolling_from": _nan(rolls),
        "last_contact": _nan(last),
    }
    if whirl is not None:
        values |= {"whirl_number": whirl[0], "whirl_decided": float(whirl[1])}
    at_places = {
        "averaged_contact_force": {site: contact_forces.largest_averaged_force(signals, site) for site in sites},
        "peak_contact_force": {site: contact_forces.peak_force(signals, site) for site in sites},
        "peak_impulse": {site: contact_history.peak(signals, f"{site}.impulse") for site in sites},
        "orbit_largest": orbit_largest(signals),
    }
    if fall is not None:
        retainers = fall.retainers
        at_places |= {
            "contact_time": {site: _sum(item.sliding, item.rolling) for site, item in retainers.items()},
            "heat": {site: item.heat for site, item in retainers.items()},
            "temperature": {site: item.temperature for site, item in retainers.items()},
        }
    for name, by_place in at_places.items():
        numbers = [_nan(value) for value in by_place.values()]
        values[name] = max((v for v in numbers if not math.isnan(v)), default=math.nan)
        values |= {f"{name}.{place}": v for place, v in zip(by_place, numbers, strict=True)}
    return recovery, values


def outcome_of(outcome: Outcome, recovery: Recovery | None) -> tuple[str, str]:
    """Return the outcome of a run, and the reason if it ended early.

    If the scenario has a disturbance: `prevented` or `recovered`. In any scenario: `rolled`, `trapped`, `undecided`,
    `landed`, `unstable`, `stator`. Otherwise: `completed`, `stopped` or `failed`.
    """
    if outcome.failure is not None:
        return "failed", outcome.failure
    return recovery or outcome.status, outcome.stopped or ""


def _sum(first: float | None, second: float | None) -> float | None:
    return None if first is None or second is None else first + second


def _nan(value: float | None) -> float:
    return math.nan if value is None else float(value)
