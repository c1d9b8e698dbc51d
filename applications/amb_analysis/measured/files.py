"""Reader of measured data; the suffix of a file selects its format, and a folder is read as the result of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from amb_analysis.measured.array_data import read_array_data
from amb_analysis.measured.estimates import estimate
from amb_analysis.measured.records import FrequencyResponse, Measurement, TimeRecord
from amb_analysis.measured.run_data import read_run
from amb_analysis.measured.table_data import read_table
from amb_analysis.measured.uff_data import read_uff
from amb_analysis.measured.units import StatedUnits
from amb_files.array_files import SUFFIXES as ARRAYS
from amb_files.suggestions import suggest

UFF = (".uff", ".unv", ".uf", ".58")
TABLES = (".csv", ".tsv", ".txt")
RUN = "result.nc"


def read_measured(
    path: str | Path,
    names: Mapping[str, str] | None = None,
    inputs: Sequence[str] = (),
    units: Mapping[str, str] | None = None,
    decay: float = 0.0,
    **estimation: Any,
) -> Measurement:
    """Return the frequency responses or modes of a file, in SI units.

    Parameters
    ----------
    path
        UFF (`.uff`, `.unv`; sets 58 and 55), arrays (`.mat`, `.npz`), a table (`.csv`, `.tsv`, `.txt`), or the
        result of a run.
    names
        Names of the channels in the model, by their names in the file.
    inputs, estimation
        Arguments of `estimate`, for a file that contains a record over time.
    units
        Units, by the names of columns or channels in the file; they replace units in the file, or supply missing ones.
    decay
        Rate 1/tau (1/s) of the exponential window with which the responses of the file were measured, or with which
        those of a record are to be estimated; 0 for none.

    Raises
    ------
    ValueError
        If the file cannot be read, or a name or number in it is not allowed; the message begins with the name of the
        file.
    """
    path = Path(path)
    try:
        stated = StatedUnits(units or {})
        content = _content(path, stated, inputs, names or {})
        stated.check()
        if isinstance(content, TimeRecord):
            warnings = (content.warning,) if content.warning else ()
            content = Measurement(estimate(content, inputs, decay=decay, **estimation), warnings=warnings)
        curves = (replace(curve, decay=decay or curve.decay) for curve in content.responses)
        return replace(content, responses=_renamed(tuple(curves), names or {}))
    except ValueError as error:
        raise ValueError(f"measured data {path}: {error}") from error


def _content(
    path: Path, units: StatedUnits, inputs: Sequence[str], names: Mapping[str, str]
) -> Measurement | TimeRecord:
    if path.is_dir() or path.suffix == ".nc":
        return read_run(path, (*inputs, *names))
    if not path.is_file():
        raise ValueError("there is no such file")
    suffix = path.suffix.lower()
    if suffix in UFF:
        return read_uff(path, units, names)
    if suffix in ARRAYS:
        return read_array_data(path, units)
    if suffix in TABLES:
        return read_table(path, units)
    allowed = ", ".join((*UFF, *ARRAYS, *TABLES, RUN))
    raise ValueError(f"its suffix {path.suffix!r} is not allowed; it must be one of {allowed}")


def _renamed(responses: Sequence[FrequencyResponse], names: Mapping[str, str]) -> tuple[FrequencyResponse, ...]:
    present = {channel.name for item in responses for channel in (item.output, item.input)}
    for name in names:
        if name not in present:
            raise ValueError(f"there is no channel {name!r}; {suggest(name, sorted(present))}")
    return tuple(replace(r, output=r.output.renamed(names), input=r.input.renamed(names)) for r in responses)
