"""Tables and lines for printing by commands."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from io import StringIO
from typing import Literal

from rich.console import Console, ConsoleOptions, RenderResult
from rich.table import Table

from amb_cosim.presentation.digits import significant, with_micro_signs
from amb_cosim.presentation.plain_console import plain_console
from amb_cosim.presentation.units import column_in_chosen_units, convert_units_in_text

TextBlock = Table | str

WIDTH = 160  # characters of a line in a notebook
WIDEST = 10_000  # of a table in a file


class TitledTable(Table):
    """A table in the chosen units; its title may fill the console, whereas rich breaks titles at the table's width."""

    def __init__(self, title: str, headings: Sequence[str], left: Collection[str], gap: int) -> None:
        super().__init__(title=with_micro_signs(convert_units_in_text(title)), box=None, padding=(0, gap, 0, 0))
        self._converters = []
        for heading in headings:
            label, convert = column_in_chosen_units(heading)
            self._converters.append(convert)
            justify: Literal["left", "right"] = "left" if heading in left else "right"
            self.add_column(with_micro_signs(label), justify=justify, no_wrap=True)

    def add_row(self, *cells: str) -> None:  # type: ignore[override]  # cells are texts
        """Add a row with its cells in the chosen units."""
        super().add_row(*(convert(cell) for convert, cell in zip(self._converters, cells, strict=True)))

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        if self.title:
            yield console.render_str(str(self.title), style="table.title", highlight=False)
        title, self.title = self.title, None
        try:
            yield from super().__rich_console__(console, options)
        finally:
            self.title = title


def text_table(
    title: str,
    headings: Sequence[str],
    rows: Iterable[Sequence[str]] = (),
    *,
    left: Collection[str] = (),
    gap: int = 2,
) -> Table:
    """Return a table without lines.

    Parameters
    ----------
    title, headings
        Text above the table, and above each column.
    rows
        Texts of each row; more rows can be added later.
    left
        Headings of the columns that are aligned to the left; the others hold numbers and are aligned to the right.
    gap
        Spaces between two columns.
    """
    table = TitledTable(title, headings, left, gap)
    for row in rows:
        table.add_row(*row)
    return table


def labelled_table(title: str, label: str, *numbers: str) -> Table:
    """Return a table whose rows consist of a label, aligned to the left, and numbers.

    Parameters
    ----------
    title
        Text above the table.
    label, numbers
        Headings of the labels and of the numbers.
    """
    return text_table(title, (label, *numbers), left=(label,))


def number(value: float | None) -> str:
    """Return a number with four significant digits, or a dash for None."""
    return "-" if value is None else significant(value)


def rendered(parts: Iterable[TextBlock]) -> str:
    """Return tables and lines as one text."""
    text = StringIO()
    print_parts(parts, plain_console(file=text))
    return text.getvalue()


def html_of(parts: Iterable[TextBlock], height: str = "28em") -> str:
    """Return tables and lines as HTML for a notebook, in a scrolling box that is at most `height` high."""
    console = plain_console(record=True, file=StringIO(), width=WIDTH, force_jupyter=False, highlight=False)
    for part in _in_chosen_units(parts):
        console.print(part)
    return f'<div style="max-height: {height}; overflow: auto">{exported(console)}</div>'


def exported(console: Console) -> str:
    """Return as HTML what a recording console has printed since the last call."""
    return console.export_html(inline_styles=True, code_format="<pre>{code}</pre>")


def show_warnings(sentences: Iterable[str], console: Console | None = None, *, whole: bool = True) -> None:
    """Print warnings, to standard output by default; each is cut to one line of the terminal unless `whole` is set."""
    console = console or plain_console()
    lines = [f"warning: {convert_units_in_text(sentence)}" for sentence in sentences]
    cuts = console.is_terminal and not whole
    for line in lines:
        options = {"no_wrap": True, "overflow": "ellipsis"} if cuts else {"soft_wrap": not console.is_terminal}
        console.print(line, markup=False, highlight=False, **options)
    if cuts and any(len(line) > console.width for line in lines):
        console.print("--all shows the full warnings", highlight=False)


def show_notices(sentences: Iterable[str]) -> None:
    """Print notices to standard error, one per line, for example about settings that a replacing component lacks."""
    console = plain_console(stderr=True)
    for sentence in sentences:
        console.print(f"notice: {sentence}", markup=False, highlight=False, soft_wrap=True)


def print_parts(parts: Iterable[TextBlock], console: Console | None = None) -> None:
    """Print tables and lines in the chosen units, to standard output by default; lines in a file are not wrapped."""
    console = console or plain_console()
    if not console.is_terminal:
        console = plain_console(file=console.file, width=WIDEST)
    for part in _in_chosen_units(parts):
        console.print(part, soft_wrap=isinstance(part, str) and not console.is_terminal)


def _in_chosen_units(parts: Iterable[TextBlock]) -> Iterator[TextBlock]:
    """Yield tables, which convert their own cells, and lines with numbers converted to the chosen units."""
    for part in parts:
        yield convert_units_in_text(part) if isinstance(part, str) else part
