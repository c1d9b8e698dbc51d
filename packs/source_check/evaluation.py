"""Computation and judgement of statements, and the data of the report."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, get_args

from amb_cosim.cosim.run.options import Progress
from amb_cosim.scenario.scenario import load_scenario
from amb_sweeps.stored_robustness import StoredOutcome
from source_check.requests import QuantityRequest
from source_check.sources import Job, SourceResult, answers, code_digest, job_of
from source_check.statements import Cause, Chapter, Reading, Source, Statement, Statements, selected
from source_check.verdict import Computed, Verdict, judge, meets, ratios

DATA = "report.json"


class Computation(NamedTuple):
    """One way to compute a statement: the source, the request, and the factor or reading used."""

    source: str
    request: QuantityRequest
    reading: str


@dataclass(frozen=True)
class Judged:
    """A statement with its computed value and verdict.

    source
        Name of the source on which the verdict is based; empty if nothing is computed.
    ours
        The computed value, in the statement's unit.
    reading
        The factor or reading used.
    ratios
        Ratio of the computed to the stated value, for each number.
    reason
        Reason why the statement is not reproduced or not computed.
    beside
        Results of other ways to compute the statement, by name; these results are not judged.
    converged, converged_is_met
        The value of the model with more modes, and whether it meets the statement; None if not computed.
    robustness
        Text on whether the stated outcome is robust, and on the changes that flip it; empty if unknown.
    """

    statement: Statement
    verdict: Verdict
    source: str = ""
    ours: Computed | None = None
    reading: str = ""
    ratios: tuple[float, ...] = ()
    reason: str = ""
    beside: tuple[tuple[str, Computed], ...] = ()
    converged: Computed | None = None
    converged_is_met: bool | None = None
    robustness: str = ""


@dataclass(frozen=True)
class Report:
    """Judged statements of a file, in the order of the file, and the answers of their sources, by source name."""

    statements: Statements
    judged: tuple[Judged, ...]
    answers: Mapping[str, SourceResult]

    @property
    def failures(self) -> dict[str, str]:
        """Reason why a source could not be run, by name of the source."""
        return {
            name: next(iter(answer.failures.values()))
            for name, answer in self.answers.items()
            if answer.failures and not answer.values
        }

    def of_chapter(self, chapter: Chapter) -> tuple[Judged, ...]:
        """Return the judged statements of a chapter."""
        return tuple(item for item in self.judged if chapter.has(item.statement))

    def counts(self, chapter: Chapter | None = None) -> Counter[Verdict]:
        """Return the number of statements with each verdict, in one chapter or in all."""
        return Counter(item.verdict for item in (self.judged if chapter is None else self.of_chapter(chapter)))

    def as_dict(self) -> dict[str, Any]:
        """Return the statements, values and verdicts as data for JSON."""
        return {
            "counts": {
                "all": _named(self.counts()),
                **{chapter.name: _named(self.counts(chapter)) for chapter in self.chapters},
            },
            "statements": [_as_dict(item) for item in self.judged],
            "sources": {name: dict(answer.parameters) for name, answer in self.answers.items()},
        }

    def missed_by_cause(self) -> dict[Cause, tuple[Judged, ...]]:
        """Return the statements that are not reproduced, by kind of reason, with the most frequent kind first."""
        missed = [item for item in self.judged if item.verdict is Verdict.MISSED]
        by_cause = {cause: tuple(item for item in missed if item.statement.cause == cause) for cause in get_args(Cause)}
        return dict(sorted(by_cause.items(), key=lambda entry: -len(entry[1])))

    @property
    def chapters(self) -> tuple[Chapter, ...]:
        """Chapters with judged statements."""
        return tuple(chapter for chapter in self.statements.chapter if self.of_chapter(chapter))

    def to_json(self) -> str:
        """Return `as_dict` as JSON text."""
        return json.dumps(self.as_dict(), indent=1, allow_nan=False) + "\n"


def assess(
    statements: Statements,
    folder: Path,
    only: Collection[str] = (),
    processes: int | None = None,
    progress: Progress = lambda done, total: None,
    outcomes: Mapping[str, StoredOutcome] = MappingProxyType({}),
) -> Report:
    """Compute and judge statements.

    Parameters
    ----------
    statements
        The content of a file.
    folder
        Folder of stored answers; answers of unchanged jobs are reused.
    only
        Chapters (`ch4`) and groups of statements, such as a table (`table3_1`); by default all.
    processes
        Largest number of simultaneous processes; one per processor by default.
    progress
        Function that is called with the number of finished sources and the number of all sources.
    outcomes
        Stored outcomes of runs and their robustness, by name of the run (`load_robustness`).

    Raises
    ------
    ValueError
        If `only` contains an unknown name.
    OSError
        If an answer cannot be written.
    """
    chosen = selected(statements, only)
    by_source = answers(jobs_of(statements, chosen, folder), processes, progress)
    return Report(statements, tuple(judged(item, statements, by_source, outcomes) for item in chosen), by_source)


def jobs_of(statements: Statements, chosen: Iterable[Statement], folder: Path) -> list[Job]:
    """Return a job for each source that the statements require; studies come first, because they take longest."""
    requests: dict[str, list[QuantityRequest]] = {}
    for statement in chosen:
        if statement.source:
            requests.setdefault(statement.source, [])
        for ways in (computations, alternatives, on_converged):
            for way in ways(statement, statements):
                requests.setdefault(way.source, []).append(way.request)
    code, module = code_digest(), statements.quantities
    jobs = [
        job_of(name, statements.sources[name], module, requested, folder, code) for name, requested in requests.items()
    ]
    return sorted(jobs, key=lambda job: bool(job.source.scenario))  # studies take longer than runs


def judged(
    statement: Statement,
    statements: Statements,
    by_source: Mapping[str, SourceResult],
    outcomes: Mapping[str, StoredOutcome] = MappingProxyType({}),
) -> Judged:
    """Judge a statement by the answers of its sources, and return it with the verdict.

    `outcomes` contains the robustness of the outcome of each run, by name of the run.
    """

    def value_of(way: Computation) -> Computed | None:
        return by_source[way.source].values.get(way.request.key)

    tried = computations(statement, statements)
    values = [value_of(way) for way in tried]
    verdict, chosen = judge(statement, [(value, way.reading) for value, way in zip(values, tried, strict=True)])
    if verdict is Verdict.PICTURE:
        return Judged(statement, verdict, statement.source)
    if verdict is Verdict.NOT_COMPUTED:
        reasons = (by_source[way.source].failures.get(way.request.key, "") for way in tried)
        return Judged(statement, verdict, reason=statement.missing or next(filter(None, reasons), ""))
    way, ours = tried[chosen], values[chosen]
    others = [(other.reading, value_of(other)) for other in alternatives(statement, statements)]
    converged = next((value_of(other) for other in on_converged(statement, statements)), None)
    stored = outcomes.get(way.source)  # an outcome is a text or a truth value
    return Judged(
        statement,
        verdict,
        way.source,
        ours,
        way.reading,
        ratios(statement, ours),
        reason=statement.why if verdict is Verdict.MISSED else "",
        beside=tuple((how, value) for how, value in others if value is not None),
        converged=converged,
        converged_is_met=None if converged is None else meets(statement, converged),
        robustness=stored.text if stored is not None and isinstance(statement.value, str | bool) else "",
    )


def computations(statement: Statement, statements: Statements) -> list[Computation]:
    """Return the ways to compute a statement, in the order in which they are tried."""
    ways = (Reading(source=statement.source), *statement.reading) if statement.quantity else ()
    tried = [_way(statement, way, statements) for way in ways]
    return [way._replace(reading="; ".join(filter(None, (way.reading, statement.inferred)))) for way in tried]


def alternatives(statement: Statement, statements: Statements) -> list[Computation]:
    """Return the ways to compute those values that are displayed beside a statement but not judged."""
    return [_way(statement, way, statements) for way in statement.beside]


def on_converged(statement: Statement, statements: Statements) -> list[Computation]:
    """Return the way to compute a statement with more modes, in a list that is empty if there is no such model."""
    return [_way(statement, Reading(source=statement.converged), statements)] if statement.converged else []


def _way(statement: Statement, way: Reading, statements: Statements) -> Computation:
    arguments = statement.arguments if way.arguments is None else way.arguments
    request = QuantityRequest(way.quantity or statement.quantity, tuple(sorted(arguments.items())), statement.unit)
    return Computation(way.source, request, way.how or "; ".join(reading_of(statements.sources[way.source])))


def reading_of(source: Source) -> list[str]:
    """Return, as texts, the factor on all unbalances of the source's scenario unless it is 1, and any reading."""
    factor = source.unbalance_factor or (load_scenario(source.scenario).unbalance_factor if source.scenario else 1.0)
    scaled = [] if factor == 1.0 else [f"all unbalances times {factor:g}"]
    return [*scaled, *([source.reading] if source.reading else [])]


def _named(counts: Counter[Verdict]) -> dict[str, int]:
    return {verdict.value: counts[verdict] for verdict in Verdict}


def _as_dict(item: Judged) -> dict[str, Any]:
    statement = item.statement
    return {
        "key": statement.key,
        "where": statement.where,
        "what": statement.what,
        "stated": statement.value,
        "relation": statement.relation,
        "unit": statement.unit,
        "ours": item.ours,
        "ratios": list(item.ratios),
        "verdict": item.verdict.value,
        "reading": item.reading,
        "reason": item.reason or statement.picture,
        "cause": statement.cause if item.verdict is Verdict.MISSED else "",
        "converged": item.converged,
        "met_on_converged": item.converged_is_met,
        "robustness": item.robustness,
        "beside": [{"how": how, "value": value} for how, value in item.beside],
        "source": item.source,
        "quantity": statement.quantity,
        "arguments": dict(statement.arguments),
    }
