"""Display of a result in a notebook: the verdict, orbits and forces, and the table of key values."""

from __future__ import annotations

import base64
import io
from html import escape
from typing import TYPE_CHECKING

from amb_cosim.results.plots import chosen, figure, has_motion
from amb_cosim.results.signal_arrays import finite_signals
from amb_cosim.results.summary_table import table
from amb_cosim.results.verdict import BAD

if TYPE_CHECKING:
    from amb_cosim.cosim.record.signals import Signals
    from amb_cosim.cosim.run.recording import Outcome
    from amb_cosim.results.summary import Summary

FIGURES = ("touchdown", "orbits", "displacement", "contact", "magnets")  # the first three show the motion
GOOD, BAD_COLOUR, OTHER = "#009e73", "#d55e00", "#0072b2"  # of verdicts


def html_of(dataset: Signals, summary: Summary, outcome: Outcome) -> str:
    """Return the verdict, figures and table of a run as HTML."""
    from amb_cosim.presentation.plain_console import plain_console
    from amb_cosim.presentation.style import png
    from amb_cosim.presentation.text_tables import exported, show_warnings

    dataset = finite_signals(dataset)[0]
    names = [name for name in FIGURES if has_motion(dataset) and name in chosen(dataset)]
    moved, forces = ([n for n in names if (n in FIGURES[:3]) is motion] for motion in (True, False))
    pictures = [(name, base64.b64encode(png(figure(dataset, name))).decode("ascii")) for name in moved[:1] + forces]
    console = plain_console(record=True, file=io.StringIO(), width=100, force_jupyter=False)
    console.print(table(summary))
    show_warnings(summary.verdict.doubts, console)
    decisive = exported(console)
    console.print(table(summary, whole=True))
    show_warnings(summary.warnings, console)
    console.print(str(outcome))
    word = summary.verdict.word
    colour = BAD_COLOUR if word in BAD else GOOD if word in ("levitated", "recovered", "free") else OTHER
    name, text = escape(summary.scenario), escape(str(summary.verdict))
    headline = f'<p><b>{name}</b>: <b style="color: {colour}">{text}</b></p>'
    rest = f"<details><summary>all values</summary>{exported(console)}</details>"
    images = "".join(
        f'<img alt="{name} of {escape(summary.scenario)}" style="max-width: 48%; vertical-align: top" '
        f'src="data:image/png;base64,{picture}">'
        for name, picture in pictures
    )
    return f"{headline}{decisive}<div>{images}</div>{rest}"
