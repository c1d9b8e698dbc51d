"""Tables 3.1 to 3.4 of the thesis: damped natural frequencies by mesh and mass matrix, full against condensed."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from rotor_analysis.meshes import mesh_family
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import MassModel
from rotor_analysis.supported_rotor import SupportedRotor, supported_rotor

SPEEDS = (90.0, 120.0, 145.0)  # rad/s
MASSES: tuple[MassModel, ...] = ("consistent", "diagonal")
COUNT = 8


def frequency_tables(rotor: Rotor | None = None) -> dict[str, Any]:
    """Return the first eight damped natural frequencies (rad/s), ascending, at three speeds.

    Returns
    -------
    dict
        `table_3_1`: by mesh, mass matrix and speed. `table_3_4`: by speed, full and condensed to the master planes,
        diagonal mass; empty for a rotor without master planes.
    """
    rotor = rotor or load_rotor("bath_rig_thesis")
    nodes = len(rotor.shaft.nodes)
    full, planes = supported_rotor(rotor), rotor.masters
    condensed = supported_rotor(rotor, planes=planes) if planes else None
    return {
        "table_3_1": {
            f"{count}_node": {mass: _by_speed(supported_rotor(mesh, mass)) for mass in MASSES}
            for count, mesh in sorted(mesh_family(rotor).items(), reverse=True)
        },
        "table_3_4": {
            f"{speed:g}": {f"fem_{nodes}": _row(full, speed), "condensed": _row(condensed, speed)}
            for speed in SPEEDS
            if condensed
        },
    }


def thesis_frequencies() -> dict[str, Any]:
    """Return the frequencies of the thesis (rad/s) in `printed_frequencies.toml`, by model, mass matrix and speed."""
    text = (Path(__file__).parent / "printed_frequencies.toml").read_text(encoding="utf-8")
    return {name: rows for name, rows in tomllib.loads(text).items() if name != "source"}


def deviations(tables: dict[str, Any]) -> dict[str, Any]:
    """Return the deviations of `frequency_tables` of the rig from the numbers of the thesis (percent)."""
    computed = dict(tables["table_3_1"])
    computed["condensed"] = {"diagonal": {speed: row["condensed"] for speed, row in tables["table_3_4"].items()}}
    return {
        model: {
            mass: {
                speed: [
                    100.0 * (own / theirs - 1.0) for own, theirs in zip(computed[model][mass][speed], row, strict=True)
                ]
                for speed, row in rows.items()
            }
            for mass, rows in masses.items()
        }
        for model, masses in thesis_frequencies().items()
    }


def _by_speed(rotor_model: SupportedRotor) -> dict[str, list[float]]:
    return {f"{speed:g}": _row(rotor_model, speed) for speed in SPEEDS}


def _row(rotor_model: SupportedRotor, speed: float) -> list[float]:
    return [float(frequency) for frequency in damped_frequencies(rotor_model.model, speed, COUNT)]
