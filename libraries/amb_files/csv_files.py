"""Reads CSV tables in the formats in which tools and spreadsheets of any country save them.

Columns are separated by commas, semicolons or tabs. Fractions are written with decimal points or, throughout the file,
with decimal commas, as in a German spreadsheet. An ambiguous number is refused; for example, `1,500` by itself may be
1500 or 1.5.

Lines that begin with `#` or `%` are comments. If the first line that is not a comment contains numbers, the headings
are read from the last comment above it, where `numpy.savetxt` writes them.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator, Sequence
from io import BytesIO, StringIO, TextIOWrapper
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from amb_files.checks import repeated
from amb_files.toml import LARGEST, read_text

SEPARATORS = {"\t": "tabs", ";": "semicolons", ",": "commas"}
SEPARATOR_LINE = re.compile(r"sep=(.)\r?\n")  # the first line of some files for spreadsheets
SHOWN = 40  # characters of a line
SAMPLED_ROWS = 50  # rows whose number of cells shows the separator
SAMPLED = 2**20  # characters that have them
MOST_CELLS = 2**24  # characters of a table that is read cell by cell, in seconds and less than 1 GB
POWER = r"(?:[eE][+-]?\d+)?"
COMMA = re.compile(rf"[+-]?(?:\d+,\d*|,\d+){POWER}")
POINT = re.compile(rf"[+-]?(?:\d+\.\d*|\.\d+){POWER}")
COMMENT = re.compile(
    r"[ \t]*(?!#(?:REF!|N/A|VALUE!|DIV/0!|NAME\?|NUM!|NULL!))[#%]+"
)  # which are errors of a spreadsheet
HAS_COMMENT = re.compile(r"^[ \t]*[#%]", re.MULTILINE)
NEWLINE = re.compile(r"\r\n?|\n")
NUMBER = re.compile(rf"\s*[\"']?[+-]?(?:\d+[.,]?\d*|[.,]\d+){POWER}(?![^\s,;\"'])")
GROUP = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")  # a group of three digits, or three decimals
GROUPED = re.compile(r"[+-]?\d[\d.,'’]*")  # with any separators

Rows = list[list[str]]
Numbers = NDArray[np.float64]


def read_csv(path: Path, name: str, largest: int = LARGEST) -> tuple[list[str], Rows]:
    """Return the headings of a table, stripped of blanks, and its rows, in which numbers have decimal points.

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
        If the file cannot be read, if two headings are equal, if rows differ in length, or if a number is ambiguous.
    """
    try:
        text, separator = _text_and_separator(path, name, largest)
        rows = list(_rows(text, separator))
    except csv.Error as error:
        raise ValueError(f"{name} cannot be read as a table: {error}") from error
    if len(rows) < 2:
        raise ValueError(f"{name} must have a row of headings and a row of values")
    width = len(rows[0])
    if not rows[0][-1].strip():  # each row may end with separators
        used = max(_used(row) for row in rows if len(row) == width)
        rows = [row[: max(used, 1)] if len(row) == width else row for row in rows]
    headings = [heading.strip() for heading in rows[0]]
    for k, row in enumerate(rows[1:], 2):
        if len(row) != len(headings):
            is_longer = len(row) > len(headings)
            advice = "; with decimal commas, columns must be separated by semicolons" if is_longer else ""
            if len(headings) == 1:
                advice += f"; the first line that is not a comment, {headings[0][:SHOWN]!r}, must contain the headings"
            expected = (
                f"{len(headings)} values, one for each heading, separated by {SEPARATORS.get(separator, separator)}"
            )
            raise ValueError(f"row {k} of {name} must have {expected}; it has {len(row)}{advice}")
    if duplicates := repeated(headings):
        raise ValueError(f"{name} has two columns called {duplicates[0]!r}; headings must be unique")
    return headings, _with_points(rows[1:], name) if separator != "," or '"' in text else rows[1:]


def read_numbers(
    path: Path, name: str, parse: Callable[[list[str], Rows], Numbers], largest: int = LARGEST
) -> tuple[list[str], Numbers]:
    """Return the headings and the numbers, shape (rows, columns), of a table; other arguments are as in `read_csv`.

    A table that contains only numbers with decimal points is read as a whole, which takes a tenth of the time and
    memory of reading it cell by cell. Errors are those of `read_csv`.

    Parameters
    ----------
    parse
        Function that returns the numbers of any other table, given its headings and rows, or raises an error.
    """
    try:
        text, separator = _text_and_separator(path, name, largest)
    except csv.Error as error:
        raise ValueError(f"{name} cannot be read as a table: {error}") from error
    if (numbers := _plain_numbers(text, separator)) is not None:
        return numbers
    if len(text) > MOST_CELLS:
        raise ValueError(
            f"{name} has {len(text) >> 20} MB; above {MOST_CELLS >> 20} MB, each cell must be a decimal number without "
            f"quotes, and each column must have its own heading"
        )
    del text
    headings, rows = read_csv(path, name, largest)
    return headings, parse(headings, rows)


def _plain_numbers(text: str, separator: str) -> tuple[list[str], Numbers] | None:
    """Return headings and numbers, or None if a cell is not a number or a column does not have its own heading."""
    text = text.lstrip("\r\n")
    begin = NEWLINE.search(text)
    if begin is None or '"' in text:
        return None
    headings = [heading.strip() for heading in text[: begin.start()].split(separator)]
    text = text[begin.end() :]
    if not text.isascii() or not text.strip():
        return None
    if separator != "," and "," in text:
        items = re.finditer(rf"[^\s{re.escape(separator)}]*,[^\s{re.escape(separator)}]*", text)
        if "." in text or all(GROUP.fullmatch(item[0]) for item in items):
            return None  # two kinds of decimal signs, or numbers that may mean two
        text = text.replace(",", ".")
    content = BytesIO(text.encode())
    del text
    try:
        numbers = np.loadtxt(TextIOWrapper(content, "ascii"), np.float64, None, separator, ndmin=2)
    except (ValueError, TypeError):  # a cell that is no number, or rows of different lengths
        return None
    is_table = all(headings) and not repeated(headings) and numbers.shape[1] == len(headings)
    return (headings, numbers) if is_table else None


def _text_and_separator(path: Path, name: str, largest: int) -> tuple[str, str]:
    """Return the text of a table without comments, and the separator between its columns."""
    text = read_text(path, name, largest)
    separator_line = SEPARATOR_LINE.match(text)
    text = _without_comments(text[separator_line.end() :] if separator_line else text)
    return text, separator_line[1] if separator_line else _separator(text)


def _without_comments(text: str) -> str:
    """Return the lines that are not comments; if numbers come first, keep the comment above them as headings."""
    if not HAS_COMMENT.search(text):
        return text
    lines = re.split(r"(?<=\n)", text)
    first = next((k for k, line in enumerate(lines) if line.strip() and not COMMENT.match(line)), len(lines))
    above = [line for line in lines[:first] if COMMENT.match(line)]
    kept = [line for line in lines if not COMMENT.match(line)]
    if above and first < len(lines) and NUMBER.match(lines[first]):
        kept.insert(0, COMMENT.sub("", above[-1], count=1))
    return "".join(kept)


def _rows(text: str, separator: str) -> Iterator[list[str]]:
    """Yield the rows that contain at least one value."""
    for row in csv.reader(StringIO(text, newline=""), delimiter=separator):
        if any(cell.strip() for cell in row):
            yield row


def _used(row: list[str]) -> int:
    """Return the number of cells in a row, up to and including the last cell that is not blank."""
    return next((k for k in range(len(row), 0, -1) if row[k - 1].strip()), 0)


def _separator(text: str) -> str:
    """Return the separator that divides the first rows into equally many cells, or else that with most headings."""
    end = text.rfind("\n", 0, SAMPLED)
    sample = text if len(text) <= SAMPLED or end < 0 else text[: end + 1]
    lengths = {sep: [len(row) for row in islice(_rows(sample, sep), SAMPLED_ROWS)] for sep in SEPARATORS}
    for separator, of_rows in lengths.items():
        if of_rows and of_rows[0] > 1 and len(set(of_rows)) == 1:
            return separator
    return max(reversed(SEPARATORS), key=lambda separator: lengths[separator][:1])


def _with_points(rows: Rows, name: str) -> Rows:
    """Return the rows; if all fractions have decimal commas, points replace the commas."""
    items = [item for row in rows for cell in row if "," in cell for item in cell.split()]
    commas = [item for item in items if COMMA.fullmatch(item)]
    if grouped := next((item for item in items if item.count(",") and _is_grouped(item)), ""):
        raise ValueError(f"{name} has the number {grouped}; numbers must not contain thousands separators")
    if not commas:
        return rows
    if point := next((item for row in rows for cell in row for item in cell.split() if POINT.fullmatch(item)), ""):
        raise ValueError(
            f"{name} has numbers with decimal points ({point}) and decimal commas ({commas[0]}); use only points"
        )
    if all(map(GROUP.fullmatch, commas)):
        value = commas[0].replace(",", "")
        raise ValueError(f"{name} contains {commas[0]}, which may mean {value} or {commas[0].replace(',', '.')}")
    return [[_plain(cell) if "," in cell else cell for cell in row] for row in rows]


def _is_grouped(item: str) -> bool:
    return GROUPED.fullmatch(item) is not None and not item.isdecimal() and not COMMA.fullmatch(item)


def _plain(cell: str) -> str:
    """Return a cell; if it contains only numbers, separated by blanks, replace its decimal commas by points."""
    items: Sequence[str] = cell.split()
    return cell.replace(",", ".") if all(COMMA.fullmatch(i) or re.fullmatch(r"[+-]?\d+", i) for i in items) else cell
