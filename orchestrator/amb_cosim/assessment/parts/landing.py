"""Landing on the retainers from full speed, from several phases and with several frictions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amb_cosim.assessment.findings import PartResult, PartTable, Quantity
from amb_cosim.assessment.runs import simulate, switched_off, unbalance_inputs, worst_case
from amb_cosim.assessment.subject import Subject, rpm
from amb_cosim.reporting.panels import Panel, curve
from amb_cosim.results.places import PLANT
from amb_cosim.results.result import Result

TITLE = "Landing on the retainers"
PHASES = 4  # of a turn, at which the power is lost
FRICTIONS = (0.05, 0.15)
DURATION = 0.2  # s
GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Landing:
    """One landing: friction, phase (deg), force (N), backward whirl, contact elsewhere, heat (J); or why it failed."""

    friction: float
    phase: float
    force: float = 0.0
    whirls_backward: bool = False
    touches_elsewhere: bool = False
    heat: float = 0.0
    failure: str = ""

    @property
    def row(self) -> tuple[str, ...]:
        """The landing as texts."""
        if self.failure:
            return (f"{self.friction:g}", f"{self.phase:.0f}", self.failure, "", "", "")
        whirl, touch = ("yes" if item else "no" for item in (self.whirls_backward, self.touches_elsewhere))
        return (f"{self.friction:g}", f"{self.phase:.0f}", f"{self.force:.4g}", whirl, touch, f"{self.heat:.4g}")


def answer(subject: Subject) -> PartResult:
    """Return peak force, backward whirl, contact elsewhere and heat of landings from the largest speed."""
    retainers = [site.name for site in subject.rotor.sites if site.bearing and site.name in subject.clearances]
    if not retainers:
        raise ValueError(f"rotor {subject.rotor.name} has no retainers: give its sites their bearing")
    Omega = subject.file.speed.highest
    inputs = unbalance_inputs(subject, worst_case(subject, Omega))
    cases = [(mu, k / PHASES) for mu in FRICTIONS for k in range(PHASES)]
    landings = [_landed(subject, Omega, inputs, mu, phase, retainers) for mu, phase in cases]
    done = [one for one in landings if not one.failure]
    if not done:
        raise ValueError(landings[0].failure)
    weight, count = GRAVITY * subject.rotor.mass, len(landings)
    worst = max(done, key=lambda one: one.force)
    where = f"friction {worst.friction:g}, power lost at {worst.phase:.0f} deg"

    def share(quantity: str, number: int) -> Quantity:
        return Quantity(quantity, f"of {count} landings", 100.0 * number / count, "%")

    measured = (
        share("landing_failed", count - len(done)),
        share("landing_backward_whirl", sum(one.whirls_backward for one in done)),
        share("landing_contact_elsewhere", sum(one.touches_elsewhere for one in done)),
        Quantity("landing_force", where, worst.force / weight, "1", {"weight": weight}, "over the rotor's weight"),
        Quantity("landing_heat", f"largest within {DURATION:g} s", max(one.heat for one in done), "J"),
    )
    curves = tuple(
        curve(f"friction {mu:g}", *_points([one for one in done if one.friction == mu], weight), "dots")
        for mu in FRICTIONS
    )
    heads = ("friction", "phase (deg)", "force (N)", "backward whirl", "touches elsewhere", "heat (J)")
    notes = (
        f"All amplifiers lose their power at {rpm(Omega):.0f} 1/min; the first {DURATION:g} s are simulated, not the "
        "way to rest, with the modes of the rotor file's reduction alone. Forces are averaged over 1 ms, which "
        "converges where peaks within an impact do not. The drive goes on.",
        "Retainers without mounts are rigid: a rotor that rolls backward in them has no bound, and forces beyond a "
        "thousand times the weight say that, not how large they are.",
        *subject.note_on_stages,
    )
    panel = Panel("Largest force of each landing", "phase of the power loss (deg)", "over the weight", curves)
    table = PartTable("Landings", heads, tuple(one.row for one in landings))
    return PartResult(measured, (panel,), (table,), notes)


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
    force = np.max([item or 0.0 for item in summary.averaged_contact_force.values()], initial=0.0)
    matches = summary.touchdown.retainers.values() if summary.touchdown is not None else ()
    return Landing(
        mu,
        degrees,
        float(force),
        any(item.whirl == "backward" for item in matches),
        any((share or 0.0) > 0.0 for site, share in summary.site_share.items() if site not in retainers),
        sum(item.heat or 0.0 for item in matches),
    )
