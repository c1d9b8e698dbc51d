"""Parameters of a rotor file by their keys, and the rotor with other values on a mesh that moves with them.

If a position or a length changes, the nodes of the mesh move. If the ends of sections and the positions of parts are b
at the start and b' after a change, a node at z moves to

    z' = b'_k + (z - b_k) (b'_k+1 - b'_k)/(b_k+1 - b_k),   b_k <= z <= b_k+1                        (1)

Responses are therefore smooth functions of the parameters. Positions of measurements do not move.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from amb_analysis.studies.inputs import Number
from amb_files.checks import as_names, repeated
from amb_files.pack_file import rotor_path
from amb_files.plain_values import plain_value
from amb_files.suggestions import suggest
from amb_files.toml import read_toml
from array_types import Array
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor, rotor_from

COARSE = {"modes": 1, "accuracy": 0.99}  # no element is divided: the nodes of the first mesh are added instead


@dataclass(frozen=True)
class RotorParameters:
    """A rotor file, and the keys of those numbers in it that may change.

    data
        Content of the file.
    nodes
        Nodes of its mesh (m).
    fixed
        Positions of nodes that do not move (m).
    names, start
        Keys of the numbers, such as `bodies.wheel.mass`, and their values in the file.
    """

    data: Mapping[str, Any]
    nodes: tuple[float, ...]
    fixed: tuple[float, ...]
    names: tuple[str, ...]
    start: tuple[float, ...]

    @classmethod
    def load(cls, source: str | Path | None, names: Sequence[str], fixed: Sequence[float] = ()) -> RotorParameters:
        """Read a rotor file.

        Raises
        ------
        ValueError
            If the file cannot be read, or if a name does not denote a number in it.
        """
        rotor, path = load_rotor(source), rotor_path(source)
        data = read_toml(path, f"rotor file {path}")
        start = tuple(_number(data, name) for name in names)
        on_shaft = tuple(z for z in fixed if rotor.shaft.nodes[0] <= z <= rotor.shaft.nodes[-1])
        return cls(data, rotor.shaft.with_nodes_at(on_shaft).nodes, on_shaft, tuple(names), start)

    def data_with(self, values: Array) -> dict[str, Any]:
        """Return the content of the rotor file with other values of the parameters."""
        data = deepcopy(dict(self.data))
        for name, value in zip(self.names, values, strict=True):
            holder, key = _holder(data, name)
            holder[key] = float(value)
        return data

    def rotor_with(self, values: Array | Sequence[float]) -> Rotor:
        """Return the rotor with other values of the parameters, on a mesh whose nodes move according to (1).

        Raises
        ------
        ValueError
            If the rotor is impossible, or if two positions coincide that did not coincide at the start.
        """
        rotor = self._coarse(values)
        old, new = self._begun, rotor.shaft.with_nodes_at(self.fixed).nodes
        if len(old) != len(new):
            raise ValueError(
                "the fit moved two positions (of sections, parts or measured channels) to the same place; narrow the "
                "bounds of positions and lengths"
            )
        moved = self.nodes if old == new else tuple(float(z) for z in np.interp(self.nodes, old, new))
        return rotor.on_mesh(rotor.shaft.with_nodes_at(moved))

    @cached_property
    def _begun(self) -> tuple[float, ...]:
        """Positions b in (1)."""
        return self._coarse(self.start).shaft.with_nodes_at(self.fixed).nodes

    def _coarse(self, values: Array | Sequence[float]) -> Rotor:
        """Return the rotor with nodes only at the ends of its sections and at its parts."""
        data = self.data_with(values)  # type: ignore[arg-type]
        if "mesh" in data or "sections" in data["shaft"]:
            data["mesh"] = COARSE
        return rotor_from(data, "the fitted rotor")


def free_bounds(free: Mapping[str, tuple[Number, Number]] | str | Sequence[str]) -> dict[str, tuple[Number, Number]]:
    """Return the lowest and the highest allowed value of each parameter, by name, as the user wrote them.

    Raises
    ------
    ValueError
        If there are no parameters, or a name has two pairs of bounds.
    """
    pairs = list(free.items()) if isinstance(free, Mapping) else [_split(text) for text in as_names("free", free)]
    if not pairs:
        raise ValueError("free is missing; name a parameter with its bounds, such as bodies.wheel.mass=3:5")
    if twice := repeated(name for name, _ in pairs):
        raise ValueError(f"free contains {twice[0]} twice; a parameter must have one pair of bounds")
    return dict(pairs)


def number_of_file(name: str, raw: Number) -> float:
    """Return a bound of a parameter as a number, in the unit of the rotor file."""
    try:
        return float(plain_value(raw, name))
    except ValueError:
        raise ValueError(
            f"a bound in free is not a number: {name} = {raw!r}; bounds have the unit of the file"
        ) from None


def _split(text: str) -> tuple[str, tuple[str, str]]:
    name, sign, bounds = text.partition("=")
    low, colon, high = bounds.partition(":")
    if not (name and sign and colon):
        raise ValueError(f"free = {text!r} is not allowed; it must be NAME=LOWEST:HIGHEST")
    return name.strip(), (low, high)


def _number(data: dict[str, Any], name: str) -> float:
    holder, key = _holder(data, name)
    value = holder[key]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"parameter {name!r} is not allowed; it is {type(value).__name__}, not a number")
    return float(value)


def _holder(data: dict[str, Any], name: str) -> tuple[Any, Any]:
    """Return the table or list that contains a number, and the key of the number in it."""
    holder: Any = data
    *path, last = name.split(".")
    for part in path:
        holder = holder[_key(holder, part, name)]
    return holder, _key(holder, last, name)


def _key(holder: Any, part: str, name: str) -> Any:
    """Return the key or index for a part of a name: a key of a table, or the name or number (from 1) of a list item."""
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
