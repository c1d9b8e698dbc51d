"""Packs: packages, found by their entry points, that contain the data of a machine or a publication.

A distribution that declares

    [project.entry-points."amb_cosim.packs"]
    my_pump = "my_pump"

adds the package `my_pump`. Its folders `rotors`, `systems`, `scenarios` and `sweeps` contain files of these kinds, to
which users refer by name. The optional file `pack.toml` has the form of `PackFile`. The optional modules `studies` and
`commands` add studies and commands.

An application is a package that builds on the orchestrator and is declared in the group `amb_cosim.applications`. It
adds studies and commands as packs do, and its module `listing` adds entries to `amb-cosim list`.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.metadata import Distribution, EntryPoint, distributions, entry_points
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType, ModuleType

from amb_files.atomic import is_special

GROUP = "amb_cosim.packs"
APPLICATIONS = "amb_cosim.applications"
SUFFIX = ".toml"
LONGEST = 200  # characters of a name or reason in a message
ENDLESS = "it is not a regular file"  # a pipe or a device


def endless_distributions() -> dict[str, str]:
    """Return the installed distributions whose `entry_points.txt` is not a regular file, each with a text that says so.

    Reading a pipe or a device may never end, and some libraries read the files of all distributions when they are
    imported.
    """
    endless = (each for each in distributions() if _is_endless(each, "entry_points.txt"))
    return dict.fromkeys(map(_name_of, endless), ENDLESS)


def _is_endless(distribution: Distribution, file: str) -> bool:
    folder = getattr(distribution, "_path", None)  # of one in a folder
    return isinstance(folder, Path) and is_special(folder / file)


def unreadable_distributions() -> dict[str, str]:
    """Return the installed distributions whose `entry_points.txt` cannot be read, each with the reason."""
    return {_name_of(each): reason for each in distributions() if (reason := _why_unreadable(each))}


def _why_unreadable(distribution: Distribution) -> str:
    """Return the reason why a distribution's `entry_points.txt` cannot be read, or an empty text if it can."""
    if _is_endless(distribution, "entry_points.txt"):
        return ENDLESS
    try:
        _ = distribution.entry_points
    except Exception as error:  # whatever the parser of the standard library raises
        reason = getattr(error, "strerror", None) or "a line has no value"
        return "it is not UTF-8" if isinstance(error, UnicodeDecodeError) else reason
    return ""


def _name_of(distribution: Distribution | None) -> str:
    """Return the name of a distribution, or the name of its folder if it has none."""
    named = None
    with suppress(Exception):  # whatever the standard library raises for a METADATA that cannot be read
        named = distribution and not _is_endless(distribution, "METADATA") and distribution.metadata["Name"]
    return named or Path(str(getattr(distribution, "_path", "distribution"))).name


def pack_of(file: Path) -> str:
    """Return the name of the pack whose folder, or an immediate subfolder of it, contains a file."""
    parents = file.parent, file.parents[1]
    return next((pack for pack, folder in packs().items() if folder in parents), file.parents[1].name)


def entry_points_of(group: str) -> list[EntryPoint]:
    """Return the sorted entry points of a group; distributions that cannot be read are skipped with a warning."""
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
    """Return the folders of the installed packs, by name; a pack without a package is skipped with a warning.

    If several packs have the same name, the package name is appended to the names of all but the first. A package that
    is declared under two names is one pack.
    """
    points: dict[Path, EntryPoint] = {}
    for point, folder in _folders(GROUP):
        points.setdefault(folder, point)
    result: dict[str, Path] = {}
    for folder, point in points.items():
        result[f"{point.name} ({point.value})" if point.name in result else point.name] = folder
    return result


@cache
def applications() -> dict[str, Path]:
    """Return the folders of the installed applications, by the full names of their packages."""
    return {point.value: folder for point, folder in _folders(APPLICATIONS)}


class PackFiles(Mapping[str, Path]):
    """TOML files in folders of packs, keyed by name without the suffix, in the order of the packs.

    A name that occurs in two packs is not listed, and using it raises ValueError. However, if a `general` package has a
    file with this name, the name refers to that file. Looking up a name does not list any folder, because some folders
    contain thousands of files.

    Parameters
    ----------
    kind
        Name of the folder in each pack, such as `rotors`.
    homes
        Folder of each pack, by the name of the pack.
    general
        Folders of other packages, by name, which are searched before the packs.
    """

    def __init__(
        self, kind: str, homes: Mapping[str, Path], general: Mapping[str, Path] = MappingProxyType({})
    ) -> None:
        self._kind, self._general = kind, general.keys()
        self._folders = {pack: folder / kind for pack, folder in {**general, **homes}.items()}

    def __getitem__(self, name: str) -> Path:
        owners = self._having(name)
        if not owners:
            raise KeyError(name)
        if self._is_ambiguous(owners):
            raise ValueError(self._clash(name, owners))
        return self._folders[owners[0]] / f"{name}{SUFFIX}"

    def __iter__(self) -> Iterator[str]:
        return (name for name, owners in self._owners().items() if not self._is_ambiguous(owners))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def in_pack_of(self, user: Path, name: str) -> Path | None:
        """Return the file of an ambiguous name in the pack of the file `user`, or None if that pack has no such file.

        A name is ambiguous if several packs use it; in a file of a pack, such a name refers to the file in that pack.
        """
        owners = self._having(name)
        folders = (self._folders[owner] for owner in owners if self._folders[owner].parent == user.parent.parent)
        folder = next(folders, None) if len(owners) > 1 else None
        return None if folder is None else folder / f"{name}{SUFFIX}"

    def clashes(self) -> list[str]:
        """Return a sentence about each name that is refused because several packs use it."""
        return [self._clash(name, owners) for name, owners in self._owners().items() if self._is_ambiguous(owners)]

    def _owners(self) -> dict[str, list[str]]:
        result: dict[str, list[str]] = {}
        for pack, folder in self._folders.items():
            for file in sorted(folder.glob(f"*{SUFFIX}")):
                result.setdefault(file.name.removesuffix(SUFFIX), []).append(pack)
        return result

    def _having(self, name: str) -> list[str]:
        """Return the packs that contain a file with this name."""
        file = f"{name}{SUFFIX}"
        is_name = Path(file).name == file
        return [pack for pack, folder in self._folders.items() if is_name and os.path.lexists(folder / file)]

    def _is_ambiguous(self, owners: Sequence[str]) -> bool:
        return len(owners) > 1 and owners[0] not in self._general

    def _clash(self, name: str, owners: Sequence[str]) -> str:
        return f"packs {' and '.join(owners)} have {self._kind}/{name}{SUFFIX}; only one pack may contain this name"


def files_of(kind: str, **general: Path) -> PackFiles:
    """Return the TOML files of the same kind in all packs.

    Parameters
    ----------
    kind
        Name of the folder in each pack, such as `rotors`.
    general
        Folders of other packages, by name, which are searched before the packs.
    """
    others = {pack: folder for pack, folder in packs().items() if folder not in general.values()}
    return PackFiles(kind, {f"{pack} (pack)" if pack in general else pack: others[pack] for pack in others}, general)


@cache
def modules_of(name: str, *needed: str) -> dict[str, ModuleType]:
    """Import the module `name` of each application and pack that has it; return the modules by application or pack.

    Applications come first. A module is skipped with a warning if it cannot be imported, or if it lacks one of the
    `needed` names because it has another purpose.
    """
    homes = {
        package: (f"application {_quoted(package)}", package, folder) for package, folder in applications().items()
    }
    homes |= {pack: (f"pack {_quoted(pack)}", folder.name, folder) for pack, folder in packs().items()}
    result: dict[str, ModuleType] = {}
    for home, (what, package, folder) in homes.items():
        if (folder / f"{name}.py").is_file() or (folder / name / "__init__.py").is_file():
            try:
                module = import_module(f"{package}.{name}")
                if missing := [each for each in needed if not hasattr(module, each)]:
                    raise ImportError(f"cannot import name {missing[0]!r}")
                result[home] = module
            except KeyboardInterrupt:
                raise
            except BaseException as error:  # whatever its code raises, such as SystemExit
                print(f"warning: {what} has no {name}, because the import fails: {reason(error)}", file=sys.stderr)
    return result


def reason(error: BaseException) -> str:
    """Return the type and the message of an error in third-party code, quoted and shortened."""
    try:
        text = f"{type(error).__name__}: {error}"
    except Exception:  # of its own method __str__
        text = type(error).__name__
    return _quoted(text)


def _quoted(text: str) -> str:
    """Return a text from an installed distribution, quoted and shortened for a message."""
    return repr(text if len(text) <= LONGEST else f"{text[:LONGEST]}...")


def _folders(group: str) -> Iterator[tuple[EntryPoint, Path]]:
    """Yield the entry points of a group, each with its package's folder; skip entry points without a package.

    One warning per distribution reports all skipped entry points and names the first of them.
    """
    kind = group.rpartition(".")[2].removesuffix("s")
    skipped: dict[int, list[EntryPoint]] = {}  # by distribution, whose name takes longer to read than all its points
    for point in entry_points_of(group):
        try:
            folder = _folder(point.value)
        except Exception:  # whatever the import of a parent package raises
            skipped.setdefault(id(point.dist), []).append(point)
        else:
            yield point, folder
    for first, *others in skipped.values():
        which = f"{_quoted(first.name)} is"
        if others:
            which = f"{_quoted(first.name)} and {len(others)} more of the installed {_name_of(first.dist)} are"
        print(f"warning: {kind} {which} skipped; there is no package {_quoted(first.value)}", file=sys.stderr)


def _folder(package: str) -> Path:
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ImportError(package)
    return Path(spec.submodule_search_locations[0])
