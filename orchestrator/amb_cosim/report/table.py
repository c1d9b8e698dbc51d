"""The statements as Markdown: `python -m amb_cosim.report.table [-o DIR]` prints counts and one table for each chapter.

Answers that a report left in DIR are used again, so that only what changed is computed.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from amb_cosim.report.evaluation import Judged, Report, evaluate
from amb_cosim.report.texts import ratio_text, remark_text, thesis_text, value_text
from amb_cosim.report.verdict import Verdict
from amb_files.atomic import write_atomically

TABLE = "report.md"


def markdown(report: Report) -> str:
    """Return the counts by verdict and chapter, and a table of the statements of each chapter."""
    return "\n".join([*_counts(report), *(line for c in report.chapters for line in _chapter(report, c))]) + "\n"


def write_table(report: Report, path: Path) -> None:
    """Write what `markdown` returns."""
    text = markdown(report)
    write_atomically(path, lambda file: file.write_text(text, encoding="utf-8"))


def _counts(report: Report) -> Iterator[str]:
    yield _row("chapter", *(verdict.value for verdict in Verdict), "all")
    yield _row(*("---" for _ in range(len(Verdict) + 2)))
    for name, counts in (
        *((str(chapter), report.counts(chapter)) for chapter in report.chapters),
        ("all", report.counts()),
    ):
        yield _row(name, *(str(counts[verdict]) for verdict in Verdict), str(counts.total()))


def _chapter(report: Report, chapter: int) -> Iterator[str]:
    yield from ("", f"## Chapter {chapter}", "")
    yield _row("where", "what", "thesis", "here", "ratio", "verdict", "how, or why not")
    yield _row(*("---" for _ in range(7)))
    yield from (_line(one) for one in report.judged if one.statement.chapter == chapter)


def _line(one: Judged) -> str:
    statement = one.statement
    return _row(
        statement.where,
        statement.what,
        thesis_text(statement),
        value_text(one.ours, statement.unit),
        ratio_text(one),
        one.verdict.value,
        remark_text(one),
    )


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("results/report"), show_default=True)
@click.option("--jobs", type=click.IntRange(1, 256), help="Most processes at a time.")
def main(output: Path, jobs: int | None) -> None:
    """Print the statements of the thesis beside what is computed here, as Markdown."""
    click.echo(markdown(evaluate(output, processes=jobs)), nl=False)


if __name__ == "__main__":
    main()
