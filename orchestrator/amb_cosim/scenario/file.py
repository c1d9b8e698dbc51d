"""Reads the TOML file of a scenario and merges it with its base; paths in a file are relative to that file.

A file may have a `base`, which is the name or path of another file. It then contains only the differences: tables are
merged, and everything else is replaced. If it states an end (in cycles or as a time), this end replaces that of the
base. `remove` removes entries of the base: keys of a scenario (`gravity`, `event`), entries of a table (`plot.cycles`,
`fmu.rotor_contact`), and parameters and initial inputs of components (`rotor_contact.contact.law`); `*` and `?` are
wildcards.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

from amb_cosim.cosim.fmu.fmus import models
from amb_cosim.cosim.system.system_file import packaged_systems
from amb_cosim.cosim.system.tables import check_bases
from amb_files.checks import errors_in
from amb_files.pack_file import default_of_pack
from amb_files.packs import PackFiles, files_of
from amb_files.speed_units import require_speed_units
from amb_files.suggestions import suggest
from amb_files.toml import read_toml
from amb_files.wildcards import matches

PATHS = (
    "rotor",
    "receptances",
    "system",
)  # keys of a scenario that may hold a path; `fmu` holds one for each component
SPEEDS = ("Omega", "speed")  # keys of a scenario with speeds; `speed` holds an `Omega` for each point
OF_COMPONENTS = ("parameters", "inputs")
ENDS = frozenset(("end_cycle", "end_time"))  # keys that exclude each other


def packaged_scenarios() -> dict[str, Path]:
    """Return the packs' scenario files by name, without those that begin with `_`, which serve only as bases."""
    return {name: file for name, file in files_of("scenarios").items() if not name.startswith("_")}


def read_scenario(name: str, derived: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return the content of a scenario file, merged over its base, with paths relative to the working folder.

    Parameters
    ----------
    name
        Name of a scenario of a pack, or the path of a file.
    derived
        The files that use this one as their base.

    Raises
    ------
    ValueError
        If the file does not exist or cannot be read, or it removes entries that do not exist.
    """
    packaged = files_of("scenarios")
    source = packaged.get(name, Path(name))
    if source.is_symlink() and not source.exists():
        raise ValueError(f"scenario {name}: {source} is a link to a missing file")
    if not source.exists():
        if name.endswith(".toml"):
            beside = sorted(file.name for file in source.parent.glob("*.toml"))
            raise ValueError(f"no file {source.name!r} in {source.parent.resolve()}; {suggest(source.name, beside)}")
        raise ValueError(f"no scenario {name!r}; {suggest(name, packaged_scenarios())}")
    check_bases(f"scenario {name}", derived)
    data = read_toml(source, f"scenario {name}")
    with errors_in(f"scenario {name}"):
        require_speed_units({key: data.get(key) for key in SPEEDS}, ("Omega",))
        _check_tables_of_components(data)
    if "base" not in data and (rotor := default_of_pack("rotor", source)):
        data = {"rotor": rotor} | data
    data = with_paths(data, lambda path: str(source.parent / path), source)
    base, remove = data.pop("base", None), data.pop("remove", [])
    if not isinstance(remove, list) or not all(isinstance(entry, str) for entry in remove):
        raise ValueError(f"scenario {name}: remove = {remove!r} is not allowed; it must be a list of names")
    if base is None:
        if remove:
            raise ValueError(f"scenario {name}: 'remove' is only allowed in a scenario with a 'base'")
        return data
    if not isinstance(base, str):
        raise ValueError(f"scenario {name}: base = {base!r} is not allowed; it must be the name or path of a scenario")
    if file_of_pack := packaged.in_pack_of(source, base):
        base = str(file_of_pack)
    elif base not in packaged:
        file = source.parent / base
        if not (file.exists() or file.is_symlink()):
            hint = suggest(base, packaged_scenarios())
            raise ValueError(f"scenario {name}: base = {base!r} is not allowed; there is no file {file}; {hint}")
        base = str(file)
    below = read_scenario(base, (*derived, name))
    for entry in remove:
        with errors_in(f"scenario {name}"):
            below = _without(below, entry)
    return overlaid(below, data)


def _check_tables_of_components(data: dict[str, Any]) -> None:
    """Raise a ValueError unless parameters and inputs, which derived files may change, contain only tables."""
    for key in OF_COMPONENTS:
        if not isinstance(components := data.get(key, {}), dict):
            raise ValueError(f"{key} = {components!r} is not allowed; it must be a table")
        for component, values in components.items():
            if not isinstance(values, dict):
                raise ValueError(f"{key}.{component} = {values!r} is not allowed; it must be a table")


def with_paths(data: dict[str, Any], place: Callable[[str], str], source: Path | None = None) -> dict[str, Any]:
    """Return a scenario's data with `place` applied to every path; names from packs and models are unchanged.

    If several packs use a name, it becomes the path of its file in the pack that contains `source`, the file of the
    data.
    """

    def placed(key: str, value: Any) -> Any:
        if not isinstance(value, str):
            return value
        names = _packaged(key)
        if source is not None and isinstance(names, PackFiles) and (beside := names.in_pack_of(source, value)):
            return str(beside)
        return value if value in names else place(value)

    changed = {key: placed(key, data[key]) for key in PATHS if key in data}
    if isinstance(data.get("fmu"), dict):
        changed["fmu"] = {component: placed("fmu", fmu) for component, fmu in data["fmu"].items()}
    if isinstance(data.get("profile"), list):
        changed["profile"] = [
            table | {"file": place(file)}
            if isinstance(table, dict) and isinstance(file := table.get("file"), str) and file
            else table
            for table in data["profile"]
        ]
    return data | changed


def check_exists(key: str, value: object) -> None:
    """Raise a ValueError unless a value of a scenario is a packaged name or an existing file; objects always pass.

    Parameters
    ----------
    key, value
        A key of `PATHS`, or `fmu.` followed by a component, and the value of this key.
    """
    if isinstance(value, str) and not _is_packaged(key, value) and not Path(value).exists():
        names = _packaged(key)
        no_file = [f"there is no file {value}"] if Path(value).suffix or not names else []
        reason = "; ".join([*no_file, *([suggest(value, names)] if names else [])])
        raise ValueError(f"{key} = {value!r} is not allowed; {reason}")


def relative_to(folder: Path) -> Callable[[str], str]:
    """Return a function that turns a path relative to the working folder into one relative to `folder`."""
    return lambda path: path if Path(path).is_absolute() else os.path.relpath(path, folder)


def _is_packaged(key: str, name: str) -> bool:
    return name in _packaged(key)


def _packaged(key: str) -> Collection[str]:
    """Return the names that a key of a scenario accepts instead of a path."""
    if key == "rotor":
        return files_of("rotors")
    if key == "system":
        return packaged_systems()
    return models() if key.startswith("fmu") else ()


def _without(data: dict[str, Any], entry: str) -> dict[str, Any]:
    """Return a scenario's data without the entries that match `entry`; raises ValueError if there are none."""
    head, dot, rest = entry.partition(".")
    if not dot and head in data:
        return {key: value for key, value in data.items() if key != head}
    if isinstance(data.get(head), dict) and rest in data[head]:
        return data | {head: {key: value for key, value in data[head].items() if key != rest}}
    reduced, available = dict(data), [key for key in data if key not in ("description", "source")]
    for key in OF_COMPONENTS:
        values = data.get(key, {}).get(head, {})
        remaining = {name: raw for name, raw in values.items() if name != rest and not matches(name, rest)}
        available += [f"{head}.{name}" for name in values]
        if len(remaining) < len(values):
            reduced[key] = reduced[key] | {head: remaining}
    if reduced == data:
        raise ValueError(f"remove: the base has no {entry!r}; {suggest(entry, available)}")
    return reduced


def overlaid(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return the scenario data `below`, overridden by `above`: tables are merged, and everything else is replaced.

    If `above` states an end, in cycles or as a time, the end of `below` does not apply.
    """
    if ENDS & {*above}:
        below = {key: value for key, value in below.items() if key not in ENDS}
    return _merged(below, above)


def _merged(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    merged = dict(below)
    for key, value in above.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _merged(merged[key], value) if both else value
    return merged
