"""A landing until the rotor is at rest: heat, retainer temperatures, and how the force changes with more modes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, assessed_machine_of, rpm
from amb_assessment.assessment.physics.coast_down import CoastDown, coast_down, temperatures
from amb_assessment.assessment.physics.runs import (
    FRICTION,
    check_falls,
    clearance_used,
    end_of,
    longest,
    simulate,
    times_of,
    upright,
    without_power,
    worst_inputs,
)
from amb_assessment.assessment.physics.whirl_friction import chance, whirl_facts, whirl_friction
from amb_assessment.reporting.page_parts import number_text
from amb_assessment.reporting.panels import Panel, curve
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.presentation.units import ZERO_CELSIUS
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.result import Result
from amb_cosim.results.touchdown import SLOW, Retainer, Touchdown
from array_types import Array
from rotor_analysis.reduced_rotor import elastic_shapes

declare("rest_time", "s", title="Time until the rotor is at rest")
declare("retainer_heat", "J", title="Heat in the retainers")
declare("retainer_temperature", "K", title="Largest temperature of a retainer")
declare("standstill_time", "s", title="Time until the rotor stands still")
declare("heat_to_standstill", "J", title="Heat in the retainers until the rotor stands still")
declare("temperature_to_standstill", "K", title="Largest temperature of a retainer until the rotor stands still")
declare("landing_force_change", "%")

FIRST, LONGEST, MOST_STEPS = 5.0, 40.0, 1_000_000  # s, s, and steps, over which a landing is simulated
RECORDS = 50_000  # samples, at most
STOPPED = 0.9 * SLOW  # of the first speed, at which the run ends
SLOWED = f"{100.0 * SLOW:g} % of the speed"
CONVERGENCE = 0.2  # s, over which forces are compared with those of more modes
FEWEST = 4  # modes of the finer rotor
SAME_TIME = 0.01  # relative difference of two predictions of standstill that agree
STEADY_SWING = 0.7  # of the swing in the shorter run, below which rocking decays


@dataclass(frozen=True)
class Outlook:
    """Prediction of how a landing continues after the end of a run.

    standstill
        Time of standstill (s), or infinity if friction does not slow the rotor.
    swing
        Angle within which the rotor rocks steadily (deg); 0 if it is at rest, and None for any other motion.
    """

    standstill: float
    swing: float | None

    def is_that_of(self, before: Outlook) -> bool:
        """Return whether a shorter run predicted the same time of standstill and the swing has not decayed since."""
        if self.swing is None or before.swing is None or self.swing < STEADY_SWING * before.swing:
            return False
        return math.isclose(self.standstill, before.standstill, rel_tol=SAME_TIME)


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the time and heat until rest, the largest temperature, and how the force changes with more modes."""
    check_falls(subject)
    Omega = subject.file.speed.highest
    inputs, lost = worst_inputs(subject), without_power(subject, 1.0)
    fallen = _fall(subject, Omega, inputs, lost)
    touchdown = fallen.summary.touchdown
    if touchdown is None:
        raise ValueError("the rotor touches nothing after the power is lost")
    times, speeds = _speeds(fallen)
    measured = (
        *_to_rest(subject, fallen, touchdown),
        *_landed(subject, touchdown, times),
        *_convergence(subject, Omega, inputs, lost),
    )
    after_start = times >= 0.0
    curves = tuple(
        curve(site, times_of(fallen), 100.0 * shares) for site, shares in clearance_used(subject, fallen).items()
    )
    panels = (
        Panel("Displacement over clearance without power", "time (s)", "%", curves),
        Panel("Speed without power", "time (s)", "rpm", (curve("spin", times[after_start], rpm(speeds[after_start])),)),
    )
    heads = ("place", "free (s)", "sliding (s)", "rolling (s)", "whirl", "heat (J)", "temperature (°C)")
    rows = tuple((site, *_texts(result)) for site, result in touchdown.retainers.items())
    notes = (
        f"The run starts at {rpm(Omega):.0f} rpm with friction {FRICTION:g}; the drive is off, so the spin "
        f"is free. The rotor is at rest if it stays in its retainers within 5 % of the clearance until the run ends; "
        f"it may rotate. The run ends "
        f"at {100.0 * STOPPED:g} % of the initial speed, or after {longest(subject, LONGEST, MOST_STEPS):.4g} s at the "
        f"latest. The run ends earlier if standstill is predicted after that time, and if a run of half the duration "
        f"predicted the same time of standstill (within {100.0 * SAME_TIME:g} %) and the same state (rest or steady "
        "rocking).",
        "In addition to friction, the machine's drag brakes the rotor: spin.drag (gas, windage), race_drag and "
        "race_viscous_drag (balls). A race without drag rotates with the rotor for minutes and absorbs hardly any "
        "heat.",
        *_without_temperature(touchdown),
    )
    return AnalysisResult(measured, panels, (ResultTable(f"{times[-1]:.4g} s without power", heads, rows),), notes)


def _fall(subject: AssessedMachine, Omega: float, inputs: Mapping[str, float], lost: Mapping[str, Any]) -> Result:
    """Return a run after a loss of power.

    The run ends at standstill, after the longest allowed time, or as soon as a longer run would only confirm the
    prediction.
    """
    fields, most = _without_drive(subject, Omega, lost), longest(subject, LONGEST, MOST_STEPS)
    duration, end, before = min(FIRST, most), None, None
    while True:
        run = simulate(subject, Omega, inputs, **fields, end_time=duration, start=end, goes_on=duration < most)
        end, outlook = end_of(run), _outlook(subject, run)
        if duration == most or outlook is None:
            return run
        if before is not None and outlook.standstill > most and outlook.is_that_of(before):
            return run
        before = outlook
        duration = min(2.0 * duration, most)


def _outlook(subject: AssessedMachine, run: Result) -> Outlook | None:
    """Return the prediction for a landing, or None if the rotor has almost stopped or touches nothing."""
    touchdown = run.summary.touchdown
    if touchdown is None or touchdown.slow_after is not None:
        return None
    parameters = subject.parameters[PLANT]
    coasting = coast_down(*_speeds(run), parameters["spin.inertia"], parameters["spin.drag"])
    swing = touchdown.rocks_within if touchdown.rest_after is None else 0.0
    return Outlook(math.inf if coasting is None else coasting.time, swing)


def _speeds(run: Result) -> tuple[Array, Array]:
    """Return the recorded times (s) and spin speeds (rad/s) of a run."""
    times, speeds = (np.asarray(run.signals[name].values) for name in ("time", f"{PLANT}.speed"))
    return times, speeds


def _without_drive(subject: AssessedMachine, Omega: float, lost: Mapping[str, Any]) -> dict[str, Any]:
    """Return the scenario fields for a loss of power after which the rotor, without drive, spins down freely."""
    parameters = {**lost["parameters"], PLANT: {**lost["parameters"][PLANT], "spin.free": True}}
    event, *others = lost["event"]
    off = {**event, "set": {**event["set"], PLANT: {"drive.torque_limit": 0.0}}}
    every = in_steps(longest(subject, LONGEST, MOST_STEPS), RECORDS * float(subject.prepared.step_size))
    return {
        **lost,
        "parameters": parameters,
        "event": [off, *others],
        "stop": [{"variable": f"{PLANT}.speed", "below": STOPPED * Omega}],
        "record": {"every": math.ceil(every)},
    }


def _to_rest(subject: AssessedMachine, run: Result, touchdown: Touchdown) -> Iterator[Quantity]:
    """Yield the times until rest and until standstill, the heat, and, if known, the largest retainer temperature.

    The heat until standstill includes the energy that races have at the end of the run.
    """
    times, speeds = _speeds(run)
    end, sites = float(times[-1]), touchdown.retainers
    where, rest = f"in {end:.4g} s without power", touchdown.rest_after
    rocking = "" if touchdown.rocks_within is None else f"; it swings up to {touchdown.rocks_within:.2g} deg"
    note = f"not at rest within {end:.4g} s, when the run ends{rocking}" if rest is None else ""
    yield Quantity("rest_time", where, end if rest is None else rest, "s", {}, note)
    heat = sum(item.heat or 0.0 for item in sites.values())
    yield Quantity("retainer_heat", where, heat, "J")
    hottest = max((item.temperature for item in sites.values() if item.temperature is not None), default=None)
    if hottest is not None:
        yield Quantity("retainer_temperature", where, hottest, "K")
    if touchdown.slow_after is not None:
        yield Quantity("standstill_time", f"simulated to {SLOWED}", touchdown.slow_after, "s", {}, "drive off")
        yield Quantity("heat_to_standstill", f"all retainers, simulated to {SLOWED}", heat, "J")
        return
    parameters = subject.parameters[PLANT]
    J, drag = parameters["spin.inertia"], parameters["spin.drag"]
    coasting = coast_down(times, speeds, J, drag)
    if coasting is None:
        return
    before = coast_down(times[: 3 * len(times) // 4], speeds[: 3 * len(times) // 4], J, drag)
    other = "no standstill" if before is None else f"standstill after {before.time:.4g} s"
    share = 100.0 * abs(float(speeds[-1] / speeds[0]))
    basis = (
        f"extrapolated from {share:.3g} % of the initial speed, with the friction in the second half of the run; "
        f"an extrapolation that ignores the last quarter of the run predicts {other}"
    )
    yield Quantity("standstill_time", "extrapolated", coasting.time, "s", {}, basis)
    of_races = sum(_race_energy(parameters, run, site) for site in sites)
    yield Quantity("heat_to_standstill", "all retainers, extrapolated", heat + coasting.heat + of_races, "J", {}, basis)
    if hottest is not None:
        yield _temperature(subject, run, touchdown, coasting)


def _landed(subject: AssessedMachine, touchdown: Touchdown, times: Array) -> Iterator[Quantity]:
    """Yield whether the rotor whirls backward, and whether it touches anything except its retainers, during the run."""
    end = f"{float(times[-1]):.4g} s without power"
    others = [site for site in touchdown.retainers if site not in subject.lands_on]
    whirls = touchdown.whirls_backward_at
    ends = touchdown.rest_after, touchdown.rocks_within, touchdown.slow_after
    ended = any(time is not None for time in ends)
    reason = "" if ended else f"neither at rest nor rocking steadily within {end}, when the run ends"
    no_landing = upright(subject)
    reason = no_landing or reason
    least = whirl_friction(subject, FRICTION)
    by_chance = chance(least)
    for quantity, sites, may_change in (
        ("landing_contact_elsewhere", [] if by_chance and whirls else others, by_chance or reason),
        ("landing_backward_whirl", whirls, ""),
    ):
        where = f"{', '.join(sites)}, in {end}" if sites else f"in {end}"
        yield Quantity(
            quantity, where, 100.0 if sites else 0.0, "%", whirl_facts(least), reason, may_change, no_landing
        )


def _race_energy(parameters: Mapping[str, Any], run: Result, site: str) -> float:
    """Return the kinetic energy (J) of a site's race at the end of a run; 0 for a face or a plain ring."""
    inertia, name = parameters.get(f"{site}.race_inertia"), f"{PLANT}.{site}.race_speed"
    return 0.5 * inertia * float(run.signals[name].values[-1]) ** 2 if inertia and name in run.signals else 0.0


def _recent_heats(subject: AssessedMachine, run: Result, sites: Iterable[str]) -> dict[str, float]:
    """Return the heat (J) of the second half of a run, by the retainer that it warms; a face warms its retainer."""
    recent: dict[str, float] = {}
    for site in sites:
        place, heats = _warmed(subject, site), run.signals[f"{PLANT}.{site}.heat"].values
        recent[place] = recent.get(place, 0.0) + float(heats[-1] - heats[len(heats) // 2])
    return recent


def _temperature(subject: AssessedMachine, run: Result, touchdown: Touchdown, coasting: CoastDown) -> Quantity:
    """Return the largest temperature of a retainer until standstill; an upper bound if it transfers no heat.

    The retainers share the heat as in the second half of the run.
    """
    p, recent = subject.parameters[PLANT], _recent_heats(subject, run, touchdown.retainers)
    total, hottest = sum(recent.values()), dict[str, float]()
    for place, warmed in recent.items():
        if capacity := p.get(f"{place}.heat_capacity"):
            heats = coasting.warming(warmed / total if total else 1.0 / len(recent), _race_energy(p, run, place))
            measured = np.asarray(run.signals[f"{PLANT}.{place}.temperature"].values)
            later = temperatures(
                *(coasting.times, heats, float(measured[-1])),
                capacity=capacity,
                transfer=p[f"{place}.heat_transfer"],
                ambient=p["ambient_temperature"],
            )
            hottest[place] = float(max(measured.max(), later.max()))
    place = max(hottest, key=lambda name: hottest[name])
    capacity, transfer = p[f"{place}.heat_capacity"], p[f"{place}.heat_transfer"]
    where, note = f"{place}, extrapolated", f"with heat_capacity {capacity:g} J/K and heat_transfer {transfer:g} W/K"
    if not transfer:
        where, note = f"{place}, at most", "extrapolated as if the retainer gave off no heat: its heat_transfer is 0"
    return Quantity("temperature_to_standstill", where, hottest[place], "K", {}, note)


def _warmed(subject: AssessedMachine, site: str) -> str:
    """Return the retainer that is warmed by contact at a site or a face."""
    return next((face.retainer or site for face in subject.rotor.faces if face.name == site), site)


def _without_temperature(touchdown: Touchdown) -> tuple[str, ...]:
    """Return a note on the retainers whose temperature was not computed because their heat capacity is unknown."""
    names = [site for site, result in touchdown.retainers.items() if result.temperature is None]
    if not names:
        return ()
    wanted = "set `heat_capacity` (J/K) and `heat_transfer` (W/K)"
    return (f"No temperature was computed for {', '.join(names)}: {wanted}.",)


def _texts(retainer: Retainer) -> tuple[str, ...]:
    numbers = [_number(item) for item in (retainer.free, retainer.sliding, retainer.rolling)]
    celsius = None if retainer.temperature is None else retainer.temperature - ZERO_CELSIUS
    return (*numbers, retainer.whirl or "-", _number(retainer.heat), _number(celsius))


def _number(value: float | None) -> str:
    return "-" if value is None else number_text(value)


def _convergence(
    subject: AssessedMachine, Omega: float, inputs: Mapping[str, float], lost: Mapping[str, Any]
) -> list[Quantity]:
    """Return how much doubling the modes changes the largest averaged force; empty if the rotor has no further modes.

    In a backward whirl, the force depends on chance: two runs with the same modes differ just as much.
    """
    retained, most = elastic_shapes(subject.rotor)
    more = min(max(2 * retained, FEWEST), most)
    if subject.rotor.reduction.method == "none" or more <= retained:
        return []
    finer = assessed_machine_of(subject.file, subject.flavour, more)
    more, _ = elastic_shapes(finer.rotor)  # residual shapes included
    machines = {retained: subject, more: finer}
    runs = {n: simulate(item, Omega, inputs, end_time=CONVERGENCE, **lost) for n, item in machines.items()}
    forces = [_largest(run) for run in runs.values()]
    if not all(forces):
        reason = f"the rotor touches nothing within {CONVERGENCE:g} s without power, so there is no force to compare"
        return [Quantity("landing_force_change", "no contact", 0.0, "%", note=reason, chaotic=reason)]
    change = 100.0 * abs(forces[1] / forces[0] - 1.0)
    note = (
        f"{forces[0]:.4g} N with {retained} shapes per plane of motion, {forces[1]:.4g} N with {more} shapes; mean "
        f"over 1 ms"
    )
    whirling = " and ".join(f"{n} shapes" for n, run in runs.items() if _whirls_backward(run))
    reason = f"with {whirling} the rotor whirls backward, and the force of a backward whirl depends on chance"
    chaotic = reason if whirling else ""
    where = "largest force with twice the modes"
    return [Quantity("landing_force_change", where, change, "%", {}, note, chaotic=chaotic)]


def _whirls_backward(result: Result) -> bool:
    touchdown = result.summary.touchdown
    return touchdown is not None and bool(touchdown.whirls_backward_at)


def _largest(result: Result) -> float:
    return max((item or 0.0 for item in result.summary.averaged_contact_force.values()), default=0.0)
