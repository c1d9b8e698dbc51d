"""Reads the description of a rotor from a TOML file; the rotors of the packs are files to copy."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

from amb_files.toml import parse_toml, read_text, validate
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.rotor import Mesh, Rotor


def load_rotor(source: str | Path | None = None) -> Rotor:
    """Read a rotor description.

    Parameters
    ----------
    source
        The name of a rotor of a pack, or a TOML file of the form of `Rotor`; the packs' default without. Where it gives
        the shaft by sections, or says `[mesh]`, the elements are divided until the first modes are as accurate as asked
        for.

    Raises
    ------
    ValueError
        If there is no such rotor, or its file cannot be read, has a missing or unknown key, or a value out of range;
        one line for each mistake.
    """
    path = rotor_path(source)
    name = f"rotor file {path}"
    return _rotor_of(read_text(path, name), name)


@lru_cache(maxsize=8)
def _rotor_of(text: str, name: str) -> Rotor:
    """The rotor that a text describes, kept for the next model of the same rotor: a mesh may take long to refine."""
    data = parse_toml(text, name)
    rotor = validate(data, Rotor, name)
    mesh = rotor.mesh or (Mesh() if "sections" in data["shaft"] else None)
    if mesh is None:
        return rotor
    from rotor_analysis.mesh_accuracy import refine_to_accuracy  # scipy, which is slow to import

    try:
        return refine_to_accuracy(rotor, mesh.modes, mesh.accuracy)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error
