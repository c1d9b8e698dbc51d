"""Study of what the thesis leaves open: how near each reading of its chapters 4 to 6 comes to what it states.

The thesis gives no positions along the shaft, does not say how its rig was balanced, names discs in two ways, and
measures other critical speeds than its stiffness gives. A reading settles one of these, and every statement of the
chapter is measured under it. A number errs by |ln(ours/theirs)|, at most ln 10, an outcome that differs counts 1, and
the misfit of a reading is the mean of all statements of the chapter.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar

from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.simulation import Progress
from amb_cosim.progress import progress_bar
from amb_cosim.studies.processes import simulate_in_processes
from amb_cosim.studies.reading_cases import (
    Case,
    Finding,
    Reading,
    Statement,
    of_scenario,
    prepare_case,
    read_file,
    simulate_case,
    statements_of,
    with_rotor,
)
from amb_cosim.studies.reading_measures import Found
from amb_cosim.studies.result import DrawnResult
from amb_cosim.text_tables import TextPart, labelled_table, number
from rotor_analysis.checks import require

CHAPTERS = (4, 5, 6)
SIGNS = {"value": "", "at_most": "<= ", "at_least": ">= ", "is": ""}
MET = 0.2  # misfit of a number that counts as met: within a factor of 1.22


@dataclass(frozen=True)
class Row:
    """A statement and what each reading finds of it.

    statement
        Figure, scenario and measure.
    stated
        What the thesis states.
    counted
        Whether the misfit of a reading counts it.
    found, misfit
        By reading, what the run shows and how far that is from it.
    """

    statement: str
    stated: str
    counted: bool
    found: dict[str, Found]
    misfit: dict[str, float]


@dataclass(frozen=True, eq=False, repr=False)
class Readings(DrawnResult):
    """How near readings come to what the thesis states, by chapter.

    rows
        By chapter, each statement.
    misfit
        By chapter and reading, the mean over the chapter's statements.
    met
        By chapter and reading, the number of statements with a misfit below 0.2.
    """

    name: ClassVar[str] = "readings"

    rows: dict[str, tuple[Row, ...]]
    misfit: dict[str, dict[str, float]]
    met: dict[str, dict[str, int]]

    def text(self) -> list[TextPart]:
        """Return a table of readings and one of statements for each chapter."""
        parts: list[TextPart] = []
        for chapter, rows in self.rows.items():
            first, counted = next(iter(self.misfit[chapter])), [row for row in rows if row.counted]
            title, of = f"Chapter {chapter}", f"met of {len(counted)}"
            table = labelled_table(title, "reading", "misfit", of, "better", "worse")
            for reading, value in self.misfit[chapter].items():
                change = [row.misfit[reading] - row.misfit[first] for row in counted]
                better, worse = sum(c < -0.05 for c in change), sum(c > 0.05 for c in change)
                table.add_row(reading, f"{value:.3f}", f"{self.met[chapter][reading]}", f"{better}", f"{worse}")
            names = list(self.misfit[chapter])
            table_of_rows = labelled_table("", "statement", "thesis", *(f"{k}" for k in range(len(names))))
            for row in rows:
                mark = "" if row.counted else " (not counted)"
                table_of_rows.add_row(row.statement + mark, row.stated, *(_cell(row.found[name]) for name in names))
            parts += [table, table_of_rows, "; ".join(f"{k} {name}" for k, name in enumerate(names)), ""]
        parts.append(
            "misfit: mean of |ln(ours/theirs)|, at most ln 10, for numbers and of 1 for an outcome that differs; "
            "better, worse: statements that a reading moves by more than 0.05 against the first"
        )
        return parts


def readings(
    chapters: Sequence[int] | str = "4,5,6", *, flavour: Flavour = "native", progress: bool | Progress | None = None
) -> Readings:
    """Return how near readings of the thesis come to what it states in some chapters.

    Parameters
    ----------
    chapters
        Chapters, of 4, 5 and 6, or a text with commas.
    flavour
        Flavour of the FMUs.
    progress
        Whether a bar is shown (by default in a terminal and in a notebook), or a function that is called with the
        number of runs done and of all runs.

    Raises
    ------
    ValueError
        If a chapter is another one, or a run does not reach its end.
    """
    wanted = _chapters(chapters)
    chosen = [reading for reading in read_file()[1] if reading.chapter in wanted]
    with TemporaryDirectory() as folder, progress_bar(progress) as report:
        cases = [with_rotor(case, Path(folder)) for reading in chosen for case in _cases(reading, flavour)]
        for case in {case.rotor: case for case in cases}.values():
            prepare_case(case)  # checks the input and builds the FMUs before processes are started
        found = simulate_in_processes(simulate_case, cases, report)
    findings: dict[tuple[int, str], dict[str, list[Finding]]] = {}
    for case, of_case in zip(cases, found, strict=True):
        findings.setdefault((case.reading.chapter, case.reading.name), {})[case.scenario] = of_case
    return _result({chapter: {n: f for (c, n), f in findings.items() if c == chapter} for chapter in wanted})


def _chapters(raw: Sequence[int] | str) -> list[int]:
    """Return chapters, ascending."""
    parts = [part.strip() for part in raw.split(",")] if isinstance(raw, str) else [str(part) for part in raw]
    for part in parts:
        require(part in map(str, CHAPTERS), "chapter", part, "4, 5 or 6")
    return sorted({int(part) for part in parts})


def _cases(reading: Reading, flavour: Flavour) -> list[Case]:
    """Return the runs of a reading, one for each scenario of its chapter."""
    names = dict.fromkeys(statement.scenario for statement in statements_of(reading.chapter))
    return [Case(reading, name, flavour) for name in names]


def _result(findings: dict[int, dict[str, dict[str, list[Finding]]]]) -> Readings:
    """Return the result; findings are by chapter, reading and scenario."""
    rows: dict[str, tuple[Row, ...]] = {}
    for chapter, of_readings in findings.items():
        statements = statements_of(chapter)
        by_scenario = {s.scenario: of_scenario(statements, s.scenario) for s in statements}
        rows[str(chapter)] = tuple(
            _row(s, {name: runs[s.scenario][by_scenario[s.scenario].index(s)] for name, runs in of_readings.items()})
            for s in statements
        )
    names = {chapter: list(of[0].misfit) for chapter, of in rows.items()}
    counted = {chapter: [row for row in of if row.counted] for chapter, of in rows.items()}
    return Readings(
        rows=rows,
        misfit={
            chapter: {name: sum(row.misfit[name] for row in of) / len(of) for name in names[chapter]}
            for chapter, of in counted.items()
        },
        met={
            chapter: {name: sum(row.misfit[name] < MET for row in of) for name in names[chapter]}
            for chapter, of in counted.items()
        },
    )


def _row(statement: Statement, found: dict[str, Finding]) -> Row:
    kind, wanted = statement.stated
    stated = wanted if isinstance(wanted, str) else f"{SIGNS[kind]}{number(wanted)} {statement.unit}".strip()
    return Row(
        statement=f"{statement.figure} {statement.scenario}: {statement.measure}",
        stated=stated,
        counted=statement.counted,
        found={name: finding.found for name, finding in found.items()},
        misfit={name: finding.misfit for name, finding in found.items()},
    )


def _cell(found: Found) -> str:
    return found if isinstance(found, str) else number(found)
