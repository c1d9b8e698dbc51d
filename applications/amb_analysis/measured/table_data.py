"""Measured data from tables, `.csv`, `.tsv` or `.txt`, whose first row has names and units.

time [s], fan.x [mm], fan.f_x [N]                                   a record over time
frequency [Hz], y/u amplitude [m/N], y/u phase [deg]                responses; also y/u real and y/u imag,
                                                                    and y/u coherence
frequency [Hz], damping ratio                                       modes
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from amb_analysis.measured.records import FrequencyResponse, Measurement, Modes, TimeRecord
from amb_analysis.measured.units import StatedUnits, even_step, factor_to, si_channel, split_quotient
from amb_files.csv_files import read_csv
from array_types import Array

HEADING = re.compile(r"\s*(?P<name>[^\[\]]+?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
CURVE = re.compile(r"(?P<output>[^/]+)/(?P<input>[^/]+) (?P<kind>amplitude|phase|real|imag|coherence)")
MOST_BYTES = 2**28

Column = tuple[str, Array]  # unit and numbers


def read_table(path: Path, units: StatedUnits) -> Measurement | TimeRecord:
    """Return the content of a table; `units` are stated by the names of columns.

    Raises
    ------
    ValueError
        If it cannot be read, or a heading, a unit or a number is not allowed.
    """
    columns = _columns(path, units)
    first = next(iter(columns))
    unit, values = columns.pop(first)
    if first == "time":
        return _record(even_step(values * factor_to("s", unit, "time")), columns)
    if first != "frequency":
        raise ValueError(f"its first column is {first!r}; it must be time or frequency")
    frequencies = values * factor_to("Hz", unit, "frequency")
    if list(columns) == ["damping ratio"]:
        unit, ratios = columns["damping ratio"]
        return Measurement(modes=Modes(frequencies, ratios * (0.01 if unit == "%" else 1.0)))
    return Measurement(_responses(frequencies, columns))


def _columns(path: Path, stated: StatedUnits) -> dict[str, Column]:
    names_and_units, rows = read_csv(path, "it", MOST_BYTES)
    heads = [HEADING.fullmatch(cell) for cell in names_and_units]
    if None in heads:
        raise ValueError(f"heading {names_and_units[heads.index(None)]!r} is not allowed; it must be 'name [unit]'")
    names = [head["name"] for head in heads if head]
    if len(set(names)) < len(names):
        raise ValueError("two columns have the same name")
    try:
        numbers = np.array([[float(cell) if cell.strip() else np.nan for cell in row] for row in rows])
    except ValueError as error:
        raise ValueError(f"a cell is not a number: {error}") from None
    units = [stated.of(head["name"], (head["unit"] or "").strip()) for head in heads if head]
    return {name: (unit, numbers[:, k]) for k, (name, unit) in enumerate(zip(names, units, strict=True))}


def _record(step: float, columns: Mapping[str, Column]) -> TimeRecord:
    signals = {}
    for name, (unit, values) in columns.items():
        factor, channel = si_channel(name, unit)
        signals[channel] = factor * values
    return TimeRecord(step, signals)


def _responses(frequencies: Array, columns: Mapping[str, Column]) -> tuple[FrequencyResponse, ...]:
    curves: dict[tuple[str, str], dict[str, Column]] = {}
    for name, column in columns.items():
        match = CURVE.fullmatch(name)
        if not match:
            raise ValueError(f"column {name!r} is not allowed; its form must be that of 'fan.x/fan.f_x amplitude'")
        curves.setdefault((match["output"], match["input"]), {})[match["kind"]] = column
    return tuple(_response(frequencies, *ends, parts) for ends, parts in curves.items())


def _response(frequencies: Array, output: str, source: str, parts: Mapping[str, Column]) -> FrequencyResponse:
    name = f"{output}/{source}"
    if {"amplitude", "phase"} <= set(parts):
        first = "amplitude"
        unit, amplitude = parts[first]
        phase_unit, phase = parts["phase"]
        values = amplitude * np.exp(1j * phase * factor_to("rad", phase_unit, f"{name} phase"))
    elif {"real", "imag"} <= set(parts):
        first = "real"
        unit, real = parts[first]
        if parts["imag"][0] not in (unit, ""):
            raise ValueError(f"{name}: real and imag have different units")
        values = real + 1j * parts["imag"][1]
    else:
        raise ValueError(f"{name} needs the columns amplitude and phase, or real and imag")
    above, below = split_quotient(unit, f"{name} {first}")
    (factor, output_channel), (divisor, input_channel) = si_channel(output, above), si_channel(source, below)
    coherence = parts["coherence"][1] if "coherence" in parts else None
    return FrequencyResponse(output_channel, input_channel, frequencies, values * (factor / divisor), coherence)
