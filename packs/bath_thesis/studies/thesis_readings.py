"""Study of the thesis's open points: misfit of each reading of chapters 4 to 6 against its statements.

The thesis states no positions along the shaft and no balancing of its rig, names discs in two ways, and measures other
critical speeds than its stiffness gives. A reading settles one of these points; every statement of the chapter that a
run covers is then compared (`source_check`). The misfit of a reading is the mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.run.options import Progress
from amb_cosim.presentation.progress import progress_bar
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number
from amb_cosim.studies.processes import simulate_in_processes
from amb_cosim.studies.result import DrawnResult
from amb_files.checks import require
from bath_thesis.studies.reading_cases import (
    ReadingResult,
    cases_of,
    load_readings,
    mean_misfit,
    simulate_case,
    statements_of,
)
from source_check.source_runs import build_fmus
from source_check.statements import Expected, Statement
from source_check.verdict import Computed

CHAPTERS = (4, 5, 6)
SIGNS = {"equal": "", "below": "<= ", "above": ">= "}
MOVED = 0.05  # misfit by which a statement counts as moved


@dataclass(frozen=True)
class Row:
    """A statement and the finding of each reading.

    key, stated
        Name of the statement, and its value in the thesis.
    findings
        Computed value and misfit by reading.
    """

    key: str
    stated: str
    findings: dict[str, ReadingResult]


@dataclass(frozen=True, eq=False, repr=False)
class Readings(DrawnResult):
    """Misfits of readings against the thesis's statements, by chapter.

    rows
        By chapter, each statement.
    misfit
        By chapter and reading, the mean over the chapter's statements.
    met
        By chapter and reading, the number of statements that are met within their tolerances.
    """

    name: ClassVar[str] = "readings"

    rows: dict[str, tuple[Row, ...]]
    misfit: dict[str, dict[str, float]]
    met: dict[str, dict[str, int]]

    def text(self) -> list[TextBlock]:
        """Return a table of readings and one of statements for each chapter."""
        parts: list[TextBlock] = []
        for chapter, rows in self.rows.items():
            names = list(self.misfit[chapter])
            table = labelled_table(f"Chapter {chapter}", "reading", "misfit", f"met of {len(rows)}", "better", "worse")
            for name in names:
                moves = [row.findings[name].misfit - row.findings[names[0]].misfit for row in rows]
                better, worse = sum(move < -MOVED for move in moves), sum(move > MOVED for move in moves)
                table.add_row(
                    name, f"{self.misfit[chapter][name]:.3f}", f"{self.met[chapter][name]}", f"{better}", f"{worse}"
                )
            table_of_rows = labelled_table("", "statement", "thesis", *(f"{k}" for k in range(len(names))))
            for row in rows:
                table_of_rows.add_row(row.key, row.stated, *(_cell(row.findings[name].found) for name in names))
            parts += [table, table_of_rows, "; ".join(f"{k} {name}" for k, name in enumerate(names)), ""]
        parts.append(
            "misfit: mean of |ln(ours/theirs)|, at most ln 10, for numbers and of 1 for an outcome that differs; "
            f"better, worse: statements that a reading moves by more than {MOVED} against the first"
        )
        return parts


def readings(
    chapters: Sequence[int] | str = "4,5,6", *, flavour: Flavour = "native", progress: bool | Progress | None = None
) -> Readings:
    """Return the misfit of readings of the thesis against its statements in some chapters.

    Parameters
    ----------
    chapters
        Chapters from 4, 5 and 6, or a string separated by commas.
    flavour
        Flavour of the FMUs.
    progress
        Whether a bar is shown (default in a terminal and a notebook), or a function called with the number of runs done
        and of all runs.

    Raises
    ------
    ValueError
        If another chapter is requested, or a run does not reach its end.
    """
    wanted = _chapters(chapters)
    chosen = [reading for reading in load_readings() if reading.chapter in wanted]
    with progress_bar(progress) as report:
        cases = [case for reading in chosen for case in cases_of(reading, flavour)]
        build_fmus((case.source for case in cases), flavour)
        result = simulate_in_processes(simulate_case, cases, report)
    findings: dict[int, dict[str, dict[str, ReadingResult]]] = {}
    for case, of_case in zip(cases, result, strict=True):
        of_reading = findings.setdefault(case.reading.chapter, {}).setdefault(case.reading.name, {})
        of_reading |= {statement.key: item for statement, item in zip(case.statements, of_case, strict=True)}
    return Readings(
        rows={f"{chapter}": _rows(chapter, of) for chapter, of in findings.items()},
        misfit={f"{k}": {name: mean_misfit([*of.values()]) for name, of in v.items()} for k, v in findings.items()},
        met={f"{k}": {n: sum(item.is_met for item in of.values()) for n, of in v.items()} for k, v in findings.items()},
    )


def _chapters(raw: Sequence[int] | str) -> list[int]:
    """Return chapters, ascending."""
    parts = [part.strip() for part in raw.split(",")] if isinstance(raw, str) else [str(part) for part in raw]
    for part in parts:
        require(part in map(str, CHAPTERS), "chapter", part, "4, 5 or 6")
    return sorted({int(part) for part in parts})


def _rows(chapter: int, findings: dict[str, dict[str, ReadingResult]]) -> tuple[Row, ...]:
    """Return a row for each statement of a chapter; findings are by reading and statement."""
    return tuple(
        Row(statement.key, _stated(statement), {name: of[statement.key] for name, of in findings.items()})
        for statement in statements_of(chapter)
    )


def _stated(statement: Statement) -> str:
    return f"{SIGNS[statement.relation]}{_cell(statement.value)} {statement.unit}".strip()


def _cell(value: Expected | Computed | None) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(map(number, value))
    return str(value) if isinstance(value, bool | str) else number(value)
