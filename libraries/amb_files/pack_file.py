"""The files `pack.toml` of packs: descriptions and defaults."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path
from typing import Literal

from pydantic import StrictStr

from amb_files.checks import as_path
from amb_files.packs import files_of, packs
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, table, validate

NAME = "pack.toml"
Default = Literal["rotor", "scenario", "changing_speed"]


@table
class PackFile:
    """The file `pack.toml`.

    description
        A line about the pack.
    rotor, scenario, changing_speed
        Defaults for the rotor, the scenario, and the scenario with a changing speed. Scenarios of a pack use the
        default rotor of their pack. Elsewhere, a default is used only if exactly one pack defines it.
    live
        Scenarios that the live rig offers after the requested one, in this order.
    """

    description: StrictStr = ""
    rotor: StrictStr | None = None
    scenario: StrictStr | None = None
    changing_speed: StrictStr | None = None
    live: tuple[StrictStr, ...] = ()


@cache
def pack_files() -> dict[str, PackFile]:
    """Return the pack files, by name of the pack; an invalid file is skipped with a warning."""
    result = {}
    for pack, folder in packs().items():
        file, what = folder / NAME, f"{NAME} of pack {pack}"
        if file.exists() or file.is_symlink():
            try:
                result[pack] = validate(read_toml(file, what), PackFile, what)
            except ValueError as error:
                for line in str(error).splitlines():
                    print(f"warning: {line}", file=sys.stderr)
    return result


def default(key: Default) -> str:
    """Return the default that is defined by exactly one pack.

    Raises
    ------
    ValueError
        If no pack defines the default, or more than one pack does.
    """
    values = {pack: name for pack, file in pack_files().items() if (name := getattr(file, key)) is not None}
    if len(values) != 1:
        which = f"packs {' and '.join(values)} define" if values else "no pack defines"
        raise ValueError(f"{which} a default {key}; name one explicitly")
    (name,) = values.values()
    return str(name)


def default_of_pack(key: Default, file: Path) -> str | None:
    """Return the default of the pack that contains a file, or None if there is no such pack or no such default."""
    pack = next((pack for pack, folder in packs().items() if folder == file.parent.parent), None)
    return getattr(pack_files().get(pack or ""), key, None)


def rotor_path(rotor: str | Path | None = None) -> Path:
    """Return the file of a packaged rotor; if `rotor` is a path, return it unchanged.

    Parameters
    ----------
    rotor
        Name of a rotor, such as `compressor`, or a path. If it is None, the default rotor of the packs is used.

    Raises
    ------
    ValueError
        If `rotor` is neither a known name nor an existing path; the message suggests names. A path that ends in `.toml`
        is not checked.
    """
    name = default("rotor") if rotor is None else rotor
    rotors, path = files_of("rotors"), as_path("rotor", name)
    if str(name) in rotors:
        return rotors[str(name)]
    if path.suffix != ".toml" and not path.exists():
        raise ValueError(f"no rotor {str(name)!r}; {suggest(path.name, rotors)}")
    return path
