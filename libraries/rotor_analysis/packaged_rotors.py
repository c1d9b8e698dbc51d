"""Rotors by name: those of the installed packs, one of which is the default."""

from __future__ import annotations

from pathlib import Path

from amb_files.pack_file import path_of
from amb_files.packs import files_of


def packaged_rotors() -> dict[str, Path]:
    """Return the files of the packs' rotors, by name."""
    return files_of("rotors")


def rotor_path(rotor: str | Path | None = None) -> Path:
    """Return the file of a rotor of a pack, by default that which a pack says, or the path as it is; see `path_of`."""
    return path_of("rotor", rotor)
