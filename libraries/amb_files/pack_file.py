"""What packs say of themselves in `pack.toml`, and what is taken where nothing is named."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Literal

from pydantic import StrictStr

from amb_files.packs import files_of, packs
from amb_files.suggestions import suggest
from amb_files.toml import read_toml, table, validate

Default = Literal["rotor", "scenario", "changing_speed"]


@table
class PackFile:
    """The file `pack.toml`.

    description
        One line about the pack.
    rotor, scenario, changing_speed
        What is taken where no rotor, no scenario, and no scenario of a changing speed is named. One pack may say each.
    live
        Scenarios that the live rig shows beside the one that is asked for, in order.
    """

    description: StrictStr = ""
    rotor: StrictStr | None = None
    scenario: StrictStr | None = None
    changing_speed: StrictStr | None = None
    live: tuple[StrictStr, ...] = ()


@cache
def pack_files() -> dict[str, PackFile]:
    """Return what the packs say of themselves, by name.

    Raises
    ------
    ValueError
        If a file cannot be read or does not have the form.
    """
    files = {name: folder / "pack.toml" for name, folder in packs().items()}
    return {
        name: validate(read_toml(file, what := f"{file.name} of pack {name}"), PackFile, what)
        for name, file in files.items()
        if file.is_file()
    }


def default(key: Default) -> str:
    """Return the name that a pack gives for what is not named.

    Raises
    ------
    ValueError
        If no pack, or more than one, gives a name.
    """
    values = {pack: name for pack, file in pack_files().items() if (name := getattr(file, key)) is not None}
    if len(values) != 1:
        which = f"packs {' and '.join(values)} both say" if values else "no pack says"
        raise ValueError(f"{which} which {key} is taken where none is named; one pack must")
    (name,) = values.values()
    return str(name)


def rotor_path(rotor: str | Path | None = None) -> Path:
    """Return the file of a rotor of a pack, or the path as it is.

    Parameters
    ----------
    rotor
        Name of a rotor, such as `compressor`, or a path; the default of the packs without.

    Raises
    ------
    ValueError
        If it is neither; the message suggests names. A path that ends in `.toml` is not looked at.
    """
    name = default("rotor") if rotor is None else rotor
    available, path = files_of("rotors"), Path(name)
    if str(name) in available:
        return available[str(name)]
    if path.suffix != ".toml" and not path.exists():
        raise ValueError(f"no rotor {str(name)!r}; {suggest(path.name, available)}")
    return path
