"""Packs: packages with the data of a machine or source, found by entry points.

A distribution that declares

    [project.entry-points."amb_cosim.packs"]
    my_pump = "my_pump"

adds the package `my_pump`. Its folders `rotors`, `systems`, `scenarios` and `sweeps` contain files of that kind, which
are used by their names. The optional file `pack.toml` has the form of `PackFile`; the modules `studies` and `commands`
add studies and commands.

An application is a package of code above the orchestrator, declared in the group `amb_cosim.applications`. It adds
studies and commands as packs do, and its module `listing` adds to what `amb-cosim list` lists.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, distributions, entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

GROUP = "amb_cosim.packs"
APPLICATIONS = "amb_cosim.applications"


def unreadable_distributions() -> dict[str, str]:
    """Return each installed distribution whose `entry_points.txt` cannot be read, with the reason.

    A distribution without a name is identified by its folder.
    """
    result = {}
    for distribution in distributions():
        try:
            _ = distribution.entry_points
        except Exception as error:  # whatever the parser of the standard library raises
            name = distribution.metadata["Name"] or Path(str(getattr(distribution, "_path", "distribution"))).name
            reason = getattr(error, "strerror", None) or "it has a line without a value"
            result[name] = "it is not UTF-8" if isinstance(error, UnicodeDecodeError) else reason
    return result


def pack_of(file: Path) -> str:
    """Return the name of the pack that has a file in its folder or directly in a subfolder."""
    parents = file.parent, file.parents[1]
    return next((pack for pack, folder in packs().items() if folder in parents), file.parents[1].name)


def entry_points_of(group: str) -> list[EntryPoint]:
    """Return the entry points of a group, sorted; distributions that cannot be read are skipped with a warning."""
    try:
        return sorted(entry_points(group=group))
    except Exception:  # one broken distribution of many
        _warn_of_unreadable()
    return sorted({point for points in _readable() for point in points if point.group == group})


@cache
def _warn_of_unreadable() -> None:
    for name, reason in unreadable_distributions().items():
        print(f"warning: entry_points.txt of the installed {name} cannot be read: {reason}", file=sys.stderr)


def _readable() -> Iterator[Iterable[EntryPoint]]:
    for distribution in distributions():
        with suppress(Exception):
            yield distribution.entry_points


@cache
def packs() -> dict[str, Path]:
    """Return the folders of the installed packs, by name; a pack without a package is skipped with a warning."""
    return {point.name: folder for point, folder in _folders(GROUP)}


@cache
def applications() -> dict[str, Path]:
    """Return the folders of the installed applications, by the full names of their packages."""
    return {point.value: folder for point, folder in _folders(APPLICATIONS)}


class PackFiles(dict[str, Path]):
    """Files of packs by name; a name that two packs have is not listed, and refused with ValueError when it is used.

    clashes
        The sentence about each name that two packs have.
    """

    def __init__(self, files: Mapping[str, Path], clashes: Mapping[str, str]) -> None:
        super().__init__(files)
        self.clashes = dict(clashes)

    def __contains__(self, name: object) -> bool:
        self._check(name)
        return super().__contains__(name)

    def __getitem__(self, name: str) -> Path:
        self._check(name)
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        """Return the file of a name, or the default without one."""
        self._check(name)
        return super().get(name, default)

    def _check(self, name: object) -> None:
        if name in self.clashes:
            raise ValueError(self.clashes[str(name)])


def files_of(kind: str, **general: Path) -> PackFiles:
    """Return the TOML files of the same kind in all packs, by their names without suffix, pack after pack.

    Parameters
    ----------
    kind
        Folder of the packs, such as `rotors`.
    general
        Folders of other packages to search like packs, by name.
    """
    result: dict[str, Path] = {}
    owners: dict[str, str] = {}
    clashes: dict[str, str] = {}
    for pack, folder in (general | packs()).items():
        for file in sorted((folder / kind).glob("*.toml")):
            other = owners.setdefault(file.stem, pack)
            if other != pack:
                rename = f"packs {other} and {pack} both have {kind}/{file.name}; one of them must rename it"
                clashes.setdefault(file.stem, rename)
            result[file.stem] = file
    return PackFiles({name: file for name, file in result.items() if name not in clashes}, clashes)


@cache
def modules_of(name: str, *needed: str) -> dict[str, ModuleType]:
    """Import the module `name` of each application and pack that has it; return the modules by application or pack.

    Applications come first. A module that cannot be imported, or lacks one of the `needed` names because it has another
    purpose, is skipped with a warning.
    """
    homes = {package: (f"application {package!r}", package, folder) for package, folder in applications().items()}
    homes |= {pack: (f"pack {pack!r}", folder.name, folder) for pack, folder in packs().items()}
    result: dict[str, ModuleType] = {}
    for home, (what, package, folder) in homes.items():
        if (folder / f"{name}.py").is_file() or (folder / name / "__init__.py").is_file():
            try:
                module = import_module(f"{package}.{name}")
                if missing := [each for each in needed if not hasattr(module, each)]:
                    raise ImportError(f"cannot import name {missing[0]!r}")
                result[home] = module
            except (Exception, SystemExit) as error:  # whatever its code raises
                why = f"{type(error).__name__}: {error}"
                print(f"warning: {what} has no {name}, because the import fails: {why!r}", file=sys.stderr)
    return result


def _folders(group: str) -> Iterator[tuple[EntryPoint, Path]]:
    """Yield the entry points of a group with the folders of their packages; one without a package is skipped."""
    kind = group.rpartition(".")[2].removesuffix("s")
    for point in entry_points_of(group):
        try:
            folder = _folder(point.value)
        except Exception:  # whatever the import of a parent package raises
            print(f"warning: {kind} {point.name!r} is skipped; there is no package {point.value!r}", file=sys.stderr)
        else:
            yield point, folder


def _folder(package: str) -> Path:
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ImportError(package)
    return Path(spec.submodule_search_locations[0])
