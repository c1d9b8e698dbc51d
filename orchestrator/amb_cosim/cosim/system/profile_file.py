"""Inputs over time from a table of measured or given values, such as the record of an earthquake.

    time (ms), rotor_contact.base.a_x (m/s2), rotor_contact.base.a_y (m/s2)
    0,         0.00,                          0.00
    5,         0.12,                         -0.03

The first column is the time; each other column is an input, with its name and its unit. Between rows, an input is
linear. If rows are closer together than communication steps, the input is averaged over each step, so that no impulse
is lost. An Integer, a Boolean (`true` or 1) or an Enumeration (by name or number) keeps the value of a row until the
next row.

Times that begin `DATES` or more after the start of the run are dates, in seconds since 1970. They count from the first
row.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np

from amb_cosim.cosim.system.experiment import Profile
from amb_cosim.cosim.system.values import Raw, quantity
from amb_files.csv_files import Rows, read_numbers
from array_types import Array

DATES = 1e8  # s, three years
RESOLUTION = 6  # decimals of differences of dates (s), which are rounded to 0.24 us


def profiles_of(file: str, begin: float, start: float = 0.0) -> tuple[Profile, ...]:
    """Return the inputs in a file for a run from `start` (s).

    Its time 0 corresponds to `begin` (s), or its first row if its times are dates.

    Raises
    ------
    ValueError
        If the file cannot be read or has no inputs, if the times in the first column do not ascend, or if a value is
        not a number.
    """
    path = Path(file).resolve()
    return tuple(
        Profile(name, tuple(zip(moments.tolist(), values, strict=True)), unit=unit, file=file, has_dates=has_dates)
        for name, unit, times, values in _columns(path, f"profile {file}", _version_of(path))
        for moments, has_dates in [_in_run(times, begin, start)]
    )


def _in_run(times: Array, begin: float, start: float) -> tuple[Array, bool]:
    """Return the times of rows in a run (s), and whether they were dates."""
    if begin + times[0] - start < DATES:
        return begin + times, False
    return begin + np.round(times - times[0], RESOLUTION), True


def _version_of(path: Path) -> tuple[int, int] | None:
    """Return the time of the last change (ns) and the size of a file; None if the file cannot be read."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=8)
def _columns(path: Path, what: str, _version: object) -> tuple[tuple[str, str, Array, tuple[Raw, ...]], ...]:
    texts: dict[int, tuple[Raw, ...]] = {}

    def parse(headings: list[str], rows: Rows) -> Array:
        numbers = np.zeros((len(rows), len(headings)))
        for j, cells in enumerate(zip(*rows, strict=True)):
            column = tuple(map(_cell, cells))
            wrong = next((k for k, cell in enumerate(column) if isinstance(cell, str)), None)
            if wrong is None:
                numbers[:, j] = column
            elif j:
                texts[j] = column
            else:
                raise ValueError(
                    f"row {2 + wrong} of {what} has {headings[0]} = {column[wrong]!r}, which is not a number"
                )
        return numbers

    headings, numbers = read_numbers(path, what, parse)
    (time, unit), *inputs = (_parted(heading) for heading in headings)
    if time != "time" or not inputs:
        raise ValueError(f"{what} has the columns {', '.join(headings)}; the first must be time, the others inputs")
    if not np.isfinite(numbers).all():
        raise ValueError(f"row {2 + np.argmin(np.isfinite(numbers).all(1))} of {what} has a value that is not finite")
    times, *columns = numbers.T
    values = [texts.get(j) or tuple(column.tolist()) for j, column in enumerate(columns, 1)]
    times = times * quantity(f"1 {unit or 's'}", "s", f"time of {what}")
    if not np.all(np.diff(times) > 0.0):
        k = int(np.argmin(np.diff(times)))
        raise ValueError(f"{what} has the time {times[k + 1]:g} s after {times[k]:g} s; times must increase")
    return tuple((name, unit, times, column) for (name, unit), column in zip(inputs, values, strict=True))


def _parted(heading: str) -> tuple[str, str]:
    """Return the name and the unit in a heading; the unit is empty if none is stated."""
    begin = max(heading.rfind("("), heading.rfind("["))
    if begin < 0 or heading[-1] not in ")]":
        return heading, ""
    return heading[:begin].rstrip(), heading[begin + 1 : -1].strip()


def _cell(text: str) -> float | str:
    """Return the number in a cell, or its text if it is not a number."""
    text = text.strip()
    if "_" in text or not text.isascii():  # Python reads 1_0 and digits of any script as numbers
        return text
    try:
        return float(text)
    except ValueError:
        return text
