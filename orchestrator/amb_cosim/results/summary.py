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
from amb_cosim.results.touchdown import Touchdown, touchdown
from amb_cosim.results.verdict import Verdict, verdict
from amb_cosim.results.warning_sentences import warning_sentences

AtPlaces = dict[str, float | None]


@dataclass(frozen=True)
class Summary:
    """Key values of a run from cycle 0 on; None if the data set lacks the required variables.

    Attributes
    ----------
    scenario, flavour
        Name of the scenario, and flavour of the FMUs.
    completed
        Whether it reached its end, or one of its stop conditions.
    stopped
        The stop condition that ended it.
    settling, simulated, wall
        Time simulated before and after cycle 0, and the wall-clock time of the latter (s).
    real_time_factor
        Simulated over wall-clock time.
    steps_by_method
        Share of the steps that the plant computed exactly, in pieces, and by substeps for each reason, by its output
        `solver.method`.
    peak_contact_force
        Largest normal contact force at each site (N), without the impulses of impacts. It grows with the number of
        retained modes.
    peak_band
        Frequency up to which these modes are accurate (rad/s).
    peak_is_sampled
        Whether this is only the largest sample at a site, see `contact_forces.is_sampled`.
    averaged_contact_force
        Largest normal contact force averaged over 1 ms at each site, including impacts (N), which converges.
    peak_impulse
        Largest normal impulse of the impacts within a step at each site (N s).
    events
        Names of the events that are the `disturbance` and the `relief` of the run, by role.
    event_cycles
        Cycles at which they happen.
    contact_share
        Share of the time between disturbance and relief in each contact state, by the plant's output `contact_state`.
    site_share
        Share of the same time during which the rotor is in contact at each site.
    contact_states
        Names of these states: for two bearings none, the first, the second, both.
    cycle_duration, speed_changes
        Duration of a cycle, a turn at the first speed (s), and whether the speed changes, so that cycles are not turns.
    first_contact, last_contact
        Cycles of the first and last sample in contact.
    recovered
        Whether the rotor is stable and free of contact for the last five cycles; None for a run that ended early, and
        without disturbance and contact.
    recovery
        What the disturbance led to: contact `prevented`, or `recovered` from. With a disturbance or without: the rotor
        is `trapped` in contact, or `landed` if no magnet has power at the end; `undecided` if the run ends too early to
        decide, see `contact_history.recovery`; `unstable` if its orbit grows, or its amplifiers stay at their limits or
        bound a self-excited vibration, see `stability`, and `stator` if it touched the stator. None for a run that ends
        free without a disturbance, or that did not complete.
    rolling_from
        Cycle from which the rotor rolls on a site through a turn of its whirl or more, net of backward motion.
    rolling_on_race_from
        Cycle from which it rolls with a race through a turn of the race or more, without a turn of whirl.
    whirl_speed
        Mean whirl speed at each site over the last cycle (rad/s); None if the rotor does not touch it at the end.
    orbit_before, orbit_after, orbit_largest
        Largest radius at each bearing, and at each retainer that is not in the plane of its bearing, in the cycle
        before the disturbance, in the last cycle, and at any time (mm).
    settled_amplitude
        Synchronous amplitude at the same places `before` the change and at the `end` (mm); None where the motion is not
        synchronous.
    energy
        Heat of damping, friction and impacts, work of all inputs, and the largest error of the balance (J). The heat of
        impacts is negative where the nodal impact rule, `contact.impact_law` 0, creates energy.
    energy_balance
        That error over the largest of all energies.
    energy_balance_of_heat
        That error over the heat; None without heat.
    stators
        The touches of each stator that the rotor has touched, by contact site; empty if there are none.
    share_beyond_reduction
        Share of the contact force's power at each site above the frequency to which the reduced rotor is accurate.
    touchdown
        The fall of the rotor onto its retainers, or its contact after magnets are switched off; None without contact.
    warnings
        A sentence for each kind of warning that a component gave: what, where, from when until when. There is also one
        if much of the contact force's power is beyond the reduction.
    notices
        Scenario settings that replacing components lack, an end of the run rounded to whole steps, a largest orbit
        that is a transient at the start, and what orbits of a thinned record may miss.
    verdict
        Outcome of the run, in a word and a sentence, and the values that determine it. It is printed, but not included
        in JSON.
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
        """Return the values by names that include their units, ready for JSON."""
        data: dict[str, Any] = json_data(self)
        return data

    def to_json(self) -> str:
        """Return `as_dict` as JSON text."""
        return json.dumps(self.as_dict(), indent=2, allow_nan=False) + "\n"


def summarise(dataset: Signals) -> Summary:
    """Compute the summary of a run from its data set; signals that are not finite are left out, with a notice."""
    dataset, left_out = finite_signals(dataset)
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
        peak_is_sampled={site: contact_forces.is_sampled(dataset, site) for site in sites},
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
        warnings=[*warning_sentences(warnings_of(dataset), dataset), *warnings_beyond_reduction(dataset)],
        notices=[
            *json.loads(dataset.attrs.get("notices", "[]")),
            *([f"these values do not cover all signals: {not_finite(left_out)}"] if left_out else []),
            *notices_of_start(dataset),
            *notices_of_samples(dataset),
        ],
        verdict=verdict(dataset, fall),
    )


def _recovery(dataset: Signals, last: float | None) -> tuple[bool | None, contact_history.Recovery | None]:
    """Return `recovered` and `recovery` of a summary of a run with the last contact in cycle `last`, or None."""
    recovered, recovery = contact_history.freed_after(dataset, last)
    if recovery == "unstable":
        return False, recovery
    if not dataset.attrs["completed"]:
        return None, None
    return (recovered if last is not None or recovery is not None else None), recovery
