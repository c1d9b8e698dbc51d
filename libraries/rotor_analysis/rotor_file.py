"""Reads the description of a rotor from a TOML file; the files of packaged rotors can be copied as templates."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from amb_files.checks import errors_in
from amb_files.speed_units import require_speed_units, with_speed_units
from amb_files.toml import parse_toml, read_text, read_toml, validate
from rotor_analysis.checks import SPEED_KEYS
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.rotor import Mesh, Rotor
from rotor_analysis.shaft import ShaftOrSections

RotorSource = Rotor | Path | str | None
"""A `Rotor`, the name of a packaged rotor, the path of a rotor file, or None for the packs' default rotor."""

Tables = Mapping[str, Mapping[str, Any]]


def load_rotor(source: RotorSource = None, tables: Tables | None = None) -> Rotor:
    """Read a rotor description.

    Parameters
    ----------
    source
        The name of a packaged rotor, or a TOML file with the fields of `Rotor`; by default the packs' default rotor. If
        the file defines the shaft by sections, or has `[mesh]`, the elements are divided until the first modes have the
        required accuracy. A `Rotor` is returned unchanged.
    tables
        Values that replace values in the file's tables, such as `{"mesh": {"accuracy": 1e-3}}`.

    Raises
    ------
    ValueError
        If no such rotor exists, or its file cannot be read, lacks a key, or has an unknown key or a value out of range.
        The message has a line for each mistake.
    """
    if isinstance(source, Rotor):
        if not tables:
            return source
        data = with_speed_units(TypeAdapter(Rotor).dump_python(source, mode="json", exclude_none=True), SPEED_KEYS)
        return rotor_from(_merged(data, tables), f"rotor {source.name}")
    path = rotor_path(source)
    name = f"rotor file {path}"
    text = read_text(path, name)
    return rotor_from(_merged(parse_toml(text, name), tables), name) if tables else _rotor_of(text, name)


def _merged(data: dict[str, Any], tables: Tables) -> dict[str, Any]:
    return data | {table: {**data.get(table, {}), **values} for table, values in tables.items()}


def numbered_positions(source: RotorSource = None) -> tuple[float, ...]:
    """Return the positions (m) of nodes 1, 2, ..., to which `node` and `masters` in a valid rotor file refer.

    These are the nodes in the file, or the ends of its sections, without the nodes that `z` and `[mesh]` add. For a
    `Rotor`, they are the nodes of its shaft.
    """
    if isinstance(source, Rotor):
        return source.shaft.nodes
    path = rotor_path(source)
    name = f"rotor file {path}"
    return validate(read_toml(path, name)["shaft"], ShaftOrSections, name).nodes


@lru_cache(maxsize=8)
def _rotor_of(text: str, name: str) -> Rotor:
    """Return the rotor described by a text; the rotor is cached because refining a mesh may take a long time."""
    return rotor_from(parse_toml(text, name), name)


def rotor_from(data: dict[str, Any], name: str) -> Rotor:
    """Return the rotor described by the data of a file, with its mesh refined if requested."""
    with errors_in(name):
        require_speed_units(data, SPEED_KEYS)
    rotor = validate(data, Rotor, name)
    mesh = rotor.mesh or (Mesh() if "sections" in data["shaft"] else None)
    if mesh is None:
        return rotor
    from rotor_analysis.mesh_accuracy import refine_to_accuracy  # scipy, which is slow to import

    with errors_in(name):
        return refine_to_accuracy(rotor, mesh.modes, mesh.accuracy)
