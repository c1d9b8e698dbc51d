"""Inputs over time from a table of measured or given values, such as the record of an earthquake.

    time (ms), rotor_contact.base.a_x (m/s2), rotor_contact.base.a_y (m/s2)
    0,         0.00,                          0.00
    5,         0.12,                         -0.03

The first column is the time; each other column is an input, with its name and its unit. Between rows, an input is
linear. If rows are closer together than communication steps, the input is averaged over each step, so that no impulse
is lost.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from amb_cosim.cosim.system.experiment import Profile
from amb_cosim.cosim.system.values import quantity
from amb_files.csv_files import Rows, read_numbers
from array_types import Array


def profiles_of(file: str, begin: float) -> tuple[Profile, ...]:
    """Return the inputs in a file; its time 0 corresponds to `begin` (s).

    Raises
    ------
    ValueError
        If the file cannot be read or has no inputs, if the times in the first column do not ascend, or if a value is
        not a number.
    """
    path = Path(file).resolve()
    return tuple(
        Profile(name, tuple(zip((begin + times).tolist(), values.tolist(), strict=True)), unit=unit)
        for name, unit, times, values in _columns(path, f"profile {file}", _version_of(path))
    )


def _version_of(path: Path) -> tuple[int, int] | None:
    """Return the time of the last change (ns) and the size of a file; None if the file cannot be read."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=8)
def _columns(path: Path, what: str, _version: object) -> tuple[tuple[str, str, Array, Array], ...]:
    def parse(headings: list[str], rows: Rows) -> Array:
        return np.array(list(_numbers(rows, headings, what)))

    headings, numbers = read_numbers(path, what, parse)
    (time, unit), *inputs = (_parted(heading) for heading in headings)
    if time != "time" or not inputs:
        raise ValueError(f"{what} has the columns {', '.join(headings)}; the first must be time, the others inputs")
    if not np.isfinite(numbers).all():
        raise ValueError(f"row {2 + np.argmin(np.isfinite(numbers).all(1))} of {what} has a value that is not finite")
    times, *columns = numbers.T
    times = times * quantity(f"1 {unit or 's'}", "s", f"time of {what}")
    if not np.all(np.diff(times) > 0.0):
        k = int(np.argmin(np.diff(times)))
        raise ValueError(f"{what} has the time {times[k + 1]:g} s after {times[k]:g} s; times must increase")
    return tuple((name, unit, times, column) for (name, unit), column in zip(inputs, columns, strict=True))


def _parted(heading: str) -> tuple[str, str]:
    """Return the name and the unit in a heading; the unit is empty if none is stated."""
    begin = max(heading.rfind("("), heading.rfind("["))
    if begin < 0 or heading[-1] not in ")]":
        return heading, ""
    return heading[:begin].rstrip(), heading[begin + 1 : -1].strip()


def _numbers(rows: list[list[str]], headings: list[str], what: str) -> Iterator[list[float]]:
    for k, row in enumerate(rows, 2):
        values = []
        for heading, text in zip(headings, row, strict=True):
            try:
                if "_" in text or not text.isascii():  # Python reads 1_0 and digits of any script as numbers
                    raise ValueError(text)
                values.append(float(text))
            except ValueError:
                raise ValueError(f"row {k} of {what} has {heading} = {text.strip()!r}, which is not a number") from None
        yield values
