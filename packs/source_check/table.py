"""The report as Markdown: an overview, counts by verdict, and one table for each chapter."""

from __future__ import annotations

from collections.abc import Iterator

from source_check.evaluation import Judged, Report
from source_check.overview import overview
from source_check.statements import Chapter
from source_check.texts import converged_text, ratio_text, remark_text, stated_text, value_text
from source_check.verdict import Verdict

TABLE = "report.md"


def markdown(report: Report) -> str:
    """Return an overview, the counts by verdict and chapter, and a table of the statements of each chapter."""
    return (
        "\n".join(
            [overview(report), "", *_counts(report), *(line for c in report.chapters for line in _chapter(report, c))]
        )
        + "\n"
    )


def _counts(report: Report) -> Iterator[str]:
    yield _row("chapter", *(verdict.value for verdict in Verdict), "all")
    yield _row(*("---" for _ in range(len(Verdict) + 2)))
    for name, counts in (
        *((chapter.name, report.counts(chapter)) for chapter in report.chapters),
        ("all", report.counts()),
    ):
        yield _row(name, *(str(counts[verdict]) for verdict in Verdict), str(counts.total()))


def _chapter(report: Report, chapter: Chapter) -> Iterator[str]:
    yield from ("", f"## {chapter.name.capitalize()}", "")
    columns = ("where", "what", report.statements.label, "here", "ratio", report.statements.converged, "verdict")
    yield _row(*columns, "method, or reason")
    yield _row(*("---" for _ in range(8)))
    yield from map(_line, report.of_chapter(chapter))


def _line(item: Judged) -> str:
    statement = item.statement
    return _row(
        statement.where,
        statement.what,
        stated_text(statement),
        value_text(item.ours, statement.unit),
        ratio_text(item),
        converged_text(item),
        item.verdict.value,
        remark_text(item),
    )


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
