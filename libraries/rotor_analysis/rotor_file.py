"""Reads the description of a rotor from a TOML file; `rig.toml` is one to copy."""

from __future__ import annotations

from pathlib import Path

from amb_files.toml import read_toml, validate
from rotor_analysis.rotor import Mesh, Rotor

RIG = Path(__file__).parent / "rig.toml"


def load_rotor(path: Path = RIG) -> Rotor:
    """Read a rotor description.

    Parameters
    ----------
    path
        TOML file of the form of `Rotor`; the rig of the thesis by default. Where it gives the shaft by sections, or
        says `[mesh]`, the elements are divided until the first modes are as accurate as asked for.

    Raises
    ------
    ValueError
        If the file cannot be read, has a missing or unknown key, or a value out of range; one line for each mistake.
    """
    name = f"rotor file {path}"
    data = read_toml(path, name)
    rotor = validate(data, Rotor, name)
    mesh = rotor.mesh or (Mesh() if "sections" in data["shaft"] else None)
    if mesh is None:
        return rotor
    from rotor_analysis.mesh_accuracy import refine_to_accuracy  # scipy, which is slow to import

    try:
        return refine_to_accuracy(rotor, mesh.modes, mesh.accuracy)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error
