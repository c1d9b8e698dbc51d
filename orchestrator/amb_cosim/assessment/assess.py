"""Assesses a machine: every part answered by itself, judged by criteria; a part that fails is not answered, because."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from amb_cosim.assessment.criteria import Criterion, load_criteria
from amb_cosim.assessment.findings import Finding, Judgement, PartResult, PartTable, judge
from amb_cosim.assessment.machine_file import MachineFile, load_machine
from amb_cosim.assessment.subject import Subject
from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.basics.errors import FmuError, ProcessFailed, StartFailed
from amb_files.suggestions import suggest

PARTS = (
    "free_modes",
    "critical_map",
    "closed_loop",
    "cross_coupling",
    "unbalance",
    "envelope",
    "sensitivity",
    "robustness",
    "vibration",
    "faults",
    "landing",
    "rest",
    "recovery",
)
OF_CLEARANCES = frozenset({"vibration", "faults", "landing", "rest", "recovery"})  # parts about where it can touch

ProgressCallback = Callable[[str, int, int], None]  # title of the part under way, parts done, their number


@dataclass(frozen=True)
class AssessmentPart:
    """A part of an assessment.

    key, title
        Name for `only`, and title on the page.
    answer, findings
        What it found, and the verdicts on that.
    reason
        Why it is not answered; empty where it is.
    wall
        Time that it took (s).
    """

    key: str
    title: str
    answer: PartResult
    findings: tuple[Finding, ...]
    reason: str = ""
    wall: float = 0.0


@dataclass(frozen=True)
class Assessment:
    """What became of a machine under its criteria."""

    machine: MachineFile
    facts: Mapping[str, float]
    criteria: tuple[Criterion, ...]
    parts: tuple[AssessmentPart, ...]

    @property
    def findings(self) -> tuple[Finding, ...]:
        """All verdicts."""
        return tuple(finding for part in self.parts for finding in part.findings)

    @property
    def missed(self) -> tuple[Finding, ...]:
        """Verdicts on what is missed."""
        return tuple(finding for finding in self.findings if finding.verdict is Judgement.MISSED)

    @property
    def unanswered(self) -> dict[str, str]:
        """Parts that are not answered, and why."""
        return {part.key: part.reason for part in self.parts if part.reason}

    def counts(self) -> Counter[Judgement]:
        """Return how many verdicts of each kind there are; a part that is not answered is one."""
        counts = Counter(finding.verdict for finding in self.findings)
        counts[Judgement.UNANSWERED] += len(self.unanswered)
        return counts

    def as_dict(self) -> dict[str, Any]:
        """Return the data for JSON."""
        return {
            "machine": self.machine.model_dump(mode="json", exclude_none=True),
            "facts": dict(self.facts),
            "parts": {part.key: _part_data(part) for part in self.parts},
        }


def assess(
    machine: str | Path | MachineFile,
    *,
    only: Sequence[str] = (),
    criteria: Sequence[str | Path] = (),
    flavour: Flavour = "native",
    progress: ProgressCallback | None = None,
) -> Assessment:
    """Return verdicts on a machine: modes, stability, unbalance response, margins, envelope, sensitivity, robustness.

    Parameters
    ----------
    machine
        A machine file, the name of a machine of a pack, or what `load_machine` returned.
    only
        Names of parts; all without.
    criteria
        Files of criteria in place of those that the machine file names, or that come with the package.
    flavour
        Flavour of the FMUs.
    progress
        Called with the title of the part under way, the parts done, and their number.

    Raises
    ------
    ValueError
        If the machine file, a file of criteria or a name is wrong. A part that fails is no exception: it is not
        answered, with a reason.
    """
    file = machine if isinstance(machine, MachineFile) else load_machine(machine)
    requested = load_criteria(criteria or file.criteria)
    unknown = [name for name in only if name not in PARTS]
    if unknown:
        raise ValueError(f"no part {unknown[0]!r}; {suggest(unknown[0], PARTS)}")
    subject = check_machine(file, flavour)
    chosen = [name for name in PARTS if not only or name in only]
    parts = []
    for done, name in enumerate(chosen):
        module = import_module(f"amb_cosim.assessment.parts.{name}")
        if progress is not None:
            progress(module.TITLE, done, len(chosen))
        parts.append(_answered(name, module.TITLE, module.answer, subject, requested))
    return Assessment(file, subject.facts, requested, tuple(parts))


def check_machine(file: MachineFile, flavour: Flavour = "native") -> Subject:
    """Return the machine of a file, after a look at everything that all parts need.

    Raises
    ------
    ValueError
        If its components do not fit, it has less than two magnetic bearings under a controller, or a stage is at no
        part of the rotor.
    """
    subject = Subject(file, flavour)
    _ = subject.loop.axes, subject.facts
    for stage in file.stages:
        subject.node_of(stage.at)
    if len(subject.magnets) < 2:
        count = f"{len(subject.magnets)} magnetic bearings under a controller"
        raise ValueError(f"machine {file.name} has {count}; an assessment takes two or more")
    return subject


def _answered(
    name: str, title: str, ask: Callable[[Subject], PartResult], subject: Subject, criteria: tuple[Criterion, ...]
) -> AssessmentPart:
    begin = time.perf_counter()
    try:
        if name in OF_CLEARANCES and not subject.clearances:
            raise ValueError(f"rotor {subject.rotor.name} has no [[sites]]: where it can touch is not known")
        answer = ask(subject)
        findings = tuple(judge(answer.measured, criteria, subject.facts))
    except (ValueError, LookupError, ArithmeticError, RuntimeError, StartFailed, FmuError, ProcessFailed) as error:
        reason = str(error) or type(error).__name__
        return AssessmentPart(name, title, PartResult(), (), reason, time.perf_counter() - begin)
    return AssessmentPart(name, title, answer, findings, "", time.perf_counter() - begin)


def _part_data(part: AssessmentPart) -> dict[str, Any]:
    return {
        "title": part.title,
        "not_answered_because": part.reason or None,
        "seconds": round(part.wall, 3),
        "findings": [_finding_data(item) for item in part.findings],
        "tables": [_table_data(item) for item in part.answer.tables],
        "notes": list(part.answer.notes),
    }


def _table_data(one: PartTable) -> dict[str, Any]:
    return {"title": one.title, "heads": list(one.heads), "rows": [list(row) for row in one.rows]}


def _finding_data(one: Finding) -> dict[str, Any]:
    data: dict[str, Any] = {
        "quantity": one.measured.quantity,
        "where": one.measured.where,
        "value": one.measured.value,
        "unit": one.measured.unit,
        "facts": dict(one.measured.facts),
        "note": one.measured.note,
        "verdict": one.verdict.value,
    }
    if one.criterion is not None:
        data |= {
            "limit": one.limit,
            "zone": one.zone or None,
            "reason": one.reason or None,
            "advice": one.advice or None,
            "criterion": one.criterion.model_dump(mode="json"),
        }
    return data
