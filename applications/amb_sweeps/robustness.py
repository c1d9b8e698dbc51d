"""Robustness of a scenario's outcome to small changes of its values, and to the use of H identified in its loop.

If such a change flips the outcome, the outcome is called *fragile*: it depends as much on the exact values of the input
as on the machine. The outcome of a run with contact is called *robust* only if friction, restitution and the phase of
the disturbance were varied, too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, ClassVar

from amb_analysis.studies.receptance_identification import identify
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import Progress, RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.model_constants.receptance_file import ReceptanceTable
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.progress import progress_bar
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.presentation.units import speed_unit
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_files.checks import require
from amb_files.plain_values import plain_values
from amb_sweeps.contact_variations import DECISIVE, WITHOUT_EFFECT, Tolerances, contact_variations
from amb_sweeps.event_phases import undetected_share, with_labels
from amb_sweeps.variations import Variation, identification_speeds, variations
from amb_sweeps.worker import PointResult, Runner, Task

AS_IT_IS = "as it is"
UNDECIDED = "undecided"  # first word of such an outcome
IN_PART = "robust in part"  # verdict if a quantity that decides a contact was not varied
FORCE, SAMPLED_FORCE, ORBIT = "averaged_contact_force.", "peak_contact_force.", "orbit_largest."  # metrics of a place


@dataclass(frozen=True)
class RobustnessRow:
    """A run.

    changed
        The change from the scenario.
    outcome
        Outcome, whether the rotor has rolled (unless the outcome is `rolled`), and the sites in contact.
    reason
        Reason for an early end; otherwise empty.
    last_contact
        Cycle of the last contact; None if there was none.
    contact_force
        Largest contact force (1 ms mean with impacts) at each site with contact; the largest sample without this mean.
    orbit
        Largest orbit at each bearing.
    """

    changed: str
    outcome: str
    reason: str
    last_contact: float | None
    contact_force: Annotated[dict[str, float], "N"]
    orbit: Annotated[dict[str, float], "mm"]


@dataclass(frozen=True, eq=False, repr=False)
class Robustness(WarnedResult, DrawnResult):
    """Outcomes of a scenario and of its variations.

    scenario
        Name of the scenario.
    change
        Fraction by which quantities were changed, one at a time, unless `varied` states another change.
    rows
        The run of the scenario, followed by the runs of its variations.
    not_varied
        Reasons why quantities were not varied, by name.
    varied
        By how much each quantity was varied, by name.
    phases
        Number of phases of the disturbance that were run; 1 if its phase was not varied.
    """

    name: ClassVar[str] = "robustness"

    scenario: str
    change: float
    rows: tuple[RobustnessRow, ...]
    not_varied: dict[str, str]
    varied: dict[str, str] = field(default_factory=dict)
    phases: int = 1

    @property
    def outcome(self) -> str:
        """Outcome of the unchanged scenario."""
        return self.rows[0].outcome

    @property
    def flips(self) -> dict[str, str]:
        """Decided outcomes that differ from the scenario's, by change; empty if the scenario's outcome is undecided."""
        if AS_IT_IS in self.undecided:
            return {}
        differing = (row for row in self.rows if row.outcome != self.outcome and row.changed not in self.undecided)
        return {row.changed: row.outcome for row in differing}

    @property
    def undecided(self) -> list[str]:
        """Changes whose runs end too early for an outcome."""
        return [row.changed for row in self.rows if row.outcome.startswith(UNDECIDED)]

    @property
    def untested(self) -> list[str]:
        """Quantities that may decide a contact and were not varied; empty for a scenario without contact."""
        return [name for name in DECISIVE if self.not_varied.get(name, WITHOUT_EFFECT) != WITHOUT_EFFECT]

    @property
    def verdict(self) -> str:
        """`fragile` if a variation flips the outcome; `undecided` if a run ends too early; otherwise `robust`.

        If the outcome of a run with contact never differs, but `untested` has quantities, it is `robust in part`.
        """
        return "fragile" if self.flips else UNDECIDED if self.undecided else IN_PART if self.untested else "robust"

    def text(self) -> list[TextBlock]:
        """Return a table of the runs, the quantities varied and not varied, and the verdict."""
        sites = list(dict.fromkeys(site for row in self.rows for site in row.contact_force))
        places = list(dict.fromkeys(bearing for row in self.rows for bearing in row.orbit))
        headings = [*(f"{name_label(site)} (N)" for site in sites), *(f"{name_label(at)} (mm)" for at in places)]
        columns = ("changed", "outcome", "last contact (cycle)", *headings)
        table = text_table(f"Robustness of {self.scenario}", columns, left=("changed", "outcome"))
        for row in self.rows:
            last = "-" if row.last_contact is None else f"{row.last_contact:.1f}"
            figures = [*(row.contact_force.get(site) for site in sites), *(row.orbit.get(at) for at in places)]
            table.add_row(row.changed, row.reason or row.outcome, last, *(number(value) for value in figures))
        not_varied = [f"not varied: {name}, {reason}" for name, reason in self.not_varied.items()]
        extents = ", ".join(f"{name} {extent}".rstrip() for name, extent in self.varied.items() if name != "phase")
        varied = [f"varied: {extents}{', ' * bool(extents)}{self.varied.get('phase', '')}".removesuffix(", ")]
        if self.phases > 1:
            share = 100.0 * undetected_share(self.phases)
            varied.append(
                f"{self.phases} phases with one outcome leave another one possible in up to {share:.2g} % of all"
            )
        flips = "; ".join(f"{changed}: {outcome}" for changed, outcome in self.flips.items())
        verdict = {
            "fragile": f"fragile: {flips}",
            "undecided": f"undecided; extend the scenario: {', '.join(self.undecided)}",
            IN_PART: f"robust in part: every run is {self.outcome}, but not varied: {', '.join(self.untested)}",
            "robust": f"robust: every run is {self.outcome}",
        }[self.verdict]
        return [
            table,
            "largest contact force of each site (1 ms mean with impacts), largest orbit at each bearing and retainer",
            *(varied if self.varied else []),
            *not_varied,
            verdict,
            *self.warning_lines(),
        ]


def robustness(
    scenario: Scenario | str | Path | None = None,
    *,
    rotor: RotorSource = None,
    set: Mapping[str, Raw] | None = None,
    change: float = 0.01,
    friction: float | None = None,
    restitution: float | None = None,
    phases: int = 32,
    flavour: Flavour = "native",
    progress: bool | Progress | None = None,
) -> Robustness:
    """Return whether a scenario keeps its outcome if H is identified in its loop, or if quantities change slightly.

    K_b, C_b, alpha, clearances and unbalances are changed one at a time. If the rotor touches, friction, restitution,
    the phase of the disturbance, and the properties of mounts, races and compliant contact are changed as well.
    Quantities that the machine lacks are not varied.

    Parameters
    ----------
    scenario
        A scenario, its name in a pack, or a TOML file; the packs' default scenario by default.
    rotor
        Name of a packaged rotor, or a rotor file, to use instead of the scenario's.
    set
        Values by `component.variable` that replace the scenario's.
    change
        Fraction by which each quantity is changed, from 1e-6 to 0.5.
    friction, restitution
        Fraction by which friction is changed, and amount by which coefficients of restitution are changed, from 0 (not
        at all) to 0.5; by default 0.2 and 0.1 if magnets lose their power, otherwise `change`.
    phases
        Number of phases within a turn at which the disturbance happens, from 1 (its own) to 360. The phase of a change
        of unbalance alone is not varied, because it turns with the rotor.
    flavour
        Flavour of the FMUs.
    progress
        Whether to show a bar (default in a terminal and a notebook), or a function called with the numbers of finished
        and of all runs.

    Raises
    ------
    ValueError
        If the scenario, a value or a file is invalid, or the run of the scenario does not reach its end.
    """
    require(1e-6 <= change <= 0.5, "change", change, "from 1e-6 to 0.5")
    for name, value in (("friction", friction), ("restitution", restitution)):
        require(value is None or 0.0 <= value <= 0.5, name, value, "from 0 to 0.5")
    require(1 <= phases <= 360, "phases", phases, "from 1 to 360")
    scenario = with_labels(as_scenario(scenario, rotor))
    settings, tolerances = plain_values(set, "set"), Tolerances(change, friction, restitution, phases)
    runner = Runner(Task(scenario, settings, options=RunOptions(flavour=flavour), labels=scenario.labels))
    try:
        with progress_bar(progress) as report:
            prepared = runner.plan({})
            base = runner.run(0, {})
            rows = [_row(Variation(AS_IT_IS, {}), base)]
            if rows[0].reason:
                raise ValueError(f"scenario {scenario.name}: {rows[0].reason}")
            touches = base.metrics.get("contact") != 0.0  # or unknown, of a plant from elsewhere
            varied = variations(prepared, settings, change, partial(_identified, scenario, settings, prepared, flavour))
            if touches:
                varied = varied.with_others(contact_variations(prepared, tolerances))
            for k, case in enumerate(varied.made, 1):
                report(k, 1 + len(varied.made))
                rows.append(_row(case, runner.run(k, case.settings)))
            report(len(rows), len(rows))
    finally:
        runner.close()
    return Robustness(
        *(scenario.name, change, tuple(rows), dict(varied.left_out), dict(varied.extents)),
        phases=phases if "phase" in varied.extents else 1,
        warnings=prepared.warnings,
    )


def _identified(
    scenario: Scenario, settings: Mapping[str, Raw], prepared: ScenarioPlan, flavour: Flavour
) -> ReceptanceTable:
    """Return the receptances that are identified in a scenario's sampled loop at `identification_speeds`."""
    speeds = identification_speeds(prepared)
    identification = identify(speeds, scenario=scenario, set=settings, flavour=flavour, progress=False)
    for result in identification.results:
        if result.reason:
            raise ValueError(f"at {speed_unit().text(result.speed)}: {result.reason}")
    return identification.table


def _row(case: Variation, point: PointResult) -> RobustnessRow:
    values = {name: float(value) for name, value in point.metrics.items() if not math.isnan(value)}
    averaged, sampled, orbit = (_at_places(values, prefix) for prefix in (FORCE, SAMPLED_FORCE, ORBIT))
    forces = sampled | averaged
    touched = [site for site, force in forces.items() if force > 0.0]
    rolls = "rolling" * (bool(values.get("rolling")) and point.outcome != "rolled")
    touches = f"touching {' '.join(touched)}" * bool(touched)
    reason = point.reason if point.outcome in ("failed", "invalid") else ""
    return RobustnessRow(
        changed=case.name,
        outcome=", ".join(filter(None, (point.outcome, rolls, touches))),
        reason=reason,
        last_contact=values.get("last_contact"),
        contact_force={site: forces[site] for site in touched},
        orbit=orbit,
    )


def _at_places(values: Mapping[str, float], prefix: str) -> dict[str, float]:
    """Return the values whose names begin with a prefix, by the rest of the name, which is the place."""
    return {name.removeprefix(prefix): value for name, value in values.items() if name.startswith(prefix)}
