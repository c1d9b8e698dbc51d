"""The summary of a run: key values of its data set, each computed by a function."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Any

from amb_cosim.cosim.choices import ROLES
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.record.warnings import warnings_of
from amb_cosim.presentation.json_data import JsonKey, Layout, json_data
from amb_cosim.results import contact_forces, contact_history, energies
from amb_cosim.results.contact_spectrum import share_beyond_reduction, warnings_beyond_reduction
from amb_cosim.results.orbits import (
    notices_of_samples,
    notices_of_start,
    orbit_after,
    orbit_before,
    orbit_largest,
    settled_amplitudes,
)
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import event_name, finite_signals, not_finite, shares_of_steps, speed_changes
from amb_cosim.results.stators import StatorTouch, stator_touches
from amb_cosim.results.thinned import judged
from amb_cosim.results.touchdown import Touchdown, touchdown
from amb_cosim.results.verdict import Verdict, verdict
from amb_cosim.results.warning_sentences import warning_sentences

AtPlaces = dict[str, float | None]


@dataclass(frozen=True)
class Summary:
    """Key values of a run from cycle 0 on; a value is None if the data set lacks the variables that it requires.

    Attributes
    ----------
    scenario, flavour
        Name of the scenario, and flavour of the FMUs.
    completed
        Whether the run reached its end, or one of its stop conditions.
    stopped
        The stop condition that ended the run, if any.
    settling, simulated, wall
        Time simulated before and after cycle 0, and the wall-clock time of the simulation after cycle 0 (s).
    real_time_factor
        Simulated time divided by wall-clock time.
    steps_by_method
        Share of the steps that the plant computed by each method of its output `solver.method`: exactly, in pieces, or
        by substeps for one of several reasons.
    peak_contact_force
        Largest force between impacts at each site (N): of the normal force without the impulses of impacts, so that it
        may be smaller than `averaged_contact_force`. It grows with the number of retained modes.
    peak_band
        Frequency up to which the retained modes are accurate (rad/s); None without a limit.
    peak_is_sampled
        Whether the force between impacts at a site is only the largest sample (see `contact_forces.is_sampled`).
    averaged_contact_force
        Largest contact force at each site (N): the largest 1 ms mean of the normal force, including impacts. It
        converges as the number of modes grows.
    peak_impulse
        Largest normal impulse of the impacts within a step at each site (N s).
    events
        Names of the events with the roles `disturbance` and `relief`, by role.
    event_cycles
        Cycles at which these events happen.
    contact_share
        Share of the time between disturbance and relief that is spent in each contact state of the plant's output
        `contact_state`.
    site_share
        Share of the same time during which the rotor is in contact at each site.
    contact_states
        Names of the contact states; for two bearings these are none, the first, the second and both.
    cycle_duration, speed_changes
        Duration of a cycle (s), which is a turn at the initial speed, and whether the speed changes, in which case
        cycles are not turns.
    first_contact, last_contact
        Cycles of the first and last sample in contact.
    recovered
        Whether the rotor is stable and has been free of contact for the last five cycles; None for a run that ended
        early, or that had neither a disturbance nor contact.
    recovery
        What the disturbance led to: contact was `prevented`, or the rotor `recovered` from it. With or without a
        disturbance, the outcome is `trapped` if the rotor stays in contact; `rolled` if it rolls at the end; `landed`
        if it does not recover and no magnet has power at the end; `undecided` if the run ends too early to decide (see
        `contact_history.recovery`); `unstable` if the orbit grows, or the amplifiers stay at their limits or bound a
        self-excited vibration (see `stability`); and `stator` if the rotor touched the stator. None for a run that ends
        free of contact without a disturbance, or that did not complete.
    rolling_from
        Cycle from which the rotor rolls on a site for at least one net turn of whirl.
    rolling_on_race_from
        Cycle from which the rotor rolls with a turning race for at least one turn of the race, while it whirls by less
        than a turn.
    whirl_speed
        Mean whirl speed at each site over the last cycle (rad/s); None if the rotor does not touch the site at the end.
    orbit_before, orbit_after, orbit_largest
        Largest radius (mm) at each bearing, and at each retainer that is not in the plane of its bearing: in the cycle
        before the disturbance, in the last cycle, and at any time, respectively.
    settled_amplitude
        Synchronous amplitude at the same places `before` the change and at the `end` (mm); None where the motion is not
        synchronous.
    energy
        Heat of damping, friction and impacts, work of all inputs, and the largest error of the balance (J). The heat of
        impacts is negative if the nodal impact rule (`contact.impact_law` 0) creates energy.
    energy_balance
        The largest error of the balance, divided by the largest of all energies.
    energy_balance_of_heat
        The largest error of the balance, divided by the heat; None if there is no heat.
    stators
        The touches of each stator that the rotor has touched, by contact site; empty if there are none.
    share_beyond_reduction
        Share of the contact force's power at each site that is above the frequency up to which the reduced rotor is
        accurate.
    touchdown
        The fall of the rotor onto its retainers, or its contact after magnets are switched off; None if
        it touches nothing.
    warnings
        A sentence for each kind of warning from a component, which states what happened, where, and from when until
        when. Another sentence warns if much of the contact force's power is above the frequency range of the reduced
        rotor.
    notices
        Notes on scenario settings that replacing components lack, on an end of the run that was rounded to whole steps,
        on a largest orbit that belongs to a transient at the start, and on what the orbits of a thinned record may
        miss.
    verdict
        Outcome of the run, in a word and a sentence, and the values that determine it. The verdict is printed, but not
        included in JSON.
    """

    scenario: str
    flavour: str
    completed: bool
    stopped: str | None
    settled: Annotated[str, JsonKey("settling")]
    settling: Annotated[float, "s"]
    simulated: Annotated[float, "s"]
    wall: Annotated[float, "s"]
    real_time_factor: float | None
    steps_by_method: dict[str, float] | None
    peak_contact_force: Annotated[AtPlaces, "N"]
    peak_is_sampled: dict[str, bool]
    peak_band: Annotated[float | None, "rad/s"]
    averaged_contact_force: Annotated[AtPlaces, "N"]
    peak_impulse: Annotated[AtPlaces, "N.s"]
    events: dict[str, str]
    event_cycles: Annotated[dict[str, float], "cycle"]
    contact_share: Annotated[AtPlaces, "1"]
    contact_states: list[str]
    site_share: Annotated[AtPlaces, "1"]
    cycle_duration: Annotated[float, "s"]
    speed_changes: bool
    first_contact: Annotated[float | None, "cycle"]
    last_contact: Annotated[float | None, "cycle"]
    recovered: bool | None
    recovery: contact_history.Recovery | None
    rolling_from: Annotated[float | None, "cycle"]
    rolling_on_race_from: Annotated[float | None, "cycle"]
    whirl_speed: Annotated[AtPlaces, "rad/s"]
    orbit_before: Annotated[AtPlaces, "mm"]
    orbit_after: Annotated[AtPlaces, "mm"]
    orbit_largest: Annotated[AtPlaces, "mm"]
    settled_amplitude: Annotated[dict[str, AtPlaces], "mm"]
    energy: Annotated[dict[str, float] | None, "J"]
    energy_balance: Annotated[float | None, "1", JsonKey("energy_balance_relative")]
    energy_balance_of_heat: Annotated[float | None, "1"]
    share_beyond_reduction: Annotated[AtPlaces, "1"]
    stators: dict[str, StatorTouch]
    touchdown: Touchdown | None
    warnings: list[str]
    notices: list[str]
    verdict: Annotated[Verdict, Layout.OMITTED]

    def as_dict(self) -> dict[str, Any]:
        """Return the values in a dictionary that is ready for JSON, with units in its keys."""
        data: dict[str, Any] = json_data(self)
        return data

    def _repr_html_(self) -> str:
        from amb_cosim.presentation.text_tables import html_of, text_table

        table = text_table("", ("", ""), left=("",))
        for label, text in self.verdict.facts:
            table.add_row(label, text)
        return html_of([str(self.verdict), table, *(f"warning: {text}" for text in self.warnings)])

    def to_json(self) -> str:
        """Return `as_dict` as JSON text."""
        return json.dumps(self.as_dict(), indent=2, allow_nan=False) + "\n"


def summarise(dataset: Signals) -> Summary:
    """Compute the summary of a run from its data set; a notice names signals that are not finite and are left out."""
    recorded, left_out = finite_signals(dataset)
    dataset = judged(recorded)
    simulated, wall = float(dataset.attrs["simulated_s"]), float(dataset.attrs["wall_s"])
    first, last = contact_history.contact_cycles(dataset)
    sites = contact_history.touchable(dataset)
    recovered, recovery = _recovery(dataset, last)
    fall = touchdown(dataset)
    energy, balance, of_heat = energies.energy_balance(dataset)
    return Summary(
        scenario=dataset.attrs["scenario"],
        flavour=dataset.attrs["flavour"],
        completed=bool(dataset.attrs["completed"]),
        stopped=dataset.attrs.get("stopped") or None,
        settled=str(dataset.attrs.get("settling", "simulated")),
        settling=float(dataset.attrs["settling_s"]),
        simulated=simulated,
        wall=wall,
        real_time_factor=simulated / wall if wall > 0.0 else None,
        steps_by_method=shares_of_steps(dataset),
        peak_contact_force={site: contact_forces.peak_force(dataset, site) for site in sites},
        peak_is_sampled={site: contact_forces.is_sampled(recorded, site) for site in sites},
        peak_band=places(dataset).valid_to,
        averaged_contact_force={site: contact_forces.largest_averaged_force(dataset, site) for site in sites},
        peak_impulse={site: contact_history.peak(dataset, f"{site}.impulse") for site in sites},
        events={role: event_name(dataset, role) for role in ROLES if f"{role}_cycle" in dataset.attrs},
        event_cycles={role: float(at) for role in ROLES if (at := dataset.attrs.get(f"{role}_cycle")) is not None},
        contact_share=contact_history.contact_share(dataset),
        contact_states=list(places(dataset).contact_states),
        site_share=contact_history.site_share(dataset),
        cycle_duration=float(dataset.attrs["period_s"]),
        speed_changes=speed_changes(dataset),
        first_contact=first,
        last_contact=last,
        recovered=recovered,
        recovery=recovery,
        rolling_from=contact_history.rolling_from(dataset),
        rolling_on_race_from=contact_history.rolling_on_race_from(dataset),
        whirl_speed={site: contact_history.whirl_at_the_end(dataset, site) for site in sites},
        orbit_before=orbit_before(dataset),
        orbit_after=orbit_after(dataset),
        orbit_largest=orbit_largest(dataset),
        settled_amplitude=settled_amplitudes(dataset),
        energy=energy,
        energy_balance=balance,
        energy_balance_of_heat=of_heat,
        share_beyond_reduction=share_beyond_reduction(dataset),
        stators=stator_touches(dataset),
        touchdown=fall,
        warnings=warnings_in(dataset),
        notices=[
            *json.loads(dataset.attrs.get("notices", "[]")),
            *([f"this summary leaves out some signals: {not_finite(left_out)}"] if left_out else []),
            *notices_of_start(dataset),
            *notices_of_samples(dataset),
        ],
        verdict=verdict(dataset, fall),
    )


def run_warnings(dataset: Signals) -> list[str]:
    """Return the warnings of a run's summary from its data set."""
    return warnings_in(judged(finite_signals(dataset)[0]))


def warnings_in(dataset: Signals) -> list[str]:
    """Return the warnings of a record without values that are not finite, at every step if the record has them."""
    return [*warning_sentences(warnings_of(dataset), dataset), *warnings_beyond_reduction(dataset)]


def _recovery(dataset: Signals, last: float | None) -> tuple[bool | None, contact_history.Recovery | None]:
    """Return `recovered` and `recovery`, given the cycle `last` of the last contact (None if there was none)."""
    recovered, recovery = contact_history.freed_after(dataset, last)
    if recovery == "unstable":
        return False, recovery
    if not dataset.attrs["completed"]:
        return None, None
    return (recovered if last is not None or recovery is not None else None), recovery
