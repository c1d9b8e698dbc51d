"""Measured data from tables (`.csv`, `.tsv` or `.txt`), whose first row contains names and units.

time [s], fan.x [mm], fan.f_x [N]                                   a record over time
frequency [Hz], y/u amplitude [m/N], y/u phase [deg]                responses; also y/u real and y/u imag,
                                                                    and y/u coherence
frequency [Hz], damping ratio                                       modes

An amplitude may be in decibels relative to a reference a_0, for example `dB re 1 m/N` or `dB re 1e-6 m/N`:

    a = a_0 10^(L/20)                                                                                    (1)
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from amb_analysis.measured.records import FrequencyResponse, Measurement, Modes, TimeRecord, response_above_zero
from amb_analysis.measured.units import StatedUnits, even_step, factor_to, si_channel, split_quotient
from amb_files.csv_files import Rows, read_numbers
from array_types import Array

HEADING = re.compile(  # without blanks around it
    r"(?P<name>[^\[\]()]*[^\[\]()\s])\s*(?:\[(?P<unit>[^\[\]]*)\]|\((?P<round>.*)\))?"
)
KINDS = {"magnitude": "amplitude", "imaginary": "imag"}  # other names
CURVE = re.compile(
    r"(?P<output>[^/]+)/(?P<input>[^/]+) (?P<kind>amplitude|magnitude|phase|real|imag|imaginary|coherence)",
    re.IGNORECASE,
)
DECIBEL = re.compile(
    r"dB\b[\s,]*(?:re(?:f|l)?\b\.?:?)?\s*(?:(?P<size>\d+(?:\.\d*)?(?:e[-+]?\d+)?)(?=[\s(])\s*)?(?P<unit>.*)",
    re.IGNORECASE,
)
MOST_BYTES = 2**28
SHOWN = 60  # characters of a row
MOST_PHASE = 1e9  # rad, beyond which its decimals are lost
HALF_TURN = 1.05 * np.pi  # rad, between neighbours of an unwrapped phase, which may be rounded

Column = tuple[str, Array]  # unit and numbers


def read_table(path: Path, units: StatedUnits) -> Measurement | TimeRecord:
    """Return the content of a table; `units` contains the units that the user states, by column name.

    Raises
    ------
    ValueError
        If the table cannot be read, or a heading, a unit or a number is not allowed.
    """
    columns = _columns(path, units)
    first = next(iter(columns))
    unit, values = columns.pop(first)
    if first.lower() == "time":
        return _record(even_step(values) * factor_to("s", unit, first), columns)
    if first.lower() != "frequency":
        raise ValueError(f"its first column is {first!r}; it must be time or frequency")
    frequencies = values * factor_to("Hz", unit, first)
    if [name.lower() for name in columns] == ["damping ratio"]:
        ((name, (unit, ratios)),) = columns.items()
        return Measurement(modes=Modes(frequencies, ratios * _ratio(unit, name)))
    with np.errstate(invalid="ignore"):  # infinite numbers, which the response refuses but at 0 Hz
        return Measurement(_responses(frequencies, columns))


def _columns(path: Path, stated: StatedUnits) -> dict[str, Column]:
    names_and_units, numbers = read_numbers(path, "it", _numbers, MOST_BYTES)
    heads = [HEADING.fullmatch(cell.strip()) for cell in names_and_units]
    if None in heads:
        raise ValueError(f"heading {names_and_units[heads.index(None)]!r} is not allowed; it must be 'name [unit]'")
    names = [head["name"] for head in heads if head]
    if len(set(names)) < len(names):
        raise ValueError("two columns have the same name")
    units = [stated.of(head["name"], (head["unit"] or head["round"] or "").strip()) for head in heads if head]
    return {name: (unit, numbers[:, k]) for k, (name, unit) in enumerate(zip(names, units, strict=True))}


def _numbers(_: list[str], rows: Rows) -> Array:
    """Return the numbers in rows that may have blank or quoted cells; a blank cell becomes NaN."""
    try:
        numbers = np.array([[float(cell) if cell.strip() else np.nan for cell in row] for row in rows])
    except ValueError as error:
        raise ValueError(f"a cell is not a number: {error}") from None
    for k, row in enumerate(rows):
        text = "".join(row)  # Python reads 1_0 and digits of any script as numbers
        if "_" in text or not text.isascii():
            raise ValueError(
                f"row {k + 1} below the headings, {', '.join(row)[:SHOWN]!r}, may contain only decimal numbers"
            )
    return numbers


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
            raise ValueError(f"column {name!r} is not allowed; it must have the form 'fan.x/fan.f_x amplitude'")
        kind = match["kind"].lower()
        curves.setdefault((match["output"], match["input"]), {})[KINDS.get(kind, kind)] = column
    return tuple(_response(frequencies, *ends, parts) for ends, parts in curves.items())


def _response(frequencies: Array, output: str, source: str, parts: Mapping[str, Column]) -> FrequencyResponse:
    name = f"{output}/{source}"
    if {"amplitude", "phase"} <= set(parts):
        first = "amplitude"
        unit, amplitude = parts[first]
        phase_unit, phase = parts["phase"]
        unit, amplitude = _linear(unit, amplitude, f"{name} {first}")
        if (negative := amplitude[(frequencies != 0.0) & (amplitude < 0.0)]).size:
            raise ValueError(
                f"{name} amplitude {negative[0]:g} {unit} is not allowed; it must be >= 0; for decibels, "
                f"state the unit as [dB re 1 {unit}]"
            )
        values = amplitude * np.exp(1j * _radians(phase_unit, phase, f"{name} phase"))
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
    coherence = None
    if "coherence" in parts:
        of_coherence, coherence = parts["coherence"]
        coherence = coherence * _ratio(of_coherence, f"{name} coherence")
    return response_above_zero(output_channel, input_channel, frequencies, values * (factor / divisor), coherence)


def _linear(unit: str, amplitude: Array, name: str) -> tuple[str, Array]:
    """Return the unit and the values of an amplitude, converted by (1) if it is in decibels."""
    decibel = DECIBEL.fullmatch(unit)
    if decibel is None:
        return unit, amplitude
    reference = decibel["unit"].strip()
    if reference.startswith("(") and reference.endswith(")") and reference.find(")") == len(reference) - 1:
        reference = reference[1:-1]
    if not reference:
        raise ValueError(
            f"{name} in dB has no reference; state one, for example channel_units={{'{name}': 'dB re 1 m/N'}}"
        )
    size = float(decibel["size"] or 1.0)
    if not 0.0 < size < np.inf:
        raise ValueError(f"{name} in dB has the reference {decibel['size']}, which is not allowed; it must be > 0")
    with np.errstate(over="ignore"):  # infinite numbers, which the response refuses
        return reference, size * 10.0 ** (amplitude / 20.0)


def _radians(unit: str, phase: Array, name: str) -> Array:
    """Return a phase in rad.

    A phase that the file states in rad must either be within one turn, or be unwrapped so that neighbouring values
    differ by at most half a turn. Degrees that are labelled as radians violate both rules and are refused.
    """
    factor = factor_to("rad", unit, name)
    radians = phase * factor
    largest = float(np.max(np.abs(radians), initial=0.0))
    if largest > MOST_PHASE:
        raise ValueError(f"{name} of {largest:g} rad is not allowed; its magnitude must be <= {MOST_PHASE:g} rad")
    if factor == 1.0 and largest > 2.0 * np.pi and (jump := float(np.max(np.abs(np.diff(phase))))) > HALF_TURN:
        raise ValueError(
            f"{name} jumps by {jump:.3g} {unit} between neighbouring lines, so it is neither wrapped nor unwrapped; "
            f"state its unit, for example channel_units={{'{name}': 'deg'}}"
        )
    return np.asarray(radians)


def _ratio(unit: str, name: str) -> float:
    """Return the factor for a number that has no unit or is in percent."""
    return factor_to("1", unit, name) if unit not in ("", "1", "-") else 1.0
