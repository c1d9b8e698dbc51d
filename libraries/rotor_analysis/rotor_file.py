"""Reads the description of a rotor from a TOML file; `rig.toml` is one to copy."""

from __future__ import annotations

from pathlib import Path

from amb_files.toml import read_toml, validate
from rotor_analysis.rotor import Rotor

RIG = Path(__file__).parent / "rig.toml"


def load_rotor(path: Path = RIG) -> Rotor:
    """Read a rotor description.

    Parameters
    ----------
    path
        TOML file with `name` and `[shaft]`, and optionally `[[bodies]]`, `[[bearings]]` and `[planes]`; the rig of the
        thesis by default.

    Raises
    ------
    ValueError
        If the file cannot be read, has a missing or unknown key, or a value out of range; one line for each mistake.
    """
    name = f"rotor file {path}"
    return validate(read_toml(path, name), Rotor, name)
