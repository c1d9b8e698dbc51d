"""Parameters of a rotor file by their keys, and the rotor with other values of them on one mesh."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from amb_analysis.measured.least_squares import FreeParameter
from amb_analysis.studies.inputs import Number
from amb_files.pack_file import rotor_path
from amb_files.suggestions import suggest
from amb_files.toml import read_toml
from array_types import Array
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor, rotor_from

COARSE = {"modes": 1, "accuracy": 0.99}  # no element is divided: the nodes of the first mesh are added instead


@dataclass(frozen=True)
class RotorParameters:
    """A rotor file and the names of some of its numbers.

    data
        Content of the file.
    nodes
        Nodes of its mesh (m), which do not change.
    names, start
        Keys of the numbers, such as `bodies.wheel.mass`, and their values in the file.
    """

    data: Mapping[str, Any]
    nodes: tuple[float, ...]
    names: tuple[str, ...]
    start: tuple[float, ...]

    @classmethod
    def load(cls, source: str | Path | None, names: Sequence[str]) -> RotorParameters:
        """Read a rotor file.

        Raises
        ------
        ValueError
            If it cannot be read, or a name is not that of a number in it.
        """
        rotor, path = load_rotor(source), rotor_path(source)
        data = read_toml(path, f"rotor file {path}")
        start = tuple(_number(data, name) for name in names)
        return cls(data, rotor.shaft.nodes, tuple(names), start)

    def data_with(self, values: Array) -> dict[str, Any]:
        """Return the content with other values of the parameters."""
        data = deepcopy(dict(self.data))
        for name, value in zip(self.names, values, strict=True):
            holder, key = _holder(data, name)
            holder[key] = float(value)
        return data

    def rotor_with(self, values: Array | Sequence[float]) -> Rotor:
        """Return the rotor with other values of the parameters, on the same mesh."""
        data = self.data_with(values)  # type: ignore[arg-type]
        if "mesh" in data or "sections" in data["shaft"]:
            data["mesh"] = COARSE
        rotor = rotor_from(data, "the fitted rotor")
        return rotor.on_mesh(rotor.shaft.with_nodes_at(self.nodes))


def free_parameters(free: Mapping[str, tuple[Number, Number]] | Sequence[str]) -> list[FreeParameter]:
    """Return parameters with bounds, in the units of the rotor file.

    Raises
    ------
    ValueError
        If there are no parameters, or bounds are not ascending numbers.
    """
    pairs = list(free.items()) if isinstance(free, Mapping) else [_split(text) for text in free]
    if not pairs:
        raise ValueError("free is missing; name a parameter with its bounds, such as bodies.wheel.mass=3:5")
    names = [name for name, _ in pairs]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"free names {twice[0]} twice; a parameter has one pair of bounds")
    try:
        return [FreeParameter(name, float(low), float(high)) for name, (low, high) in pairs]
    except ValueError as error:
        if "could not convert" in str(error):
            raise ValueError(f"a bound of free is not a number: {error}") from None
        raise


def _split(text: str) -> tuple[str, tuple[str, str]]:
    name, sign, bounds = text.partition("=")
    low, colon, high = bounds.partition(":")
    if not (name and sign and colon):
        raise ValueError(f"free {text!r} is not allowed; it must be NAME=LOWEST:HIGHEST")
    return name.strip(), (low, high)


def _number(data: dict[str, Any], name: str) -> float:
    holder, key = _holder(data, name)
    value = holder[key]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"parameter {name!r} is not allowed; it is {type(value).__name__}, not a number")
    return float(value)


def _holder(data: dict[str, Any], name: str) -> tuple[Any, Any]:
    """Return the table or list that holds a number, and its key there."""
    holder: Any = data
    *path, last = name.split(".")
    for part in path:
        holder = holder[_key(holder, part, name)]
    return holder, _key(holder, last, name)


def _key(holder: Any, part: str, name: str) -> Any:
    """Return the key of a part of a name: a key of a table, an item of a list by its name or its number from 1."""
    if isinstance(holder, dict) and part in holder:
        return part
    if isinstance(holder, list):
        names = [item.get("name") if isinstance(item, dict) else None for item in holder]
        if part in names:
            return names.index(part)
        if part.isdecimal() and 1 <= int(part) <= len(holder):
            return int(part) - 1
        keys = [item for item in names if item] or [str(k + 1) for k in range(len(holder))]
    else:
        keys = list(holder) if isinstance(holder, dict) else []
    raise ValueError(f"parameter {name!r} is not in the rotor file: it has no {part!r}; {suggest(part, keys)}")
