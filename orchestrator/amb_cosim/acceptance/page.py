"""An assessment as one HTML page that needs no other file."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from markupsafe import Markup

from amb_cosim.acceptance.assess import Assessment
from amb_cosim.acceptance.criteria import KNOWN
from amb_cosim.acceptance.findings import Judgement
from amb_cosim.assessment.panels import Panel
from amb_cosim.assessment.pictures import picture_of
from amb_cosim.assessment.texts import number_text
from amb_cosim.presentation.templates import templates_of
from amb_files.atomic import write_atomically

PAGE, DATA = "assessment.html", "assessment.json"


def write_assessment(found: Assessment, folder: Path) -> Path:
    """Write data and page into a folder, each complete or not at all, and return the path of the page."""
    text, data = page(found), json.dumps(found.as_dict(), indent=1, allow_nan=False) + "\n"
    folder.mkdir(parents=True, exist_ok=True)
    write_atomically(folder / DATA, lambda file: file.write_text(data, encoding="utf-8"))
    write_atomically(folder / PAGE, lambda file: file.write_text(text, encoding="utf-8"))
    return folder / PAGE


def page(found: Assessment) -> str:
    """Return the text of the page."""
    from plotly.offline import get_plotlyjs

    environment = templates_of("amb_cosim.acceptance", "template")
    environment.globals.update(badge=lambda verdict: verdict.name.lower(), number=number_text, known=KNOWN)
    panels = {part.key: [panel.in_chosen_units() for panel in part.answer.panels] for part in found.parts}
    return environment.get_template("assessment.html.j2").render(
        found=found,
        machine=found.machine,
        verdicts=list(Judgement),
        counts=found.counts(),
        pictures={key: _picture(drawn) for key, drawn in panels.items()},
        version=version("amb-cosim"),
        date=datetime.now(UTC).strftime("%Y-%m-%d"),
        style=_asset("amb_cosim.assessment", "report.css") + _asset("amb_cosim.acceptance", "assessment.css"),
        script=_asset("amb_cosim.assessment", "report.js"),
        plotly=Markup(get_plotlyjs().replace("</script", "<\\/script")),
        plots=_in_script({key: [panel.as_data() for panel in drawn] for key, drawn in panels.items()}),
    )


def _picture(panels: Sequence[Panel]) -> str:
    """Return a picture of a part's plots, as a data URL, for print and for pages without scripts."""
    return f"data:image/png;base64,{base64.b64encode(picture_of(panels)).decode('ascii')}" if panels else ""


def _asset(package: str, name: str) -> Markup:
    return Markup((files(package) / "template" / name).read_text(encoding="utf-8"))


def _in_script(data: Any) -> Markup:
    """Return JSON that may stand in a script element."""
    return Markup(json.dumps(data, allow_nan=False).replace("<", "\\u003c"))
