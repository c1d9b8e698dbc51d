"""JSON of typed results: a field's key is its name followed by its unit, which the field's type declares.

speeds: Annotated[Array, "rad/s"]                "speeds_rad_s": [..]
planes: Annotated[Array, JsonKey("planes_z_m")]  "planes_z_m": [..]
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from enum import Enum
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np

# Suffixes of keys, by unit.
SUFFIXES = {
    "rad/s": "rad_s",
    "Hz": "hz",
    "s": "s",
    "m": "m",
    "mm": "mm",
    "rad": "rad",
    "A": "A",
    "N": "N",
    "N.s": "Ns",
    "J": "J",
    "K": "K",
    "kg": "kg",
    "kg.m": "kg_m",
    "kg.m2": "kg_m2",
    "N/m": "N_per_m",
    "N/A": "N_per_A",
    "N.s/m": "Ns_per_m",
    "m/s": "m_per_s",
    "s/m": "s_per_m",
    "m/N": "m_per_N",
    "m/A": "m_per_A",
    "A/m": "A_per_m",
    "deg": "deg",
    "N/s": "N_per_s",
    "1/s": "per_s",
    "%": "percent",
    "samples": "samples",
    "dB": "db",
    "cycle": "cycle",
    "1": "",
}


class Layout(Enum):
    """Special layouts of a field in JSON."""

    OMITTED = "left out"
    OMITTED_IF_NONE = "omitted if None"
    MERGED = "its own fields replace it"
    PAIRS = "complex numbers as pairs [real, imaginary]"


@dataclasses.dataclass(frozen=True)
class JsonKey:
    """A key that differs from the field's name and unit."""

    name: str


def json_data(value: Any) -> Any:
    """Return a result as dicts, lists, numbers and texts for JSON.

    Dataclasses and mappings become objects, arrays become lists, complex arrays become `{"real": .., "imaginary": ..}`,
    and NaN becomes null. A number that is a key is written with six digits, or with all digits if two keys would
    otherwise be equal.

    Raises
    ------
    TypeError
        If a value cannot be written as JSON.
    ValueError
        If a field has a unit that `SUFFIXES` does not list.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _object(value)
    if isinstance(value, Mapping):
        keys = _texts(value, "g")
        keys = keys if len({*keys}) == len(keys) else _texts(value, ".17g")
        return {key: json_data(item) for key, item in zip(keys, value.values(), strict=True)}
    if isinstance(value, list | tuple):
        return [json_data(item) for item in value]
    if isinstance(value, np.ndarray):
        if np.iscomplexobj(value):
            return {"real": value.real.tolist(), "imaginary": value.imag.tolist()}
        return json_data(value.tolist())
    if isinstance(value, np.generic):
        return json_data(value.item())
    if isinstance(value, float):
        return None if np.isnan(value) else value
    if value is None or isinstance(value, bool | int | str):
        return value
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def _texts(keys: Iterable[Any], form: str) -> list[str]:
    return [key if isinstance(key, str) else format(key, form) for key in keys]


def units_of(owner: type[Any]) -> dict[str, str]:
    """Return the units of those fields of a dataclass that have a unit, by the names of the fields."""
    return {name: unit for name, notes in _notes(owner).items() for unit in notes if isinstance(unit, str)}


def _notes(owner: type[Any]) -> dict[str, tuple[Any, ...]]:
    """Return the annotations of each field of a dataclass."""
    hints = get_type_hints(owner, include_extras=True)
    annotated = {name: get_args(hint)[1:] if get_origin(hint) is Annotated else () for name, hint in hints.items()}
    return {field.name: annotated[field.name] for field in dataclasses.fields(owner)}


def _object(value: Any) -> dict[str, Any]:
    data: dict[str, Any] = {}
    for name, notes in _notes(type(value)).items():
        item, key = getattr(value, name), _key(name, notes)
        if Layout.OMITTED in notes or (item is None and Layout.OMITTED_IF_NONE in notes):
            continue
        if Layout.MERGED in notes:
            data |= json_data(item)
        elif Layout.PAIRS in notes:
            data[key] = np.stack([item.real, item.imag], axis=-1).tolist()
        else:
            data[key] = json_data(item)
    return data


def _key(name: str, notes: tuple[Any, ...]) -> str:
    key = name
    for note in notes:
        if isinstance(note, JsonKey):
            key = note.name
        elif isinstance(note, str):
            if note not in SUFFIXES:
                raise ValueError(f"{name} has the unit {note!r}, which is not allowed; it must be one of {[*SUFFIXES]}")
            key = f"{name}_{SUFFIXES[note]}".rstrip("_")
    return key
