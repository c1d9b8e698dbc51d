"""Measured data from files of arrays, `.mat` and `.npz`.

Frequency responses:

    frequencies                    n numbers
    frequency_unit                 their unit; Hz if it is missing
    response                       n x outputs x inputs, complex
    coherence                      n x outputs, or n x outputs x inputs; may be missing
    inputs, outputs                names
    input_units, output_units      units

A record over time has `time` or `sample_time`, and an array for each channel. Its units are in a structure `units` with
a field for each channel or, in an `.npz` file, in text arrays `units.NAME`. `Result.to_mat` writes this form. Times are
in s unless `units.time` or `time_unit` is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amb_analysis.measured.records import Channel, Measurement, TimeRecord, response_above_zero
from amb_analysis.measured.units import StatedUnits, even_step, factor_to, si_channel
from amb_files.array_files import read_content


def read_array_data(path: Path, units: StatedUnits) -> Measurement | TimeRecord:
    """Return the content of a file of arrays; `units` contains the units that the user states, by channel name.

    Raises
    ------
    ValueError
        If the file cannot be read, if an array is missing, or if an array has a shape or a unit that is not allowed.
    """
    content = read_content(path)
    if "response" in content:
        return _responses(content, units)
    if "time" in content or "sample_time" in content:
        return _record(content, units)
    raise ValueError("it must have frequencies and response, or time and channels")


def _responses(content: dict[str, Any], units: StatedUnits) -> Measurement:
    required = ("frequencies", "inputs", "outputs", "input_units", "output_units")
    missing = [name for name in required if name not in content]
    if missing:
        raise ValueError(f"it contains response but lacks {', '.join(missing)}")
    inputs, outputs = (_channels(content, kind, units) for kind in ("input", "output"))
    units_of_frequencies = "frequency_unit", "frequency_units", "units.frequencies"
    _refuse_unused_units(content, (*required, *units_of_frequencies))
    frequencies = _numbers(content, "frequencies").ravel() * _factor(content, "Hz", "frequencies", units_of_frequencies)
    shape = (len(frequencies), len(outputs), len(inputs))
    values = _shaped(content, "response", shape)
    coherence = None
    if "coherence" in content:
        if np.size(content["coherence"]) == shape[0] * shape[1] and shape[2] > 1:
            coherence = np.repeat(_shaped(content, "coherence", shape[:2])[:, :, None], shape[2], axis=2)
        else:
            coherence = _shaped(content, "coherence", shape).real
    with np.errstate(invalid="ignore"):  # infinite numbers, which the response refuses but at 0 Hz
        return Measurement(
            tuple(
                response_above_zero(
                    output,
                    source,
                    frequencies,
                    np.asarray(values[:, k, j] * (factor / divisor), np.complex128),
                    None if coherence is None else coherence[:, k, j].real,
                )
                for k, (factor, output) in enumerate(outputs)
                for j, (divisor, source) in enumerate(inputs)
            )
        )


def _channels(content: dict[str, Any], kind: str, stated: StatedUnits) -> list[tuple[float, Channel]]:
    """Return, for each channel, the factor to its SI unit, and the channel in this unit."""
    names, units = (_texts(content, key) for key in (f"{kind}s", f"{kind}_units"))
    if len(units) != len(names):
        raise ValueError(f"{kind}_units has {len(units)} units; it must have {len(names)}, one for each {kind}")
    return [si_channel(name, stated.of(name, unit)) for name, unit in zip(names, units, strict=True)]


def _record(content: dict[str, Any], stated: StatedUnits) -> TimeRecord:
    first = "time" if "time" in content else "sample_time"
    units_of_time = "time_unit", "time_units", f"units.{first}"
    _refuse_unused_units(content, units_of_time)
    factor = _factor(content, "s", first, units_of_time)
    if "time" in content:
        times = _numbers(content, "time").ravel()
        step, n = even_step(times) * factor, len(times)
    else:
        step = float(_numbers(content, "sample_time").ravel()[0]) * factor
        n = max((np.size(value) for value in content.values()), default=0)
        if not step > 0.0:
            raise ValueError(f"sample_time = {step:g} s is not allowed; it must be > 0 s")
    signals = {}
    for name, value in content.items():
        if name not in ("time", "sample_time") and value.dtype.kind in "fiu" and np.size(value) == n:
            unit = _texts(content, f"units.{name}") if f"units.{name}" in content else [""]
            if len(unit) != 1:
                raise ValueError(f"units.{name} has {len(unit)} texts; it must have one")
            factor, channel = si_channel(name, stated.of(name, unit[0]))
            signals[channel] = factor * np.asarray(value, np.float64).ravel()
    if not signals:
        raise ValueError(f"it has no channel: apart from the times, it contains no array of {n} numbers")
    return TimeRecord(step, signals)


def _factor(content: dict[str, Any], target: str, name: str, keys: Sequence[str]) -> float:
    """Return the factor to the unit `target` from the unit stated in any of several arrays; 1 if none states a unit."""
    stated = {unit for key in keys if key in content for unit in _texts(content, key)}
    if len(stated) > 1:
        raise ValueError(f"{name} has the units {', '.join(sorted(stated))}; it must have one unit")
    return factor_to(target, stated.pop(), name) if stated else 1.0


def _refuse_unused_units(content: dict[str, Any], used: Sequence[str]) -> None:
    """Raise ValueError if a stated unit would be ignored, so that no number is read in the wrong unit."""
    for key, value in content.items():
        is_unit = key.endswith(("unit", "units")) and value.dtype.kind == "U"
        if is_unit and key not in used:
            raise ValueError(f"{key} does not name the units of an array; it must be one of {', '.join(used)}")


def _texts(content: dict[str, Any], key: str) -> list[str]:
    value = np.ravel(content[key])
    if value.dtype.kind != "U":
        raise ValueError(f"{key} is not allowed; it must be text")
    return [item.strip() for item in value.tolist()]


def _numbers(content: dict[str, Any], key: str) -> np.ndarray:
    value = np.asarray(content[key])
    if value.dtype.kind not in "fiu" or not value.size:
        raise ValueError(f"{key} is not allowed; it must be numbers")
    return value.astype(np.float64)


def _shaped(content: dict[str, Any], key: str, shape: tuple[int, ...]) -> np.ndarray:
    """Return an array of numbers in its expected shape, including trailing dimensions of length 1 that Matlab drops."""
    value = np.asarray(content[key])
    squeezed = tuple(k for k in shape if k != 1)
    if value.dtype.kind not in "fiuc" or tuple(k for k in value.shape if k != 1) != squeezed:
        expected = " x ".join(map(str, shape))
        raise ValueError(f"{key} of shape {value.shape} is not allowed; it must be {expected} numbers")
    return value.reshape(shape)
