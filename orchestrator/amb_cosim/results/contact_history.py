"""Contact of the rotor over a run, computed from its data set: peaks, contact states, recovery and rolling.

Every function returns None if the data set lacks the required variables.
"""

from __future__ import annotations

from functools import reduce
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.contact_forces import largest, peak_force, touches
from amb_cosim.results.places import places
from amb_cosim.results.power import power_lost_at
from amb_cosim.results.signal_arrays import at_every_step, cycles, signal, speed, speed_changes, turns
from amb_cosim.results.stability import ROUNDING, SOURCES, instability, last_change, too_short
from amb_cosim.results.stators import stator_touches
from array_types import Bools

RECOVERY_CYCLES = 5.0  # without contact, at least
FLIGHTS = 2.0  # longest flights between contacts, which this must be, too
TRAPPED_TURNS = 10.0  # from the last change to the end; most recoveries of the packs take less
ON_THE_GRID = 0.05  # turns by which this may be missed, since changes and ends are rounded to communication steps
STANDING = 1e-3  # share of the first speed below which the rotor makes no more turns
FREE, ROLLING = 0, 2  # values of a site's mode

Recovery = Literal["prevented", "recovered", "landed", "rolled", "trapped", "undecided", "unstable", "stator"]


def peak(dataset: Signals, name: str) -> float | None:
    """Return the largest value of a variable of the plant from cycle 0 on."""
    dataset = at_every_step(dataset)
    return largest(dataset, signal(dataset, name))


def touchable(dataset: Signals) -> list[str]:
    """Return the retainers and the other touched sites (without retainers, all sites), then the touched faces."""
    others, retainers = places(dataset).others, places(dataset).retainers
    touched = [site for site in others if peak_force(dataset, site) or peak(dataset, f"{site}.impulse")]
    faces = [face for face in places(dataset).faces if peak_force(dataset, face)]
    return [*retainers, *touched, *faces] if retainers else [*others, *faces]


def loaded_interval(dataset: Signals) -> tuple[float, float]:
    """Return the cycles of the disturbance (0 if there is none) and of the relief (infinity if there is none)."""
    return float(dataset.attrs.get("disturbance_cycle", 0.0)), float(dataset.attrs.get("relief_cycle", np.inf))


def contact_share(dataset: Signals) -> dict[str, float | None]:
    """Return the share of the time between disturbance and relief spent in each of `RotorPlaces.contact_states`."""
    states = _while_loaded(dataset, "contact_state")
    values = range(len(places(dataset).contact_states))
    return {str(k): None if states is None else float(np.mean(states == k)) for k in values}


def share_in_contact(dataset: Signals) -> float | None:
    """Return the share of the time between disturbance and relief during which the rotor is in contact at any site."""
    names = ("contact_state", *(f"{site}.mode" for site in places(dataset).contacts))
    recorded = [values != FREE for name in names if (values := _while_loaded(dataset, name)) is not None]
    return float(np.mean(reduce(np.logical_or, recorded))) if recorded else None


def site_share(dataset: Signals) -> dict[str, float | None]:
    """Return the share of the time between disturbance and relief during which the rotor is in contact at each site."""
    modes = {site: _while_loaded(dataset, f"{site}.mode") for site in touchable(dataset)}
    return {site: None if mode is None else float(np.mean(mode != FREE)) for site, mode in modes.items()}


def _while_loaded(dataset: Signals, name: str) -> NDArray[Any] | None:
    """Return a variable of the plant over the steps between disturbance and relief; None if there are none.

    A sample has the value at the end of its step, so that the first step ends after the disturbance.
    """
    dataset = at_every_step(dataset)
    begin, end = (cycle + ROUNDING for cycle in loaded_interval(dataset))
    values, within = signal(dataset, name), (cycles(dataset) > begin) & (cycles(dataset) <= end)
    return None if values is None or not within.any() else values[within]


def in_contact(dataset: Signals) -> Bools | None:
    """Return at which samples the rotor is in contact anywhere, or was in the step before."""
    state = signal(dataset, "contact_state")
    if state is None:
        return None
    return reduce(np.logical_or, (touches(dataset, site) for site in places(dataset).contacts), state != 0)


def contact_cycles(dataset: Signals) -> tuple[float | None, float | None]:
    """Return the cycles of the first and of the last sample in contact from cycle 0 on."""
    dataset = at_every_step(dataset)
    touching = in_contact(dataset)
    if touching is None:
        return None, None
    when = cycles(dataset)[touching & (cycles(dataset) >= 0.0)]
    return (float(when[0]), float(when[-1])) if len(when) else (None, None)


def recovered(dataset: Signals) -> bool | None:
    """Return whether the rotor is stable and at least five cycles have passed since its last contact.

    The result is also false if the run ends too early to decide (see `recovery`). A rotor that never touched has
    recovered. A rotor that touched after all magnets lost their power has not recovered, because nothing keeps it off
    its retainers.
    """
    return freed_after(dataset, contact_cycles(dataset)[1])[0]


def recovery(dataset: Signals) -> Recovery | None:
    """Return the outcome; None if the run ends without contact and had no disturbance, or contact was not recorded.

    `stator` means that the rotor has touched the stator of a magnetic bearing at any time. `unstable` means that it
    or its loop diverges without contact although magnets are energised (see `stability`). If neither applies and the
    rotor has not `recovered`, it has `rolled` if it is rolling at the end and has whirled through a turn since it began
    to roll, with or without power. Otherwise, it has `landed` on its retainers if its magnets have no power at the end,
    even if it bounces or floats between them. A rotor with energised magnets is `trapped` if contact outlasts what
    excites it:

        C > E - 1 cycle,    N(E) - N(L) >= 10 turns

    C is the cycle of the last contact, E the end of the run, N the number of turns, and L the last event or speed
    point, or cycle 0 if that is later. Any other outcome is `undecided`, because the run ends too early. It is
    `undecided` also if the magnets have lost their power after the last contact, or if the run is too short to show
    whether the rotor stays free (see `stability.too_short`). These outcomes apply with or without a disturbance. In the
    remaining cases, `prevented` means that there was no contact after the disturbance, and `recovered` means that
    contact has ended.
    """
    return freed_after(dataset, contact_cycles(dataset)[1])[1]


def freed_after(dataset: Signals, last: float | None) -> tuple[bool | None, Recovery | None]:
    """Return `recovered` and `recovery`; `last` is the cycle of the last contact, if any."""
    if signal(dataset, "contact_state") is None or not len(cycles(dataset)):
        return None, None
    disturbance, power_lost = dataset.attrs.get("disturbance_cycle"), power_lost_at(dataset)
    free = _is_free(dataset, last)
    if stator_touches(dataset):
        return free, "stator"
    if free and power_lost is None and instability(dataset, last):
        return False, "unstable"
    if falls_from(dataset, last) is not None or (free and power_lost is None and too_short(dataset, last)):
        return False, "undecided"
    free = free and (last is None or power_lost is None)
    if not free and rolls_at_the_end(dataset):
        return free, "rolled"
    if not free and power_lost is None:
        assert last is not None
        return free, "trapped" if _stays(dataset, last) else "undecided"
    if not free:
        return free, "landed"
    if disturbance is None:
        return free, None
    return free, "prevented" if last is None or last <= disturbance else "recovered"


def recovery_cycles(dataset: Signals) -> float:
    """Return the cycles without contact after which a rotor has recovered.

    These are `RECOVERY_CYCLES`, or `FLIGHTS` times the longest flight between two contacts since the last change: a
    rotor that turns fast and bounces slowly flies for many turns. Flights do not count if the speed changes or a
    component excites the rotor from outside its loop, since contacts then have other causes.
    """
    steps = at_every_step(dataset)
    touching = in_contact(steps)
    if touching is None or speed_changes(dataset) or SOURCES in dataset.attrs:
        return RECOVERY_CYCLES
    when = cycles(steps)[touching & (cycles(steps) >= last_change(dataset))]
    return max(RECOVERY_CYCLES, FLIGHTS * float(np.diff(when).max(initial=0.0)))


def _is_free(dataset: Signals, last: float | None) -> bool:
    """Return whether the rotor is free of contact at the end as a recovery requires; `last` as for `freed_after`."""
    return last is None or bool(cycles(dataset)[-1] - last >= recovery_cycles(dataset))


def is_supported(dataset: Signals) -> bool:
    """Return whether magnets with power support the rotor at the end, free of contact as a recovery requires."""
    if signal(dataset, "contact_state") is None or not len(cycles(dataset)) or not places(dataset).magnetic:
        return False
    return power_lost_at(dataset) is None and _is_free(dataset, contact_cycles(dataset)[1])


def falls_from(dataset: Signals, last: float | None) -> float | None:
    """Return the cycle since which no magnet has power, if the rotor touched before but not since."""
    power_lost = power_lost_at(dataset)
    return power_lost if last is not None and power_lost is not None and last < power_lost else None


def touches_at_the_end(dataset: Signals, last: float) -> bool:
    """Return whether the last contact, in cycle `last`, is within the last cycle of the run."""
    return bool(cycles(dataset)[-1] - last < 1.0)


def turns_since_change(dataset: Signals) -> float:
    """Return the turns since the last event, speed point or cycle 0, or the cycles if the rotor ends at rest."""
    cycle, Omega = cycles(dataset), speed(dataset)
    stands = abs(Omega[-1]) < STANDING * np.abs(Omega).max()
    turned = cycle if stands else turns(dataset)
    return float(turned[-1] - np.interp(last_change(dataset), cycle, turned))


def _stays(dataset: Signals, last: float) -> bool:
    """Return whether a rotor whose magnets are energised is trapped; `last` is the cycle of its last contact."""
    lasts = turns_since_change(dataset) >= TRAPPED_TURNS - ON_THE_GRID
    return touches_at_the_end(dataset, last) and lasts


def whirl_at_the_end(dataset: Signals, site: str) -> float | None:
    """Return the mean whirl speed (rad/s) in contact at a site in the last cycle; None if it is free at the end."""
    dataset = at_every_step(dataset)
    mode, whirl = signal(dataset, f"{site}.mode"), signal(dataset, f"{site}.whirl_speed")
    if mode is None or whirl is None or not len(mode) or mode[-1] == FREE:
        return None
    return float(np.mean(whirl[(mode != FREE) & (cycles(dataset) > cycles(dataset)[-1] - 1.0)]))


def rolling_from(dataset: Signals) -> float | None:
    """Return the first cycle from which the rotor rolls on a site without a break for at least a net turn of whirl."""
    return min((r.start for r in _rolled(dataset) if r.whirled >= 2.0 * np.pi), default=None)


def rolls_at_the_end(dataset: Signals) -> list[str]:
    """Return the sites on which the rotor is still rolling at the last step, after at least a net turn of whirl."""
    return [r.site for r in _rolled(dataset) if r.to_the_end and r.whirled >= 2.0 * np.pi]


def rolling_on_race_from(dataset: Signals) -> float | None:
    """Return the first cycle from which the rotor rolls with a turning race for at least one turn of the race.

    Meanwhile the rotor whirls by less than a turn, because it lies on the race or swings.
    """
    with_race = (r.start for r in _rolled(dataset) if r.whirled < 2.0 * np.pi <= r.race_turned)
    return min(with_race, default=None)


class _Rolling(NamedTuple):
    """A period of rolling at a site: first cycle, net angles (rad) of whirl and race, and whether it still lasts."""

    site: str
    start: float
    whirled: float
    race_turned: float
    to_the_end: bool


def _rolled(dataset: Signals) -> list[_Rolling]:
    """Return the periods of rolling from cycle 0 on."""
    dataset = at_every_step(dataset)
    rollings = []
    for site in places(dataset).sites:
        mode, whirl, race = (signal(dataset, f"{site}.{name}") for name in ("mode", "whirl_speed", "race_speed"))
        if mode is None or whirl is None:
            continue
        rolls = (mode == ROLLING) & (cycles(dataset) >= 0.0)
        if not rolls.any():
            continue
        steps = np.diff(dataset["time"].values, prepend=np.nan)  # a sample's mode is that at the end of its step
        before = np.append(False, rolls[:-1])
        begins, ends = np.flatnonzero(rolls & ~before), np.flatnonzero(before & ~rolls)
        whirled, turned = (
            np.zeros(len(begins))
            if speed is None
            else np.abs(np.add.reduceat(np.where(rolls & before, speed * steps, 0.0), begins))
            for speed in (whirl, race)
        )
        for k, start in enumerate(cycles(dataset)[begins]):
            rollings.append(_Rolling(site, float(start), float(whirled[k]), float(turned[k]), k == len(ends)))
    return rollings
