"""Tables as they are printed."""

from __future__ import annotations

from rich.table import Table


def labelled_table(title: str, label: str, *numbers: str) -> Table:
    """A table without lines: rows begin with a label, to the left, and go on with numbers, to the right.

    `label` and `numbers` are the headings.
    """
    table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
    table.add_column(label, no_wrap=True)
    for heading in numbers:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def number(value: float | None) -> str:
    """A number with four digits, or a dash where there is none."""
    return "-" if value is None else f"{value:.4g}"
