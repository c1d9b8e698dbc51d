"""Reads tables of texts, `.csv`, as tools and spreadsheets of any country save them.

Columns are separated by commas, semicolons or tabs. Numbers have decimal points, or decimal commas throughout, as in
a German spreadsheet. A number that may mean two numbers is refused: `1,500` alone may be 1500 or 1.5.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from io import StringIO
from itertools import islice
from pathlib import Path

from amb_files.toml import LARGEST, read_text

SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas"}
STATED = re.compile(r"sep=(.)\r?\n")  # the first line of some files for spreadsheets
JUDGED = 50  # rows whose number of cells shows the separator
POWER = r"(?:[eE][+-]?\d+)?"
COMMA = re.compile(rf"[+-]?(?:\d+,\d*|,\d+){POWER}")
POINT = re.compile(rf"[+-]?(?:\d+\.\d*|\.\d+){POWER}")
GROUP = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")  # of three digits, or three decimals
GROUPED = re.compile(r"[+-]?\d[\d.,'’]*[.,'’][\d.,'’]*")  # with several separators

Rows = list[list[str]]


def read_csv(path: Path, name: str, largest: int = LARGEST) -> tuple[list[str], Rows]:
    """Return the headings of a table, without blanks around them, and its rows, whose numbers have decimal points.

    Parameters
    ----------
    path
        The file: UTF-8, or UTF-16 with a byte order mark.
    name
        Its name in messages.
    largest
        Allowed size in bytes.

    Raises
    ------
    ValueError
        If it cannot be read, two headings are equal, rows differ in length, or a number may mean two numbers.
    """
    text = read_text(path, name, largest)
    stated = STATED.match(text)
    text = text[stated.end() :] if stated else text
    try:
        separator = stated[1] if stated else _separator(text)
        rows = list(_rows(text, separator))
    except csv.Error as error:
        raise ValueError(f"{name} cannot be read as a table: {error}") from error
    if len(rows) < 2:
        raise ValueError(f"{name} must have a row of headings and a row of values")
    while len(rows[0]) > 1 and not any(row[-1].strip() for row in rows if len(row) == len(rows[0])):
        rows = [row[:-1] if len(row) == len(rows[0]) else row for row in rows]  # each row ends with a separator
    heads = [head.strip() for head in rows[0]]
    for k, row in enumerate(rows[1:], 2):
        if len(row) != len(heads):
            advice = "; with decimal commas, columns must be separated by semicolons" if len(row) > len(heads) else ""
            expected = f"{len(heads)} values as the headings, separated by {SEPARATORS.get(separator, separator)}"
            raise ValueError(f"row {k} of {name} must have {expected}; it has {len(row)}{advice}")
    if twice := next((head for head in heads if heads.count(head) > 1), ""):
        raise ValueError(f"{name} has two columns {twice!r}; their headings must be unique")
    return heads, _with_points(rows[1:], name) if separator != "," or '"' in text else rows[1:]


def _rows(text: str, separator: str) -> Iterator[list[str]]:
    """Yield the rows that have a value."""
    for row in csv.reader(StringIO(text, newline=""), delimiter=separator):
        if any(cell.strip() for cell in row):
            yield row


def _separator(text: str) -> str:
    """Return the separator that divides all first rows into the same number of cells, or else most of the headings."""
    counts = {separator: [len(row) for row in islice(_rows(text, separator), JUDGED)] for separator in SEPARATORS}
    for separator, count in counts.items():
        if count and count[0] > 1 and len(set(count)) == 1:
            return separator
    return max(reversed(SEPARATORS), key=lambda separator: counts[separator][:1])


def _with_points(rows: Rows, name: str) -> Rows:
    """Return rows with decimal points in place of commas, if all their numbers have such."""
    items = [item for row in rows for cell in row if "," in cell for item in cell.split()]
    commas = [item for item in items if COMMA.fullmatch(item)]
    if grouped := next((item for item in items if item.count(",") and _is_grouped(item)), ""):
        raise ValueError(f"{name} has the number {grouped}; numbers must have no separators of thousands")
    if not commas:
        return rows
    if point := next((item for row in rows for cell in row for item in cell.split() if POINT.fullmatch(item)), ""):
        raise ValueError(f"{name} has numbers with a point, {point}, and with a comma, {commas[0]}; use points alone")
    if all(map(GROUP.fullmatch, commas)):
        value = commas[0].replace(",", "")
        raise ValueError(f"{name} has the number {commas[0]}, which may be {value} or {commas[0].replace(',', '.')}")
    return [[_plain(cell) if "," in cell else cell for cell in row] for row in rows]


def _is_grouped(item: str) -> bool:
    return GROUPED.fullmatch(item) is not None and not COMMA.fullmatch(item)


def _plain(cell: str) -> str:
    """Return a cell with points in place of commas, if all its items, separated by blanks, are numbers."""
    items: Sequence[str] = cell.split()
    return cell.replace(",", ".") if all(COMMA.fullmatch(i) or re.fullmatch(r"[+-]?\d+", i) for i in items) else cell
