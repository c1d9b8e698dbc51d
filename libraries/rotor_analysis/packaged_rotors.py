"""Rotors of the installed packs, by name."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from amb_files.pack_file import rotor_path
from amb_files.packs import files_of

__all__ = ["packaged_rotors", "rotor_path"]


def packaged_rotors() -> Mapping[str, Path]:
    """Return the files of the packs' rotors, by name."""
    return files_of("rotors")
