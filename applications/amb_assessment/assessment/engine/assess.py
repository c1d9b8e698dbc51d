"""Assessment of a machine: each part is computed separately and judged by criteria; a failed part states its reason."""

from __future__ import annotations

import time
import traceback
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from amb_assessment.assessment.analyses import (
    axial,
    closed_loop,
    critical_map,
    cross_coupling,
    envelope,
    faults,
    free_modes,
    landing,
    recovery,
    rest,
    robustness,
    sensitivity,
    unbalance,
    vibration,
)
from amb_assessment.assessment.engine.conclusion import by_criterion, conclusion_of, failures
from amb_assessment.assessment.engine.findings import Finding, Judgement, judge
from amb_assessment.assessment.format.criteria import Criterion, check_criteria, criteria_by_file, own_criteria
from amb_assessment.assessment.format.machine_file import MachineFile, load_machine
from amb_assessment.assessment.format.quantities import AnalysisResult, ResultTable, check_declared
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, assessed_machine_of
from amb_assessment.assessment.physics.stability import instability
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.errors import FmuError, ProcessFailed, StartFailed, give_warnings
from amb_cosim.cosim.processes.blas import one_blas_thread
from amb_cosim.presentation.progress import PartsReport, parts_bar
from amb_files.checks import as_items, as_names, as_path, require_choice
from amb_files.suggestions import suggest


class Needs(IntEnum):
    """Requirements of an analysis; each value implies all values before it."""

    NOTHING, STABLE_LOOP, CONTACT_SITES = range(3)


class Analysis(NamedTuple):
    """An analysis of a machine: its title on the page, the function that returns its results, and what it needs."""

    title: str
    result_of: Callable[[AssessedMachine], AnalysisResult]
    needs: Needs = Needs.NOTHING


ANALYSES = {  # in the order of the page
    "free_modes": Analysis("Free-free modes, and positions of sensors and magnets", free_modes.result_of),
    "critical_map": Analysis("Undamped critical speeds over support stiffness", critical_map.result_of),
    "closed_loop": Analysis(
        "Closed loop over speed: damped frequencies and logarithmic decrements", closed_loop.result_of
    ),
    "cross_coupling": Analysis("Stability with cross coupling", cross_coupling.result_of),
    "unbalance": Analysis(
        "Unbalance response, amplification and separation margins", unbalance.result_of, Needs.STABLE_LOOP
    ),
    "envelope": Analysis(
        "Envelope: required and available forces, currents, voltages and slew rates",
        envelope.result_of,
        Needs.STABLE_LOOP,
    ),
    "sensitivity": Analysis("Sensitivity, computed and measured", sensitivity.result_of, Needs.STABLE_LOOP),
    "robustness": Analysis("Robustness: worst margins within the tolerances", robustness.result_of, Needs.STABLE_LOOP),
    "axial": Analysis("Axial axis: thrust bearing", axial.result_of),
    "axial_margins": Analysis("Axial axis: sensitivity, and worst margins", axial.margins, Needs.STABLE_LOOP),
    "vibration": Analysis("Vibration at speed in co-simulation", vibration.result_of, Needs.CONTACT_SITES),
    "faults": Analysis("Run-up, run-down and faults in co-simulation", faults.result_of, Needs.CONTACT_SITES),
    "landing": Analysis("Landing on the retainers", landing.result_of, Needs.CONTACT_SITES),
    "rest": Analysis("Landing to rest", rest.result_of, Needs.CONTACT_SITES),
    "recovery": Analysis("Relevitation and overload", recovery.result_of, Needs.CONTACT_SITES),
}


@dataclass(frozen=True)
class PartResult:
    """The results of one analysis, which is a part of an assessment.

    key, title
        Name of the part, as used in `only`, and its title on the page.
    result, findings
        Results, and the verdicts on them.
    reason
        Reason why the part failed; otherwise empty.
    wall
        Wall-clock time (s).
    """

    key: str
    title: str
    result: AnalysisResult
    findings: tuple[Finding, ...]
    reason: str = ""
    wall: float = 0.0


@dataclass(frozen=True)
class Assessment:
    """The results for a machine, judged by its criteria, and the warnings that a run of this machine would print.

    `own` contains the criteria from files that are not packaged.
    """

    machine: MachineFile
    facts: Mapping[str, float]
    criteria: tuple[Criterion, ...]
    parts: tuple[PartResult, ...]
    warnings: tuple[str, ...] = ()
    own: tuple[Criterion, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All verdicts."""
        return tuple(finding for part in self.parts for finding in part.findings)

    @property
    def failed(self) -> tuple[Finding, ...]:
        """Verdicts on failed criteria."""
        return tuple(finding for finding in self.findings if finding.verdict is Judgement.FAILED)

    @property
    def conclusion(self) -> str:
        """Whether the machine may run: how many of the criteria failed, and how many are unanswered."""
        parts = () if self._is_whole else [part.key for part in self.parts]
        return conclusion_of(self.findings, self.unanswered, parts, self.unmeasured)

    @property
    def _is_whole(self) -> bool:
        return [part.key for part in self.parts] == chosen_parts(self.machine)

    @property
    def failures(self) -> list[tuple[Finding, str]]:
        """The worst case of each failed criterion, and the sentence that describes this case."""
        return failures(self.findings)

    @property
    def unanswered(self) -> dict[str, str]:
        """The parts that failed, and the reason for each."""
        return {part.key: part.reason for part in self.parts if part.reason}

    @property
    def undecided(self) -> dict[str, str]:
        """The criteria that did not fail in any case but are unanswered in at least one, and the reason for each."""
        unanswered = [item for item in self.findings if item.verdict is Judgement.UNANSWERED]
        verdicts = by_criterion(self.findings)
        return self.unmeasured | {
            item.criterion.key: item.reason
            for item in reversed(unanswered)  # the first reason of each
            if item.criterion is not None and verdicts[item.criterion.key] is Judgement.UNANSWERED
        }

    @property
    def unevaluated(self) -> dict[str, str]:
        """Criteria without a verdict, and why: the formula fails, a loop is unstable, or the quantity is missing."""
        return self.unmeasured | {
            finding.criterion.key: finding.reason
            for finding in self.findings
            if finding.verdict is Judgement.UNANSWERED and finding.limit is None and finding.criterion is not None
        }

    @property
    def unmeasured(self) -> dict[str, str]:
        """The user's own criteria on quantities that no part computes, and the reason for each.

        A standard's criterion on such a quantity does not apply, so it is not listed. The result is empty if only some
        parts were chosen, because another part may compute the quantity.
        """
        if not self.own or not self._is_whole:
            return {}
        measured = {finding.measured.quantity for finding in self.findings}
        return {
            item.key: f"no computed part determines {item.quantity} for this machine"
            for item in self.own
            if item.quantity not in measured
        }

    @property
    def instability(self) -> str:
        """Description of the pole of the least stable loop, if any loop of the machine is unstable; otherwise empty."""
        radii = [finding.measured for finding in self.findings if finding.measured.quantity == "spectral_radius"]
        worst = max(radii, key=lambda radius: radius.value, default=None)
        return worst.where if worst is not None and worst.value > 1.0 else ""

    def counts(self) -> Counter[Judgement]:
        """Return the number of verdicts of each kind; a failed part counts as one unanswered verdict."""
        counts = Counter(finding.verdict for finding in self.findings)
        counts[Judgement.UNANSWERED] += len(self.unanswered)
        return counts

    def as_dict(self) -> dict[str, Any]:
        """Return the data for JSON."""
        return {
            "conclusion": self.conclusion,
            "failures": [sentence for _, sentence in self.failures],
            "machine": self.machine.model_dump(mode="json", exclude_none=True),
            "facts": dict(self.facts),
            "warnings": list(self.warnings),
            "unevaluated": self.unevaluated,
            "parts": {part.key: _part_data(part) for part in self.parts},
        }


@one_blas_thread()
def assess(
    machine: str | Path | MachineFile,
    *,
    only: str | Sequence[str] = (),
    criteria: str | Path | Sequence[str | Path] = (),
    flavour: Flavour = "native",
    progress: bool | PartsReport | None = None,
) -> Assessment:
    """Return verdicts on the modes, stability, unbalance response, margins, envelope and robustness of a machine.

    Parameters
    ----------
    machine
        A machine file, the name of a packaged machine, or the result of `load_machine`.
    only
        Name or names of the parts to compute; all by default.
    criteria
        One or more criteria files that replace those of the machine file or the package.
    flavour
        Flavour of the FMUs.
    progress
        Whether a bar is shown (default in a terminal and a notebook), or a function that is called with the title of
        the part that begins, the number of finished parts, and the number of all parts.

    Warns
    -----
    ModelWarning
        For each sentence of `warnings` of the result.

    Raises
    ------
    ValueError
        If the machine file, a criteria file or the name of a part is invalid. A failed part raises no exception; it is
        reported with a reason.

    Examples
    --------
    >>> part = assess("turbo_expander", only=["free_modes"]).parts[0]
    >>> [mode.where for mode in part.result.quantities]
    ['mode 1, 558 Hz, drive_end read at probe_de', 'mode 2, 1439 Hz, far_end read at probe_fe']
    """
    require_choice("flavour", flavour, FLAVOURS)
    file = machine if isinstance(machine, MachineFile) else load_machine(as_path("machine", machine))
    only, criteria = as_names("only", only), as_items(criteria)
    by_file = criteria_by_file([as_path("criteria", item) for item in criteria] or file.criteria)
    requested = tuple(item for of_file in by_file.values() for item in of_file)
    unknown = [name for name in only if name not in ANALYSES]
    if unknown:
        raise ValueError(f"no part {unknown[0]!r}; {suggest(unknown[0], ANALYSES)}")
    chosen, parts = chosen_parts(file, only), []
    with parts_bar(progress) as report:
        subject = check_machine(file, flavour)
        check_criteria(requested, subject.facts)
        why_unstable = cache(lambda: instability(subject))
        for done, name in enumerate(chosen):
            part = ANALYSES[name]
            report(part.title, done, len(chosen))
            parts.append(_answered(name, part, subject, requested, why_unstable))
    give_warnings(subject.prepared.warnings)
    return Assessment(file, subject.facts, requested, tuple(parts), subject.prepared.warnings, own_criteria(by_file))


def chosen_parts(file: MachineFile, only: Sequence[str] = ()) -> list[str]:
    """Return the names of the parts in `only`, or of all parts that concern the machine, in the order of the page."""
    excluded = () if file.thrust_bearing is not None else ("axial", "axial_margins")
    return [name for name in ANALYSES if (name in only if only else name not in excluded)]


def check_machine(file: MachineFile, flavour: Flavour = "native") -> AssessedMachine:
    """Return the machine that a file describes, after checking everything that all parts need.

    Raises
    ------
    ValueError
        If the machine's components do not match, if the machine begins with a fault, if it has fewer than two
        controlled magnetic bearings, or if it is tilted without gravity. The error is also raised if a stage or the
        thrust bearing is not at a part of the rotor, or if the thrust bearing's controller is wrong.
    """
    if file.shaft_tilt and not file.axial_gravity:
        raise ValueError(
            f"machine {file.name}: gravity = 0 m/s2 is not allowed with tilt = {file.tilt}, which only sets the "
            "direction of gravity; state the gravity as for a horizontal machine, such as gravity = '9.81 m/s^2', in "
            "the machine file"
        )
    subject = assessed_machine_of(file, flavour)
    _ = subject.loop.axes, subject.facts
    for stage in file.stages:
        subject.rotor.node_of(stage.at)
    if file.thrust_bearing is not None:
        _ = subject.rotor.node_of(file.thrust_bearing.at), subject.axial_control
    if faults := subject.faults:
        raise ValueError(
            f"machine {file.name} begins with a fault ({', '.join(faults)}); an assessment must begin without faults"
        )
    if len(subject.magnets) < 2:
        count = f"too few magnetic bearings under a controller ({len(subject.magnets)})"
        raise ValueError(f"machine {file.name} has {count}; an assessment requires two or more")
    return subject


def _answered(
    name: str,
    part: Analysis,
    subject: AssessedMachine,
    criteria: tuple[Criterion, ...],
    why_unstable: Callable[[], str],
) -> PartResult:
    begin = time.perf_counter()
    try:
        if part.needs >= Needs.STABLE_LOOP and (reason := why_unstable()):
            raise ValueError(f"{reason}; this part needs a rotor that levitates")
        if part.needs >= Needs.CONTACT_SITES and not subject.sites:
            raise ValueError(f"rotor {subject.rotor.name} has no [[sites]], so its possible contacts are unknown")
        result = part.result_of(subject)
        for item in result.quantities:
            check_declared(item.quantity, item.unit, item.facts)
        findings = tuple(judge(result.quantities, criteria, subject.facts, why_unstable))
    except (ValueError, RuntimeError, StartFailed, FmuError, ProcessFailed) as error:
        reason = str(error) or type(error).__name__
    except Exception as error:  # the other parts are still of use
        reason = _fault_of_program(error)
    else:
        return PartResult(name, part.title, result, findings, "", time.perf_counter() - begin)
    return PartResult(name, part.title, AnalysisResult(), (), reason, time.perf_counter() - begin)


def _fault_of_program(error: Exception) -> str:
    """Return a reason that says that the program, not the machine, is at fault, and where."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{Path(last.filename).name}, line {last.lineno}"
    return f"the program has an error, please report it: {type(error).__name__}: {error} ({where})"


def _part_data(part: PartResult) -> dict[str, Any]:
    return {
        "title": part.title,
        "not_answered_because": part.reason or None,
        "seconds": round(part.wall, 3),
        "findings": [_finding_data(item) for item in part.findings],
        "tables": [_table_data(item) for item in part.result.tables],
        "notes": list(part.result.notes),
    }


def _table_data(table: ResultTable) -> dict[str, Any]:
    return {"title": table.title, "heads": list(table.heads), "rows": [list(row) for row in table.rows]}


def _finding_data(finding: Finding) -> dict[str, Any]:
    data: dict[str, Any] = {
        "quantity": finding.measured.quantity,
        "where": finding.measured.where,
        "value": finding.measured.value,
        "unit": finding.measured.unit,
        "facts": dict(finding.measured.facts),
        "note": finding.measured.note,
        "verdict": finding.verdict.value,
    }
    if finding.criterion is not None:
        data |= {
            "limit": finding.limit,
            "zone": finding.zone or None,
            "reason": finding.reason or None,
            "advice": finding.advice or None,
            "criterion": finding.criterion.model_dump(mode="json"),
        }
    return data
