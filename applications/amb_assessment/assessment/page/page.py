"""An assessment as one self-contained HTML page."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from markupsafe import Markup, escape

from amb_assessment.assessment.engine.assess import Assessment
from amb_assessment.assessment.engine.findings import Judgement
from amb_assessment.assessment.format.criteria import RELIABILITIES, unread
from amb_assessment.assessment.format.quantities import ResultTable
from amb_assessment.reporting.page_parts import asset, in_script, number_text, picture_url, plotly_script
from amb_assessment.reporting.panels import Panel
from amb_assessment.reporting.pictures import picture_of
from amb_cosim.presentation.templates import templates_of
from amb_cosim.presentation.units import convert_units_in_text
from amb_files.atomic import plain_file, write_file

PAGE, DATA = "assessment.html", "assessment.json"


def write_data(assessment: Assessment, folder: Path) -> Path:
    """Write the data file atomically into a folder, and return its path."""
    return _write(folder, DATA, json.dumps(assessment.as_dict(), indent=1, allow_nan=False) + "\n")


def write_page(assessment: Assessment, folder: Path) -> Path:
    """Write the page atomically into a folder, and return its path."""
    return _write(folder, PAGE, page(assessment))


def _write(folder: Path, name: str, text: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    write_file(plain_file(folder, name), text)
    return folder / name


def page(assessment: Assessment) -> str:
    """Return the text of the page."""
    environment = templates_of("amb_assessment.assessment.page", "template", _in_chosen_units)
    environment.globals.update(badge=lambda verdict: verdict.name.lower(), number=number_text, known=RELIABILITIES)
    environment.globals.update(sentences=_sentences)
    environment.filters.update(code=_with_code, in_chosen_units=ResultTable.in_chosen_units)
    panels = {part.key: [panel.in_chosen_units() for panel in part.result.panels] for part in assessment.parts}
    return environment.get_template("assessment.html.j2").render(
        assessment=assessment,
        machine=assessment.machine,
        criteria=assessment.criteria,
        unread=unread(assessment.criteria),
        verdicts=list(Judgement),
        counts=assessment.counts(),
        pictures={key: _picture(drawn) for key, drawn in panels.items()},
        version=version("amb-cosim"),
        date=datetime.now(UTC).strftime("%Y-%m-%d"),
        style=asset("report.css") + asset("assessment.css", "amb_assessment.assessment.page"),
        script=asset("report.js"),
        plotly=plotly_script(),
        plots=in_script({key: [panel.as_data() for panel in drawn] for key, drawn in panels.items()}),
    )


def _in_chosen_units(value: object) -> object:
    """Return a text with its numbers in the chosen units; any other value is returned unchanged."""
    return value if isinstance(value, Markup) or not isinstance(value, str) else convert_units_in_text(value)


def _sentences(*texts: str) -> str:
    """Join the texts that are not empty into sentences, each of which begins with a capital letter."""
    return ". ".join(text[0].upper() + text[1:] for text in texts if text)


def _with_code(text: str) -> Markup:
    """Convert a text to HTML: backticks mark code, and numbers are shown in the chosen units."""
    return Markup(re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(convert_units_in_text(text)))))


def _picture(panels: Sequence[Panel]) -> str:
    """Return a picture of a part's plots as a data URL, for printing and for pages without scripts."""
    return picture_url(picture_of(panels) if panels else b"")
