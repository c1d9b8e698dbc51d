"""Selects variables and times of a run for figures and files, and writes CSV and MAT files."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path

import numpy as np

from amb_cosim.cosim.record.signals import AT_STEPS, Signals, variables_of
from amb_cosim.cosim.system.tables import moment_of
from amb_cosim.cosim.system.values import Raw
from amb_files.atomic import write_atomically
from amb_files.checks import as_names, repeated
from amb_files.suggestions import suggest
from amb_files.wildcards import matching_names
from array_types import Array, Bools

MAT_NAME, UNITS = 63, "units"  # characters that MATLAB allows; the variable with all units
KEYWORDS = (
    *("break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global"),
    *("if", "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while"),
)


@dataclass(frozen=True)
class Selection:
    """Variables of a run, in order, and the selected samples."""

    dataset: Signals
    names: tuple[str, ...]
    within: Bools

    def values(self, name: str) -> Array:
        """Return the selected samples of a variable, or of `time` (s)."""
        return np.asarray(self.dataset[name].values, np.float64)[self.within]

    def unit(self, name: str) -> str:
        """Return the unit of a variable."""
        return str(self.dataset[name].attrs.get("units", "1"))


def select(
    dataset: Signals,
    variables: Sequence[str | Sequence[str]] = (),
    begin: Raw | None = None,
    until: Raw | None = None,
    figures: Sequence[str] = (),
) -> Selection:
    """Return the variables that match names or patterns (default: all), within a time range.

    Parameters
    ----------
    dataset
        The record of the run.
    variables
        Names `component.variable`, with or without the component, and wildcards `*` and `?`: `left.x`, `*.f_n`.
    begin, until
        Beginning and end: a time (s), a text with its unit, or `cycle 5`; by default those of the record.
    figures
        Names of figures, which an error message also suggests.

    Raises
    ------
    ValueError
        If nothing matches a name, a time is invalid, or there is no sample in the range.
    """
    available = [name for name in variables_of(dataset) if not name.endswith(AT_STEPS)]
    chosen: dict[str, None] = {}
    for pattern in chain.from_iterable(as_names("variables", each) for each in variables):
        matching = [name for name in available if name == pattern or name.partition(".")[2] == pattern]
        matching = matching or matching_names(available, pattern) or matching_names(available, f"*.{pattern}")
        if not matching:
            components = {name.partition(".")[0] for name in available}
            is_whole = pattern.partition(".")[0] in components
            options = available if is_whole else [name.partition(".")[2] or name for name in available]
            raise ValueError(f"no recorded variable matches {pattern!r}; {suggest(pattern, [*figures, *options])}")
        chosen |= dict.fromkeys(matching)
    time, period = np.asarray(dataset["time"].values, np.float64), dataset.attrs.get("period_s")
    first = -np.inf if begin is None else moment_of(begin, period)
    last = np.inf if until is None else moment_of(until, period)
    rounding = np.minimum(1e-12 * np.abs([first, last]), 0.25 * np.diff(time).min(initial=np.inf))  # inf stays
    within = (time >= first - rounding[0]) & (time <= last + rounding[1])
    if not within.any():
        limits = f"{time[0]:.6g} s to {time[-1]:.6g} s" if len(time) else "nothing"
        raise ValueError(
            f"no sample lies between {begin or 'the beginning'} and {until or 'the end'}; the record covers {limits}"
        )
    return Selection(dataset, tuple(chosen) or tuple(available), within)


def to_csv(selection: Selection, path: Path) -> None:
    """Write a table with a column for the time and for each variable; its first row contains names and units."""
    columns = ["time", *selection.names]
    heading = ",".join(f'"{name} [{selection.unit(name)}]"' for name in columns)
    rows = np.column_stack([selection.values(name) for name in columns])
    write_atomically(path, partial(np.savetxt, X=rows, fmt="%.17g", delimiter=",", header=heading, comments=""))


def mat_name(name: str) -> str:
    """Return a name that MATLAB allows, which contains only ASCII letters, digits and _ and begins with a letter."""
    short = re.sub("[^A-Za-z0-9]", "_", name)
    return short if short[:1].isalpha() and short not in KEYWORDS else f"x_{short}"


def to_mat(selection: Selection, path: Path) -> None:
    """Write a MAT file of version 5: `time`, each variable by its `mat_name`, and `units`.

    Raises
    ------
    ValueError
        If two variables would have the same name, or a name is longer than MATLAB allows.
    """
    from scipy.io import savemat

    names = {name: mat_name(name) for name in ("time", *selection.names)}
    for name, short in names.items():
        if len(short) > MAT_NAME:
            raise ValueError(
                f"{name} cannot be written to a MAT file: its name must have at most {MAT_NAME} characters"
            )
    if duplicates := repeated([*names.values(), UNITS]):
        two = " and ".join([name for name, short in names.items() if short == duplicates[0]])
        raise ValueError(
            f"{two} cannot be written to a MAT file: {duplicates[0]} would be the name of two variables; select "
            f"variables by name"
        )
    content: dict[str, object] = {short: selection.values(name) for name, short in names.items()}
    content[UNITS] = {short: selection.unit(name) for name, short in names.items()}
    options = {"appendmat": False, "long_field_names": True, "oned_as": "column"}
    write_atomically(path, lambda file: savemat(str(file), content, **options))
