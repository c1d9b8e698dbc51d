"""Landing on the retainers from full speed, for several phases and friction coefficients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from amb_assessment.assessment.format.quantities import AnalysisResult, Quantity, ResultTable, declare
from amb_assessment.assessment.format.retainer_bearings import check_sites, load_panels, load_tables
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.runs import (
    check_falls,
    end_of,
    longest,
    simulate,
    upright,
    without_power,
    worst_inputs,
)
from amb_assessment.assessment.physics.whirl_friction import chance, whirl_facts, whirl_friction
from amb_assessment.reporting.page_parts import number_text
from amb_assessment.reporting.panels import Panel, curve
from amb_cosim.results.result import Result
from amb_cosim.scenario.gravity import STANDARD_GRAVITY

declare("landing_failed", "%", ("whirl_friction", "friction"))
declare("landing_backward_whirl", "%", ("whirl_friction", "friction"), "Landings that whirl backward")
declare("landing_contact_elsewhere", "%", ("whirl_friction", "friction"))
declare("landing_force", "1", ("weight",), "Largest contact force of a landing")
declare("landing_heat", "J", ("weight",), "Heat that a landing generates in the retainers")
declare("landing_ball_pressure", "MPa")

PHASES = 4  # of a turn, at which the power is lost
FRICTIONS = (0.05, 0.15)
FIRST, LONGEST, MOST_STEPS = 0.4, 2.0, 100_000  # s, s, and steps, over which a landing is simulated
TOGETHER = "; the largest radial and the largest axial force are assumed to act together"
BALLS = "of the largest force averaged over 1 ms, slow motion, rigid rings"


@dataclass(frozen=True)
class Landing:
    """A landing.

    friction, phase
        Friction coefficient, and phase at which the power is lost (deg).
    forces, heat
        Largest force at each site (N), and heat in the retainers (J).
    whirls_backward, rests, rocks_within
        How the landing ended: in backward whirl, at rest, or rocking steadily to and fro within an angle (deg). If none
        of these applies, the landing has not ended.
    touches, stators
        Sites other than retainers and faces that were touched, and magnetic bearings whose stator was touched.
    failure
        Reason for an early end of the simulation; otherwise empty.
    """

    friction: float
    phase: float
    forces: Mapping[str, float] = field(default_factory=dict)
    whirls_backward: bool = False
    rests: bool = False
    rocks_within: float | None = None
    touches: tuple[str, ...] = ()
    stators: tuple[str, ...] = ()
    heat: float = 0.0
    failure: str = ""

    @property
    def is_final(self) -> bool:
        """Whether the outcome is final: the run failed, the rotor whirls backward, or the rotor is at rest."""
        return self.whirls_backward or self.rests or bool(self.failure)

    @property
    def has_ended(self) -> bool:
        """Whether the outcome is final, or the rotor rocks steadily."""
        return self.is_final or self.rocks_within is not None

    @property
    def force(self) -> float:
        """The largest force at any site (N)."""
        return max(self.forces.values(), default=0.0)

    @property
    def row(self) -> tuple[str, ...]:
        """The cells of the landing's row in the table."""
        if self.failure:
            return (f"{self.friction:g}", f"{self.phase:.0f}", self.failure, "", "", "")
        rocking = "not ended" if self.rocks_within is None else f"swings up to {self.rocks_within:.0f} deg"
        end = "backward whirl" if self.whirls_backward else "at rest" if self.rests else rocking
        touched = ", ".join(self.touches) or "nothing"
        return (
            f"{self.friction:g}",
            f"{self.phase:.0f}",
            number_text(self.force),
            end,
            touched,
            number_text(self.heat),
        )


def result_of(subject: AssessedMachine) -> AnalysisResult:
    """Return the smallest friction that causes whirl, and data on all landings: force, whirl, other contacts, heat."""
    if not subject.retainers:
        raise ValueError(f"rotor {subject.rotor.name} has no retainers; set `bearing` for its [[sites]]")
    check_falls(subject)
    check_sites(subject.file.retainer_bearings, subject.sites)
    Omega = subject.file.speed.highest
    inputs = worst_inputs(subject)
    cases = [(mu, k / PHASES) for mu in FRICTIONS for k in range(PHASES)]
    landings = [_landed(subject, inputs, mu, phase) for mu, phase in cases]
    done = [landing for landing in landings if not landing.failure]
    if not done:
        raise ValueError(landings[0].failure)
    weight, count = STANDARD_GRAVITY * subject.rotor.mass, len(landings)
    worst = max(done, key=lambda landing: landing.force)
    where = f"friction {worst.friction:g}, power lost at {worst.phase:.0f} deg"

    followed, open_ended = longest(subject, LONGEST, MOST_STEPS), sum(not landing.has_ended for landing in landings)
    not_ended = f"{open_ended} of {count} landings have not ended within {followed:.3g} s" if open_ended else ""
    no_landing = upright(subject)
    least = whirl_friction(subject, max(FRICTIONS))

    def share(quantity: str, number: int, reason: str) -> Quantity:
        return Quantity(
            quantity,
            f"of {count} landings",
            100.0 * number / count,
            "%",
            whirl_facts(least),
            no_landing or not_ended,
            reason,
            no_landing,
        )

    balls = subject.file.retainer_bearings
    by_chance = chance(least)
    judged = [
        landing for landing in landings if not (by_chance and landing.whirls_backward)
    ]  # chance decides which whirl
    bearings = [(item, _largest(judged, [item.at]), _largest(judged, subject.faces_at(item.at))) for item in balls]
    may_change, heat = by_chance or not_ended, max(landing.heat for landing in done)
    measured = (
        least,
        share("landing_failed", sum(bool(landing.failure or landing.stators) for landing in judged), may_change),
        share("landing_backward_whirl", sum(landing.whirls_backward for landing in done), ""),
        share("landing_contact_elsewhere", sum(bool(landing.touches) for landing in judged), may_change),
        Quantity(
            "landing_force",
            where,
            worst.force / weight,
            "1",
            {"weight": weight},
            "over the rotor's weight",
            upright(subject),
        ),
        Quantity("landing_heat", f"largest within {followed:.3g} s", heat, "J", {"weight": weight}),
        *(
            Quantity(
                "landing_ball_pressure",
                item.at,
                item.pressure(force, axial),
                "MPa",
                note=f"{BALLS}{TOGETHER if axial else ''}",
                may_worsen_because=by_chance or upright(subject),
            )
            for item, force, axial in bearings
        ),
    )
    curves = tuple(
        curve(f"friction {mu:g}", *_points([landing for landing in done if landing.friction == mu], weight), "dots")
        for mu in FRICTIONS
    )
    heads = ("friction", "phase (deg)", "force (N)", "end", "touches elsewhere", "heat (J)")
    notes = (
        f"All magnets lose power at {rpm(Omega):.0f} rpm. A landing is simulated until the rotor whirls "
        f"backward or lies at rest, for at most {followed:.3g} s, with only the modes of the rotor file's reduction. A "
        "landing also counts as ended if the rotor then rocks steadily: in the last quarter of the time it swings to "
        "and fro by less than 90 deg, and this limit would hold for twice the time even if the swing kept growing. "
        "Forces are averaged over 1 ms; these averages converge, unlike peaks within an impact. The motor that drives "
        "the rotor keeps its power; it loses it, too, in the part `rest`.",
        "Chance decides in which landings the rotor whirls backward: even rounding changes the outcome. However, the "
        "least friction with which a falling rotor can roll over the top of its retainers depends only on the machine. "
        "With less than half of this friction, the rotor whirled in none of 90 simulated landings. The least "
        "friction must therefore be at least twice the friction of the landings. Otherwise, the landings with backward "
        "whirl are counted. In these, contact outside the retainers changes no verdict, because the whirl itself fails "
        "its criterion.",
        "Retainers without mounts are rigid. The force of a rotor that rolls backward in them is unbounded: values "
        "above a thousand times the weight are meaningless.",
    )
    panel = Panel("Largest force of each landing", "phase of the power loss (deg)", "over the weight", curves, log="y")
    table = ResultTable("Landings", heads, tuple(landing.row for landing in landings))
    return AnalysisResult(measured, (panel, *load_panels(bearings)), (table, *load_tables(bearings)), notes)


def _largest(landings: Sequence[Landing], places: Sequence[str]) -> float:
    """Return the largest force (N) at any of the `places` in any landing; 0 without places or landings."""
    return max((landing.forces.get(place, 0.0) for landing in landings for place in places), default=0.0)


def _points(landings: list[Landing], weight: float) -> tuple[list[float], list[float]]:
    return [item.phase for item in landings], [item.force / weight for item in landings]


def _landed(subject: AssessedMachine, inputs: dict[str, float], mu: float, phase: float) -> Landing:
    fields, Omega = without_power(subject, 1.0 + phase, mu), subject.file.speed.highest
    most, landing, end = longest(subject, LONGEST, MOST_STEPS), Landing(mu, float(360.0 * phase)), None
    for duration in dict.fromkeys((min(FIRST, most), most)):
        goes_on = duration < most
        try:
            result = simulate(subject, Omega, inputs, end_time=duration, start=end, goes_on=goes_on, **fields)
        except ValueError as error:
            return replace(landing, failure=str(error))
        end = end_of(result)
        landing = _with_results(result, landing, subject.lands_on)
        if landing.is_final:
            break
    return landing


def _with_results(result: Result, landing: Landing, lands_on: Sequence[str]) -> Landing:
    """Return a landing with the results of its run."""
    summary, touchdown = result.summary, result.summary.touchdown
    touched = {} if touchdown is None else touchdown.retainers
    return replace(
        landing,
        forces={site: float(item or 0.0) for site, item in summary.averaged_contact_force.items()},
        whirls_backward=touchdown is not None and bool(touchdown.whirls_backward_at),
        rests=touchdown is not None and touchdown.rest_after is not None,
        rocks_within=None if touchdown is None else touchdown.rocks_within,
        touches=tuple(site for site in touched if site not in lands_on),
        stators=tuple(touch.bearing for touch in summary.stators.values()),
        heat=sum(item.heat or 0.0 for item in touched.values()),
    )
