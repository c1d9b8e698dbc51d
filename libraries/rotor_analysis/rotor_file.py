"""Reads the description of a rotor from a TOML file; `rig.toml` is one to copy."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rotor_analysis.rotor import Bearing, Body, Planes, Rotor, Shaft, Tensor

RIG = Path(__file__).parent / "rig.toml"


def load_rotor(path: Path = RIG) -> Rotor:
    """Read a rotor description.

    Parameters
    ----------
    path
        TOML file with `name` and `[shaft]`, and if wanted `[[bodies]]`, `[[bearings]]` and `[planes]`; the rig of the
        thesis by default.

    Raises
    ------
    ValueError
        If the file cannot be read, has a missing or unknown entry, or a value out of range.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ValueError(f"rotor file {path} cannot be read: {error}") from error
    try:
        return _rotor(data)
    except ValueError as error:
        raise ValueError(f"rotor file {path}: {error}") from error


def _rotor(data: dict[str, Any]) -> Rotor:
    _check(data, "the file", ("name", "shaft"), ("bodies", "bearings", "planes"))
    return Rotor(
        name=str(data["name"]),
        shaft=_shaft(_table(data, "shaft")),
        bodies=tuple(_body(table) for table in _tables(data, "bodies")),
        bearings=tuple(_bearing(table) for table in _tables(data, "bearings")),
        planes=_planes(_table(data, "planes")) if "planes" in data else Planes(),
    )


def _shaft(table: Mapping[str, Any]) -> Shaft:
    material = ("youngs_modulus", "density", "poissons_ratio")
    _check(table, "[shaft]", ("nodes", "diameter", *material), ("inner_diameter", "theory"))
    return Shaft(
        nodes=_numbers(table["nodes"], "shaft.nodes"),
        diameter=_numbers(table["diameter"], "shaft.diameter"),
        inner_diameter=_numbers(table.get("inner_diameter", 0.0), "shaft.inner_diameter"),
        theory=table.get("theory", "timoshenko"),
        **{name: _number(table[name], f"shaft.{name}") for name in material},
    )


def _body(table: Mapping[str, Any]) -> Body:
    shape, inertias = ("radius", "width"), ("diametral_inertia", "polar_inertia")
    given = shape if set(shape) & set(table) else inertias
    _check(table, "[[bodies]]", ("name", "node", "mass", *given), ())
    name = str(table["name"])
    numbers = {key: _number(table[key], f"{name}.{key}") for key in ("mass", *given)}
    make: Any = Body.disc if given == shape else Body
    body: Body = make(name=name, node=table["node"], **numbers)
    return body


def _bearing(table: Mapping[str, Any]) -> Bearing:
    _check(table, "[[bearings]]", ("name", "node"), ("stiffness", "damping"))
    name = str(table["name"])
    tensors = {key: _tensor(table.get(key, 0.0), f"{name}.{key}") for key in ("stiffness", "damping")}
    return Bearing(name, table["node"], **tensors)


def _planes(table: Mapping[str, Any]) -> Planes:
    _check(table, "[planes]", (), ("master", "discs", "sensors", "retainers"))
    for name, nodes in table.items():
        if not isinstance(nodes, list):
            raise ValueError(f"planes.{name} = {nodes} is not allowed; it must be a list of node numbers")
    return Planes(**{name: tuple(nodes) for name, nodes in table.items()})


def _check(table: Mapping[str, Any], where: str, needed: tuple[str, ...], optional: tuple[str, ...]) -> None:
    missing = [name for name in needed if name not in table]
    unknown = sorted(set(table) - {*needed, *optional})
    if missing:
        raise ValueError(f"{where}: {', '.join(missing)} is missing")
    if unknown:
        raise ValueError(f"{where}: {', '.join(unknown)} is unknown; there are {', '.join((*needed, *optional))}")


def _table(data: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    if not isinstance(data[name], dict):
        raise ValueError(f"{name} = {data[name]!r} is not allowed; it must be a table [{name}]")
    return dict(data[name])


def _tables(data: Mapping[str, Any], name: str) -> list[Mapping[str, Any]]:
    tables = data.get(name, [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise ValueError(f"{name} = {tables!r} is not allowed; it must be tables [[{name}]]")
    return tables


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} = {value!r} is not allowed; it must be a number")
    return float(value)


def _numbers(value: Any, name: str) -> tuple[float, ...]:
    return tuple(_number(item, name) for item in (value if isinstance(value, list) else [value]))


def _tensor(value: Any, name: str) -> Tensor:
    """A number stands for the same in both axes."""
    if not isinstance(value, list):
        diagonal = _number(value, name)
        return ((diagonal, 0.0), (0.0, diagonal))
    if len(value) != 2 or not all(isinstance(row, list) and len(row) == 2 for row in value):
        raise ValueError(f"{name} = {value} is not allowed; it must be a number or [[xx, xy], [yx, yy]]")
    (xx, xy), (yx, yy) = ([_number(item, name) for item in row] for row in value)
    return ((xx, xy), (yx, yy))
