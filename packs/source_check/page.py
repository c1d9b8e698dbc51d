"""The report as a self-contained HTML page."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version

from amb_assessment.reporting.page_parts import asset, in_script, picture_url, plotly_script
from amb_cosim.presentation.templates import templates_of
from source_check.evaluation import Judged, Report
from source_check.overview import overview
from source_check.sources import SourceResult
from source_check.statements import Chapter
from source_check.texts import converged_text, ratio_text, remark_text, stated_text, tolerance_text, value_text
from source_check.verdict import Verdict

PAGE = "report.html"


@dataclass(frozen=True)
class Section:
    """Statements of one source, with the answer of the source, or statements without a source."""

    name: str
    answer: SourceResult | None
    judged: tuple[Judged, ...]

    @property
    def places(self) -> str:
        """Distinct places of the statements in the source."""
        return ", ".join(dict.fromkeys(item.statement.where for item in self.judged))

    @property
    def reading(self) -> str:
        """The reading that all statements of the section share; empty if there is none."""
        with_reading = (Verdict.REPRODUCED, Verdict.WITH_READING, Verdict.MISSED)
        readings = {item.reading for item in self.judged if item.verdict in with_reading}
        return readings.pop() if len(readings) == 1 else ""

    @property
    def picture(self) -> str:
        """Picture of the plots, as a data URL."""
        return picture_url(self.answer.picture) if self.answer is not None else ""


def page(report: Report) -> str:
    """Return the HTML text of the page."""
    environment = templates_of("source_check", "template")
    environment.globals.update(
        stated=lambda item: stated_text(item.statement),
        ours=lambda item: value_text(item.ours, item.statement.unit),
        ratio=ratio_text,
        converged=converged_text,
        remark=remark_text,
        tolerance=lambda item: tolerance_text(item.statement),
        badge=lambda verdict: verdict.name.lower(),
    )
    chapters = [(chapter, tuple(sections(report, chapter))) for chapter in report.chapters]
    answers = {part.name: part.answer for _, parts in chapters for part in parts if part.answer is not None}
    plots = {name: [panel.in_chosen_units().as_data() for panel in answer.panels] for name, answer in answers.items()}
    return environment.get_template("report.html.j2").render(
        report=report,
        statements=report.statements,
        overview=overview(report).replace("`", ""),
        chapters=chapters,
        verdicts=list(Verdict),
        version=version("amb-cosim"),
        date=datetime.now(UTC).strftime("%Y-%m-%d"),
        style=asset("report.css"),
        script=asset("report.js"),
        plotly=plotly_script(),
        plots=in_script(plots),
    )


def sections(report: Report, chapter: Chapter) -> Iterator[Section]:
    """Yield a section for each source in a chapter, in file order, and one for statements without a source."""
    groups: dict[str, list[Judged]] = {}
    sources = _source_of_group(report)
    for item in report.of_chapter(chapter):
        name = item.source or item.statement.source or sources.get(item.statement.group, "")
        groups.setdefault(name, []).append(item)
    for name, judged in groups.items():
        yield Section(name, report.answers.get(name), tuple(judged))


def _source_of_group(report: Report) -> dict[str, str]:
    """Return the source of each figure or table, under which its statements without a source are also shown."""
    return {item.statement.group: item.statement.source for item in reversed(report.judged) if item.statement.source}
