"""The printed summary of a run: the verdict, its reasons, and optionally all other values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from rich.console import Console
from rich.table import Table

from amb_cosim.cosim.choices import ROLES
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.text_tables import number, print_parts, show_warnings
from amb_cosim.presentation.units import force_unit, frequency_unit, length_unit, speed_unit, temperature_text
from amb_cosim.results import energies
from amb_cosim.results.summary import AtPlaces, Summary
from amb_cosim.results.touchdown import Retainer, Touchdown

METHODS = {  # of the plant's output `solver.method`, in words
    "exact": "as a whole by matrices",
    "pieces": "in parts by matrices",
    "events": "in substeps around contact events",
    "no_matrices": "in substeps without matrices",
    "compliant": "in substeps of a compliant contact law",
    "integrated": "in substeps throughout",
}


def print_summary(summary: Summary, console: Console, whole: bool = False) -> None:
    """Print verdict, table and warnings; unless `whole`, warnings that do not affect the verdict share one line."""
    console.print(str(summary.verdict), markup=False, highlight=False, soft_wrap=True, style="bold")
    print_parts([table(summary, whole)], console)
    if whole:
        show_warnings(summary.warnings, console)
        return
    show_warnings(summary.verdict.doubts, console, whole=False)
    others = [sentence for sentence in summary.warnings if sentence not in summary.verdict.doubts]
    if others:
        count = f"{len(others)} {'more ' * bool(summary.verdict.doubts)}warning{'s' * (len(others) > 1)}"
        about = "; ".join(re.split(r", (?=which|where)|;| \(", sentence)[0] for sentence in others)
        line = f"{count}, printed by --all: {about}"
        overflow = {"no_wrap": True, "overflow": "ellipsis"} if console.is_terminal else {"soft_wrap": True}
        console.print(line, markup=False, highlight=False, **overflow)


def table(summary: Summary, whole: bool = False) -> Table:
    """Return the values that determine the verdict, with their labels; if `whole`, return all other values as well."""
    result = Table(show_header=False, box=None, padding=(0, 2, 0, 0))
    for label, text in [*summary.verdict.facts, *(_all_rows(summary) if whole else ())]:
        result.add_row(label, text)
    return result


def _all_rows(summary: Summary) -> Iterator[tuple[str, str]]:
    if summary.events:
        moments = (f"{name} at {_cycle(summary, summary.event_cycles[role])}" for role, name in summary.events.items())
        yield "events", ", ".join(moments)
    yield from _rows_at_places(summary)
    states = dict(zip(summary.contact_states, summary.contact_share.values(), strict=True))
    sites = {name_label(site): share for site, share in summary.site_share.items()}
    shares = states if set(sites) <= set(states) else sites  # the states are those of the bearings alone
    texts = [f"{name} {100 * share:.1f} %" for name, share in shares.items() if share]
    if texts and texts != ["none 100.0 %"]:
        yield f"contact{_interval(summary.events)}", ", ".join(texts)
    if summary.rolling_from is not None:
        whirls = ", ".join(
            f"{name_label(at)} {'-' if w is None else speed_unit().text(w)}" for at, w in summary.whirl_speed.items()
        )
        yield "rolling", f"from {_cycle(summary, summary.rolling_from)}; mean whirl in the last cycle {whirls}"
    if summary.rolling_on_race_from is not None:
        yield "rolling on a turning race", f"from {_cycle(summary, summary.rolling_on_race_from)}"
    yield from _touchdown_rows(summary.touchdown) if summary.touchdown is not None else ()
    if summary.energy is not None and summary.energy_balance_of_heat is not None:
        gained = -summary.energy["impact"]
        heat, share = energies.heat_of(summary.energy), summary.energy_balance_of_heat
        whole = f"the heat of {number(heat)} J"
        if gained > 0.0:
            yield "energy gained in impacts", f"{number(gained)} J; the nodal impact rule does not conserve momentum"
            whole = f"the heat and the gain in impacts, together {number(heat)} J"
        yield "error of the energy balance", f"{summary.energy['balance']:.1g} J, {share:.1g} of {whole}"
    yield "simulated", f"{summary.simulated:.4g} s, {number(summary.real_time_factor)} times real time"
    if summary.steps_by_method is not None:
        ways = (f"{METHODS.get(name, name)} {100 * share:.3g} %" for name, share in summary.steps_by_method.items())
        yield "steps of the rotor", ", ".join(ways)


def _rows_at_places(summary: Summary) -> Iterator[tuple[str, str]]:
    """Yield labels and texts of the forces and orbits that are nonzero at some place, in units that suit them."""
    sampled = ", of the samples" if any(summary.peak_is_sampled.values()) else ""
    band = "" if summary.peak_band is None else f",\nmodes to {frequency_unit().text(summary.peak_band)}"
    for label, values in (
        ("largest contact force (1 ms mean with impacts)", summary.averaged_contact_force),
        (f"largest force between impacts{band}{sampled}", summary.peak_contact_force),
    ):
        if any(values.values()):
            yield label, _at_places(values, force_unit(_largest(values)).name, 1.0 / force_unit(_largest(values)).size)
    if any(summary.peak_impulse.values()):
        yield "largest impulse of impacts in a step", _at_places(summary.peak_impulse, "N s")
    for label, values in (
        (f"orbit before the {summary.events.get('disturbance')}", summary.orbit_before),
        ("orbit at the end", summary.orbit_after),
        ("largest orbit", summary.orbit_largest),
        ("synchronous part before the change", _without_none(summary.settled_amplitude["before"])),
        ("synchronous part at the end", _without_none(summary.settled_amplitude["end"])),
    ):
        if any(values.values()):
            unit = length_unit(1e-3 * _largest(values))
            yield label, _at_places(values, unit.label, 1e-3 / unit.size)


def _cycle(summary: Summary, cycle: float) -> str:
    """Return a cycle in words, or as a time if the speed changes."""
    return f"{cycle * summary.cycle_duration:.4g} s" if summary.speed_changes else f"cycle {cycle:.4g}"


def _interval(events: Mapping[str, str]) -> str:
    """Return a phrase that names the events between which the shares of contact are computed."""
    begin, end = (events.get(role) for role in ROLES)
    if begin and end:
        return f" between {begin} and {end}"
    return f" after the {begin}" if begin else f" before the {end}" if end else ""


def _without_none(values: AtPlaces) -> AtPlaces:
    return {at: value for at, value in values.items() if value is not None}


def _largest(values: AtPlaces) -> float:
    return max(value for value in values.values() if value is not None)


def _at_places(values: AtPlaces, unit: str, scale: float = 1.0) -> str:
    texts = {name_label(at): number(None if value is None else scale * value) for at, value in values.items()}
    return ", ".join(f"{at} {text} {unit}" for at, text in texts.items())


def _touchdown_rows(touchdown: Touchdown) -> list[tuple[str, str]]:
    """Return labels and texts of a touchdown, for a table."""
    hits = (
        f"{name_label(hit.site)} {number(hit.impulse)} N s after {number(hit.after)} s"
        for hit in touchdown.first_impacts
    )
    ends = (
        ("at rest", touchdown.rest_after),
        ("free of contact", touchdown.free_after),
        ("standstill", touchdown.standstill_after),
    )
    rocks = touchdown.rocks_within
    moves = "moving" if rocks is None else f"swings up to {number(rocks)} deg"
    has_fallen = any(mm is not None for mm in touchdown.drop.values())
    moved = touchdown.drop if has_fallen else touchdown.orbit
    return [
        ("power lost or first contact", f"{number(touchdown.release)} s after cycle 0"),
        (
            "depth of the fall" if has_fallen else "largest orbit from then on",
            ", ".join(f"{name_label(bearing)} {number(mm)} mm" for bearing, mm in moved.items()),
        ),
        ("first impacts", "\n".join(hits) or "-"),
        *((f"in {name_label(site)}", _of_retainer(retainer)) for site, retainer in touchdown.retainers.items()),
        ("final state", ", ".join(f"{what} after {number(t)} s" for what, t in ends if t is not None) or moves),
    ]


def _of_retainer(retainer: Retainer) -> str:
    """Return a few lines on the loads of a retainer."""
    whirl = "" if retainer.whirl_speed is None else f" whirl, mean {speed_unit().text(abs(retainer.whirl_speed))}"
    lines = [
        f"free {number(retainer.free)} s, sliding {number(retainer.sliding)} s, rolling {number(retainer.rolling)} s",
        f"{'no whirl' if retainer.whirl in (None, 'none') else retainer.whirl}{whirl}",
        f"integral of the normal force, with impacts, {number(retainer.impulse)} N s, heat {number(retainer.heat)} J",
    ]
    if retainer.temperature is not None:
        lines[2] += f", up to {temperature_text(retainer.temperature)}"
    if retainer.race_spin_up is not None:
        lines.append(f"race spun up {number(retainer.race_spin_up)} s after the first contact")
    return "\n".join(lines)
