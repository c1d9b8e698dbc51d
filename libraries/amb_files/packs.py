"""Packs: packages with what belongs to one machine or one source, found by entry points.

A distribution that declares

    [project.entry-points."amb_cosim.packs"]
    my_pump = "my_pump"

adds the package `my_pump`. Its folders hold files of one kind, each named as what it describes: `rotors`, `systems`,
`scenarios`, `sweeps`. Its file `pack.toml`, if there is one, has the form of `PackFile`; what it computes by itself
is in modules whose names say what they are for: `studies`, `commands`.
"""

from __future__ import annotations

import sys
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

GROUP = "amb_cosim.packs"


@cache
def packs() -> dict[str, Path]:
    """Return the folders of the installed packs, by name; a pack without a package is left out with a warning."""
    folders: dict[str, Path] = {}
    for point in sorted(entry_points(group=GROUP)):
        try:
            folders[point.name] = _folder(point.value)
        except Exception:  # whatever the import of a parent package raises
            print(f"warning: pack {point.name!r} is left out; there is no package {point.value!r}", file=sys.stderr)
    return folders


def files_of(kind: str, **own: Path) -> dict[str, Path]:
    """Return the TOML files of one kind in all packs, by their names without suffix, pack after pack.

    Parameters
    ----------
    kind
        Folder of the packs, such as `rotors`.
    own
        Folders of other packages that are searched as if they were packs, by name.

    Raises
    ------
    ValueError
        If two packs have files of the same name.
    """
    result: dict[str, Path] = {}
    owners: dict[str, str] = {}
    for pack, folder in (own | packs()).items():
        for file in sorted((folder / kind).glob("*.toml")):
            other = owners.setdefault(file.stem, pack)
            if other != pack:
                raise ValueError(f"packs {other} and {pack} both have {kind}/{file.name}; one of them must rename it")
            result[file.stem] = file
    return result


@cache
def modules_of(name: str) -> dict[str, ModuleType]:
    """Return the module of that name of each pack that has one, imported, by pack.

    One that cannot be imported is left out with a warning.
    """
    result: dict[str, ModuleType] = {}
    for pack, folder in packs().items():
        if (folder / f"{name}.py").is_file() or (folder / name / "__init__.py").is_file():
            try:
                result[pack] = import_module(f"{folder.name}.{name}")
            except (Exception, SystemExit) as error:  # whatever its code raises
                why = f"{type(error).__name__}: {error}"
                print(f"warning: pack {pack!r} is without its {name}, which fail on import: {why!r}", file=sys.stderr)
    return result


def _folder(package: str) -> Path:
    spec = find_spec(package)
    if spec is None or not spec.submodule_search_locations:
        raise ImportError(package)
    return Path(spec.submodule_search_locations[0])
