"""A result as a notebook shows it: the verdict, orbits and forces, and the table of key values."""

from __future__ import annotations

import base64
import io
from html import escape
from typing import TYPE_CHECKING

from amb_cosim.results.plots import chosen, figure, has_motion

if TYPE_CHECKING:
    from amb_cosim.cosim.record.signals import Signals
    from amb_cosim.cosim.run.recording import Outcome
    from amb_cosim.results.summary import Summary

SHOWN = ("touchdown", "orbits", "displacement", "contact", "magnets")  # figures, the first three for what moved
VERDICTS = {
    "prevented": "the disturbance led to no contact",
    "recovered": "the rotor touched, and is free of contact again",
    "landed": "the rotor lies or turns on its retainers: no magnet has power",
    "trapped": "the rotor stays in contact",
    "unstable": "the rotor is unstable: its orbit grows, or its amplifiers stay at their limits",
}
COLOURS = {
    "prevented": "#009e73",
    "recovered": "#009e73",
    "landed": "#0072b2",
    "trapped": "#d55e00",
    "unstable": "#d55e00",
}


def html_of(dataset: Signals, summary: Summary, outcome: Outcome) -> str:
    """Return verdict, figures and table of a run as HTML."""
    from rich.console import Console

    from amb_cosim.presentation.style import png
    from amb_cosim.presentation.text_tables import show_warnings

    names = [name for name in SHOWN if has_motion(dataset) and name in chosen(dataset)]
    moved, forces = ([n for n in names if (n in SHOWN[:3]) is motion] for motion in (True, False))
    pictures = [(name, base64.b64encode(png(figure(dataset, name))).decode("ascii")) for name in moved[:1] + forces]
    console = Console(record=True, file=io.StringIO(), width=100, force_jupyter=False)
    console.print(summary.table())
    show_warnings(summary.warnings, console)
    console.print(str(outcome))
    table = console.export_html(inline_styles=True, code_format="<pre>{code}</pre>")
    images = "".join(
        f'<img alt="{name} of {escape(summary.scenario)}" style="max-width: 48%; vertical-align: top" '
        f'src="data:image/png;base64,{picture}">'
        for name, picture in pictures
    )
    return f"{_verdict(summary, outcome)}<div>{images}</div>{table}"


def _verdict(summary: Summary, outcome: Outcome) -> str:
    """Return the headline: what the run led to, or how it ended."""
    recovery, failure = summary.recovery, outcome.failure
    text = failure or (VERDICTS[recovery] if recovery else str(outcome))
    colour = COLOURS["unstable"] if failure else COLOURS.get(recovery or "", "inherit")
    return f'<p><b>{escape(summary.scenario)}</b>: <b style="color: {colour}">{escape(text)}</b></p>'
