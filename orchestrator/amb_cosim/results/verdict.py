"""The verdict on a run, from its data set: a word, a sentence, and the few values that determine it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.record.warnings import warnings_of
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.units import force_unit, frequency_unit, length_unit, speed_unit
from amb_cosim.results import contact_history
from amb_cosim.results.contact_forces import largest_averaged_force, peak_force, touches
from amb_cosim.results.landing_rows import landing_rows, whirl_text
from amb_cosim.results.loop_stability import stability_of_loop
from amb_cosim.results.magnet_use import magnet_use_rows
from amb_cosim.results.orbits import radius
from amb_cosim.results.places import places
from amb_cosim.results.power import without_power
from amb_cosim.results.signal_arrays import (
    at_every_step,
    cycles,
    event_name,
    parameters,
    signal,
    speed,
    speed_changes,
    thinning,
)
from amb_cosim.results.stability import instability, judged_time, too_short
from amb_cosim.results.stators import StatorTouch, stator_touches
from amb_cosim.results.touchdown import Touchdown
from amb_cosim.results.warning_sentences import warning_sentences

Word = Literal[
    "recovered",
    "trapped",
    "undecided",
    "landed",
    "stator",
    "levitated",
    "rolled",
    "failed",
    "unstable",
    "interrupted",
    "free",
    "completed",
]
BROKEN_OFF = ("failed", "interrupted")
BAD = ("trapped", "stator", "rolled", "unstable", *BROKEN_OFF)
QUESTIONING = ("passed", "energy_missed", "overheated")  # outputs whose warnings put the verdict itself in doubt


@dataclass(frozen=True)
class Verdict:
    """Outcome of a run.

    Attributes
    ----------
    word
        `recovered`: the rotor touched, and has been free of contact for five cycles. `trapped`: it touches in the last
        cycle, at least ten turns after the last change of its excitation (see `contact_history.recovery`). `undecided`:
        the run is too short to decide. `rolled`: it rolls on a site at the end. `landed`: it
        touched after all magnets lost their power, and the magnets are still off. `stator`: it touched the stator of a
        magnetic bearing at any time. `levitated`: it never touched, or not after the disturbance. `free`: as
        `levitated`, but for a rotor that has no magnets, or whose magnets have no power at the end. `unstable`: its
        loop is unstable, its orbit grows, or its amplifiers stay at their limits or bound a self-excited vibration.
        `failed` and
        `interrupted`: the run did not complete. `completed`: the run completed, but contact was not recorded.
    sentence
        The reason, with its values.
    facts
        Labels and texts of the values that determine the verdict: margin to the clearance, contact force, time in
        contact, touches of stators.
    doubts
        Warnings that cast doubt on the verdict.
    """

    word: Word
    sentence: str
    facts: tuple[tuple[str, str], ...] = ()
    doubts: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.word}: {self.sentence}"


def verdict(dataset: Signals, fall: Touchdown | None = None) -> Verdict:
    """Return the verdict on a run.

    Parameters
    ----------
    dataset
        The record of the run, with its attributes.
    fall
        The touchdown of the run, if it contains one.
    """
    last = contact_history.contact_cycles(dataset)[1]
    word, sentence = _ending(dataset, last, fall)
    touches = stator_touches(dataset)
    if touches and word not in BROKEN_OFF:
        where = _listed([name_label(touch.bearing) for touch in touches.values()])
        word, sentence = "stator", f"the rotor touched the stator at {where}; {sentence}"
    landed = landing_rows(dataset, fall) if fall is not None and without_power(dataset)[-1] else ()
    facts = [_speed(dataset), _margin(dataset, word), _force(dataset), *landed, _time_in_contact(dataset)]
    facts += [_stators(touches), *magnet_use_rows(dataset)]
    if dataset.attrs.get("stopped"):
        facts.append(("stopped", str(dataset.attrs["stopped"])))
    warned = [w for w in warnings_of(dataset) if w.variable.rpartition(".")[2] in QUESTIONING]
    return Verdict(
        word, sentence, tuple(fact for fact in facts if fact is not None), tuple(warning_sentences(warned, dataset))
    )


def _ending(dataset: Signals, last: float | None, fall: Touchdown | None) -> tuple[Word, str]:
    """Return the word and the sentence for a run; `last` is the cycle of the last contact, if any."""
    outcome = Outcome(*json.loads(dataset.attrs["outcome"])) if "outcome" in dataset.attrs else None
    if outcome is not None and outcome.status == "failed":
        return "failed", f"{outcome.component} at t = {outcome.time:.6g} s: {outcome.reason}"
    if outcome is not None and outcome.status == "interrupted":
        return "interrupted", f"by the user at t = {outcome.time:.6g} s"
    free, recovery = contact_history.freed_after(dataset, last)
    if free is None:
        return "completed", "contact of the rotor was not recorded"
    if recovery == "unstable":
        return "unstable", instability(dataset, last)
    if recovery == "undecided":
        return "undecided", _undecided(dataset, last)
    powerless = bool(without_power(dataset)[-1])
    unseen = "" if powerless else _unseen(dataset, last)
    if free and (last is None or recovery == "prevented"):
        after = f" after the {event_name(dataset, 'disturbance')}" if recovery == "prevented" else ""
        word: Word = "free" if powerless or not places(dataset).magnetic else "levitated"
        return word, f"the rotor does not touch{after}{unseen}"
    assert last is not None
    if free:
        return "recovered", f"the rotor touched and has been free of contact since {_moment(dataset, last)}{unseen}"
    touched = _touched_at_the_end(dataset)
    where = _listed(touched) or "its retainers"
    if recovery == "rolled":
        rolling = [_whirl(dataset, site) for site in contact_history.rolls_at_the_end(dataset)]
        return "rolled", f"the rotor rolls on {_listed(rolling)} at the end"
    if powerless:
        rest, rocks = (None, None) if fall is None else (fall.rest_after, fall.rocks_within)
        if not touched:
            return "landed", f"no magnet has power, and the rotor has not touched since {_moment(dataset, last)}"
        lies = f"the rotor is still moving on {where}"
        if rocks is not None:
            lies = f"the rotor lies on {where} and swings up to {rocks:.0f} deg"
        elif rest is not None:
            lies = f"the rotor came to rest on {where} after {rest:.3g} s"
        return "landed", f"no magnet has power, and {lies}{_whirled(fall)}"
    return "trapped", _at_the_end(dataset, last)


def _undecided(dataset: Signals, last: float | None) -> str:
    """Return a sentence on what the run lacks for a decision; `last` is the cycle of the last contact, if any."""
    off = contact_history.falls_from(dataset, last)
    if off is not None:
        since = f"no magnet has power since {_moment(dataset, off)}, and the rotor has not touched since then"
        return f"too short to decide how the rotor lands: {since}"
    if last is None or cycles(dataset)[-1] - last >= contact_history.recovery_cycles(dataset):
        return f"too short to decide whether the rotor stays free: {too_short(dataset, last)}"
    return _at_the_end(dataset, last)


def _unseen(dataset: Signals, last: float | None) -> str:
    """Return a clause on the growth that the motion would not show; empty if the loop is known, or without magnets."""
    judged = judged_time(dataset, last)
    if stability_of_loop(dataset) is not None or not places(dataset).magnetic or not judged > 0.0:
        return ""
    return f"; the loop is not known, and in {judged:.3g} s growth slower than {1.0 / judged:.2g} 1/s may not show"


def _at_the_end(dataset: Signals, last: float) -> str:
    """Return a phrase on the last contact, in cycle `last`, and on what the run lacks for a decision."""
    end = cycles(dataset)[-1]
    ends = f"when the run ends ({', '.join(_at(dataset, end))})"
    if contact_history.touches_at_the_end(dataset, last):
        where = _listed(_touched_at_the_end(dataset, 1.0)) or "its retainers"
        turned, needed = contact_history.turns_since_change(dataset), contact_history.TRAPPED_TURNS
        rule = f"; it counts as trapped after {needed:g} turns" if turned < needed - contact_history.ON_THE_GRID else ""
        return f"still in contact with {where} {ends}, {turned:.3g} turns after the last event or change of speed{rule}"
    unit, size = ("s", float(dataset.attrs["period_s"])) if speed_changes(dataset) else ("cycles", 1.0)
    rule = f"it counts as recovered after {contact_history.recovery_cycles(dataset) * size:.3g} {unit} without contact"
    return f"free of contact for {(end - last) * size:.3g} {unit} {ends}; {rule}"


def _whirled(fall: Touchdown | None) -> str:
    """Return a phrase on whether and how the rotor whirled during a landing; empty if this was not recorded."""
    if fall is None or all(item.whirl is None for item in fall.retainers.values()):
        return ""
    whirled = whirl_text(fall)
    return f"; it whirled {whirled}" if whirled else "; no whirl"


def _listed(names: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def _whirl(dataset: Signals, site: str) -> str:
    """Return the name of a site, with direction and speed of the whirl there in the last cycle of the run."""
    whirl = contact_history.whirl_at_the_end(dataset, site) or 0.0
    direction = "forward" if whirl > 0.0 else "backward"
    return f"{name_label(site)} ({direction} whirl, {speed_unit().text(abs(whirl))})"


def _moment(dataset: Signals, cycle: float) -> str:
    """Return a cycle in words."""
    return "{} ({})".format(*_at(dataset, cycle))


def _at(dataset: Signals, cycle: float) -> tuple[str, str]:
    """Return a cycle and its time; if the speed changes, so that cycles are not turns, return time and speed."""
    time = float(np.interp(cycle, cycles(dataset), dataset["time"].values))
    if not speed_changes(dataset):
        return f"cycle {cycle:.4g}", f"{time:.3g} s"
    Omega = float(np.interp(time, dataset["time"].values, speed(dataset)))
    return f"{time:.4g} s", speed_unit().text(Omega)


def _touched_at_the_end(dataset: Signals, within: float = contact_history.RECOVERY_CYCLES) -> list[str]:
    """Return the sites in contact within the last cycles, by default as many cycles as a recovery requires."""
    steps = at_every_step(dataset)
    end = cycles(steps) > cycles(steps)[-1] - within
    return [name_label(site) for site in places(dataset).contacts if touches(steps, site)[end].any()]


def _speed(dataset: Signals) -> tuple[str, str] | None:
    """Return the spin speed; if it changes, return its first and last values, or its limits if these are wider."""
    unit, Omega = speed_unit(), speed(dataset)[cycles(dataset) >= 0.0]
    if not len(Omega):
        return None
    ends, bounds = ([unit.number(value) for value in pair] for pair in (Omega[[0, -1]], (Omega.min(), Omega.max())))
    shown = ends if {*ends} == {*bounds} else bounds
    return "speed", f"{' to '.join(dict.fromkeys(shown))} {unit.label}"


def _margin(dataset: Signals, word: Word) -> tuple[str, str] | None:
    """Return the smallest margin between the orbit and the clearance of a site, over the run or in its last cycle.

    1 - max |r(t)|/c
    """
    if word not in ("levitated", "recovered", "unstable", "free"):
        return None
    cycle, values = cycles(dataset), parameters(dataset)
    begin = float(dataset.attrs.get("disturbance_cycle", 0.0)) if word in ("levitated", "free") else cycle[-1] - 1.0
    within = cycle >= max(begin, 0.0)
    orbits = []
    for site in places(dataset).sites:
        r, clearance = radius(dataset, site), values.get(f"{site}.clearance")
        if r is not None and clearance and values.get(f"{site}.enabled", True) and within.any():
            orbits.append((1.0 - float(r[within].max()) / clearance, float(r[within].max()), float(clearance), site))
    if not orbits:
        return None
    margin, orbit, clearance, site = min(orbits)
    when = "largest orbit" if word in ("levitated", "free") else "orbit in the last cycle"
    if thinning(dataset) > 1:
        when += " of the samples"
    lengths = f"{length_unit(orbit).text(orbit, 3)} in {length_unit(clearance).text(clearance, 3)}"
    return "margin to the clearance", f"{100.0 * margin:.3g} % at {name_label(site)}; {when} {lengths}"


def _force(dataset: Signals) -> tuple[str, str] | None:
    """Return the largest contact force, averaged if possible, with a note on its kind and on the range of the modes."""
    sites = contact_history.touchable(dataset)
    averaged = {site: largest_averaged_force(dataset, site) or 0.0 for site in sites}
    meaning = "mean over 1 ms with impacts"
    if not any(averaged.values()):
        averaged, meaning = {site: peak_force(dataset, site) or 0.0 for site in sites}, "largest sample"
    if not any(averaged.values()):
        return None
    site = max(averaged, key=lambda name: averaged[name])
    limit = places(dataset).valid_to
    band = "" if limit is None else f"; the model's modes reach to {frequency_unit().text(limit)}"
    return (
        "largest contact force",
        f"{force_unit(averaged[site]).text(averaged[site], 3)} at {name_label(site)} ({meaning}{band})",
    )


def _stators(touches: dict[str, StatorTouch]) -> tuple[str, str] | None:
    """Return the first touch of each stator and the largest force on it."""
    if not touches:
        return None
    texts = []
    for touch in touches.values():
        force = touch.peak if touch.force is None else touch.force
        largest = "" if force is None else f", up to {force_unit(force).text(force, 3)}"
        texts.append(f"{name_label(touch.bearing)} at {touch.first:.4g} s{largest}")
    return "first touch of the stator", "; ".join(texts)


def _time_in_contact(dataset: Signals) -> tuple[str, str] | None:
    """Return the time in contact from cycle 0 on, in total and at each site, not counting the instants of impacts."""
    steps = at_every_step(dataset)
    touching = contact_history.in_contact(steps)
    duration = np.diff(steps["time"].values, prepend=steps["time"].values[:1]) * (cycles(steps) >= 0.0)
    if touching is None or not (touching & (duration > 0.0)).any():
        return None
    first, last = (_moment(dataset, at) for at in contact_history.contact_cycles(dataset) if at is not None)
    modes = {site: signal(steps, f"{site}.mode") for site in contact_history.touchable(dataset)}
    closed = {site: mode != contact_history.FREE for site, mode in modes.items() if mode is not None}
    shares = {site: float(duration[of].sum()) for site, of in closed.items()}
    together = np.any([signal(steps, "contact_state") != 0, *closed.values()], axis=0)
    touched, total = float(duration[together].sum()), float(duration.sum())
    parts = ", ".join(f"{name_label(site)} {share:.3g} s" for site, share in shares.items() if share)
    of_sites = f"; {parts}" if parts and len(modes) > 1 else ""
    return "time in contact", (
        f"{touched:.3g} s of {total:.3g} s ({100.0 * touched / total:.3g} %){of_sites}; {first} to {last}"
    )
