"""Landing on the retainers from full speed, for several phases and friction coefficients."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from amb_cosim.assessment.findings import AnalysisResult, Quantity, ResultTable
from amb_cosim.assessment.retainer_bearings import check_sites, load_panels, load_tables
from amb_cosim.assessment.runs import simulate, switched_off, worst_response
from amb_cosim.assessment.stages import note_on_stages
from amb_cosim.assessment.subject import Subject, rpm
from amb_cosim.reporting.panels import Panel, curve
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.result import Result
from amb_cosim.scenario.gravity import STANDARD_GRAVITY

TITLE = "Landing on the retainers"
PHASES = 4  # of a turn, at which the power is lost
FRICTIONS = (0.05, 0.15)
DURATION = 0.2  # s
BALLS = "of the largest force averaged over 1 ms, slow motion, rigid rings"


@dataclass(frozen=True)
class Landing:
    """A landing: friction, phase (deg), forces (N), backward whirl, contact elsewhere, heat (J), or its failure."""

    friction: float
    phase: float
    forces: Mapping[str, float] = field(default_factory=dict)
    whirls_backward: bool = False
    touches_elsewhere: bool = False
    heat: float = 0.0
    failure: str = ""

    @property
    def force(self) -> float:
        """The largest force of all sites (N)."""
        return max(self.forces.values(), default=0.0)

    @property
    def row(self) -> tuple[str, ...]:
        """The landing as texts."""
        if self.failure:
            return (f"{self.friction:g}", f"{self.phase:.0f}", self.failure, "", "", "")
        whirl, touch = ("yes" if item else "no" for item in (self.whirls_backward, self.touches_elsewhere))
        return (f"{self.friction:g}", f"{self.phase:.0f}", f"{self.force:.4g}", whirl, touch, f"{self.heat:.4g}")


def answer(subject: Subject) -> AnalysisResult:
    """Return peak force, backward whirl, contact elsewhere and heat of landings from the largest speed."""
    retainers = [site.name for site in subject.rotor.sites if site.bearing and site.name in subject.clearances]
    if not retainers:
        raise ValueError(f"rotor {subject.rotor.name} has no retainers; set the bearing of its sites")
    check_sites(subject.file.retainer_bearings, subject.clearances)
    Omega = subject.file.speed.highest
    inputs = worst_response(subject, Omega, Omega).unbalance.inputs
    cases = [(mu, k / PHASES) for mu in FRICTIONS for k in range(PHASES)]
    landings = [_landed(subject, Omega, inputs, mu, phase, retainers) for mu, phase in cases]
    done = [landing for landing in landings if not landing.failure]
    if not done:
        raise ValueError(landings[0].failure)
    weight, count = STANDARD_GRAVITY * subject.rotor.mass, len(landings)
    worst = max(done, key=lambda landing: landing.force)
    where = f"friction {worst.friction:g}, power lost at {worst.phase:.0f} deg"

    def share(quantity: str, number: int) -> Quantity:
        return Quantity(quantity, f"of {count} landings", 100.0 * number / count, "%")

    balls = subject.file.retainer_bearings
    bearings = [(item, max(landing.forces.get(item.at, 0.0) for landing in done)) for item in balls]
    measured = (
        share("landing_failed", count - len(done)),
        share("landing_backward_whirl", sum(landing.whirls_backward for landing in done)),
        share("landing_contact_elsewhere", sum(landing.touches_elsewhere for landing in done)),
        Quantity("landing_force", where, worst.force / weight, "1", {"weight": weight}, "over the rotor's weight"),
        Quantity("landing_heat", f"largest within {DURATION:g} s", max(landing.heat for landing in done), "J"),
        *(
            Quantity("landing_ball_pressure", item.at, item.pressure(force), "MPa", note=BALLS)
            for item, force in bearings
        ),
    )
    curves = tuple(
        curve(f"friction {mu:g}", *_points([landing for landing in done if landing.friction == mu], weight), "dots")
        for mu in FRICTIONS
    )
    heads = ("friction", "phase (deg)", "force (N)", "backward whirl", "touches elsewhere", "heat (J)")
    notes = (
        f"All amplifiers lose their power at {rpm(Omega):.0f} 1/min; the first {DURATION:g} s of the landing are "
        f"simulated, with only the modes of the rotor file's reduction. Forces are averaged over 1 ms, which "
        f"converges, unlike peaks within an impact. The drive remains on.",
        "Retainers without mounts are rigid. The force of a rotor that rolls backward in them is unbounded: values "
        "above a thousand times the weight are meaningless.",
        *note_on_stages(subject),
    )
    panel = Panel("Largest force of each landing", "phase of the power loss (deg)", "over the weight", curves)
    table = ResultTable("Landings", heads, tuple(landing.row for landing in landings))
    return AnalysisResult(measured, (panel, *load_panels(bearings)), (table, *load_tables(bearings)), notes)


def _points(landings: list[Landing], weight: float) -> tuple[list[float], list[float]]:
    return [item.phase for item in landings], [item.force / weight for item in landings]


def _landed(
    subject: Subject, Omega: float, inputs: dict[str, float], mu: float, phase: float, retainers: list[str]
) -> Landing:
    fields = switched_off(subject, 1.0 + phase)
    fields["parameters"] = fields["parameters"] | {PLANT: {"*.mu": mu}}
    degrees = float(360.0 * phase)
    try:
        result = simulate(subject, Omega, inputs, end_time=DURATION, **fields)
    except ValueError as error:
        return Landing(mu, degrees, failure=str(error))
    return _of_run(result, mu, degrees, retainers)


def _of_run(result: Result, mu: float, degrees: float, retainers: list[str]) -> Landing:
    summary = result.summary
    forces = {site: float(item or 0.0) for site, item in summary.averaged_contact_force.items()}
    matches = summary.touchdown.retainers.values() if summary.touchdown is not None else ()
    return Landing(
        mu,
        degrees,
        forces,
        any(item.whirl == "backward" for item in matches),
        any((share or 0.0) > 0.0 for site, share in summary.site_share.items() if site not in retainers),
        sum(item.heat or 0.0 for item in matches),
    )
