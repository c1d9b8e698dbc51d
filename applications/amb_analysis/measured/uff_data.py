"""Measured data from Universal File Format, by pyuff: functions at nodes (sets 58 and 58b) and modes (set 55).

A channel is named by node and direction, `3.x`; data in direction -x are those along x with the opposite sign. Units
are those of the axis labels or, without labels, the SI units of the type of data.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement, Modes, TimeRecord
from amb_analysis.measured.units import even_step, si_channel
from fmi_export.building.extras import require_extra

TIME, RESPONSE, COHERENCE = 1, 4, 6  # types of function
DIRECTIONS = {1: "x", 2: "y", 3: "z"}
SI_BY_TYPE = {8: "m", 11: "m/s", 12: "m/s2", 9: "N", 13: "N", 0: "1", 1: "1"}
SAME_FREQUENCIES = 1e-6  # relative difference between a coherence and its response


def read_uff(path: Path) -> Measurement | TimeRecord:
    """Return the frequency responses with coherence, or the modes, or the time record of a file.

    Raises
    ------
    ValueError
        If it cannot be read, pyuff is not installed, or a unit or direction is not allowed.
    """
    require_extra("measured", "a UFF file", "pyuff")
    import pyuff

    try:
        content = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # pyuff raises plain exceptions
        raise ValueError(f"it cannot be read as UFF: {error}") from error
    sets = [item for item in ([content] if isinstance(content, dict) else content) if isinstance(item, dict)]
    functions = [item for item in sets if item["type"] == 58]
    responses = _responses(functions)
    if responses:
        return Measurement(responses, _modes(sets))
    record = [item for item in functions if item["func_type"] == TIME]
    if record:
        return _record(record)
    modes = _modes(sets)
    if modes is None:
        raise ValueError("it has no frequency response, time record or mode")
    return Measurement((), modes)


def _responses(functions: Sequence[Mapping[str, Any]]) -> tuple[FrequencyResponse, ...]:
    coherences = {_ends(item): item for item in functions if item["func_type"] == COHERENCE}
    result = []
    for item in functions:
        if item["func_type"] != RESPONSE:
            continue
        (factor, output), (divisor, source) = _channel(item, "rsp"), _channel(item, "ref")
        x, y = np.asarray(item["x"], np.float64), np.asarray(item["data"], np.complex128)
        gamma = _coherence(coherences.get(_ends(item)), x)
        above = x > 0.0
        gamma = None if gamma is None else gamma[above]
        result.append(FrequencyResponse(output, source, x[above], y[above] * (factor / divisor), gamma))
    return tuple(result)


def _ends(item: Mapping[str, Any]) -> tuple[Any, ...]:
    names = (str(item[f"{end}_ent_name"]).strip() for end in ("rsp", "ref"))
    return (*names, *(abs(int(item[key])) for key in ("rsp_node", "rsp_dir", "ref_node", "ref_dir")))


def _coherence(item: Mapping[str, Any] | None, frequencies: np.ndarray) -> np.ndarray | None:
    """Return a coherence if it is at the frequencies of its response, otherwise None."""
    if item is None or len(item["x"]) != len(frequencies):
        return None
    same = np.allclose(item["x"], frequencies, rtol=SAME_FREQUENCIES, atol=0.0)
    return np.clip(np.real(item["data"]), 0.0, 1.0) if same else None


def _channel(item: Mapping[str, Any], end: str) -> tuple[float, Channel]:
    """Return the factor to SI with the sign of the direction, and the channel."""
    name, sign = _name(item, end)
    axis = "ordinate" if end == "rsp" else "orddenom"
    label = str(item[f"{axis}_axis_units_lab"]).strip()
    kind = int(item[f"{axis}_spec_data_type"])
    if label in ("", "NONE") and kind not in SI_BY_TYPE:
        raise ValueError(f"channel {name}: data of type {kind} without a unit are not allowed")
    factor, channel = si_channel(name, SI_BY_TYPE[kind] if label in ("", "NONE") else label)
    return sign * factor, channel


def _name(item: Mapping[str, Any], end: str) -> tuple[str, float]:
    direction = int(item[f"{end}_dir"])
    entity, node = str(item[f"{end}_ent_name"]).strip(), int(item[f"{end}_node"])
    place = entity if not node and entity not in ("", "NONE") else str(node)
    if direction == 0:
        return place, 1.0
    if abs(direction) not in DIRECTIONS:
        raise ValueError(f"direction {direction} at node {node} is not allowed; rotations have no channel")
    return f"{place}.{DIRECTIONS[abs(direction)]}", float(np.sign(direction))


def _record(functions: Sequence[Mapping[str, Any]]) -> TimeRecord:
    steps, lengths = {round(even_step(np.asarray(f["x"])), 12) for f in functions}, {len(f["x"]) for f in functions}
    if len(steps) > 1 or len(lengths) > 1:
        raise ValueError("its time records have different times; a record has one sample time")
    signals = {}
    for item in functions:
        factor, channel = _channel(item, "rsp")
        if channel in signals:
            raise ValueError(f"channel {channel.name} occurs twice")
        signals[channel] = factor * np.real(np.asarray(item["data"]))
    return TimeRecord(steps.pop(), signals)


def _modes(sets: Sequence[Mapping[str, Any]]) -> Modes | None:
    """Return the modes of sets 55: normal modes (type 2) and complex eigenvalues (type 3)."""
    pairs = []
    for item in sets:
        if item["type"] == 55 and item["analysis_type"] == 2:
            pairs.append((float(item["freq"]), float(item["modal_damp_vis"])))
        elif item["type"] == 55 and item["analysis_type"] == 3:
            size = abs(complex(item["eig"]))
            pairs.append((abs(complex(item["eig"]).imag) / (2.0 * np.pi), -complex(item["eig"]).real / size))
    if not pairs:
        return None
    frequencies, ratios = np.array(sorted(pairs)).T
    return Modes(frequencies, ratios)
