"""Machine files that describe a machine in another way: mirrored, with shorter elements, in other units."""

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

UNITS = {
    "rpm": (1.0 / 60.0, "Hz"),
    "us": (1e-3, "ms"),
    "mm": (1e3, "um"),
    "um": (1e-3, "mm"),
    "cm^2": (1e2, "mm^2"),
    "A": (1e3, "mA"),
    "V": (1e-3, "kV"),
    "Ohm": (1e3, "mOhm"),
    "mH": (1e3, "uH"),
    "kHz": (1e3, "Hz"),
    "Hz": (1e-3, "kHz"),
    "kW": (1e-3, "MW"),
    "m/s^2": (1e3, "mm/s^2"),
    "m/s2": (1e3, "mm/s2"),
    "N/m": (1e-6, "N/um"),
    "N.s/m": (1e-3, "N.s/mm"),
}
"""Factor and name of another unit of the same quantity."""
VALUE = re.compile(r'"(-?[\d.]+(?:e[+-]?\d+)?) ([A-Za-z][\w./^]*)"')


def toml_text(data: Mapping[str, Any]) -> str:
    """Return the TOML text of data, one line per key."""
    return "".join(f"{json.dumps(key)} = {_value(value)}\n" for key, value in data.items())


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_value(of)}" for key, of in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return json.dumps(value)


def mirrored(rotor: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a rotor file with cylindrical sections and its ends exchanged, z -> L - z.

    A mirror across the shaft changes neither x and y nor the sense of rotation, so the motion is the same.
    """
    length = sum(section["length"] for section in rotor["shaft"]["sections"])

    def turned(parts: list[dict[str, Any]]) -> list[dict[str, Any]]:
        return [part | {"z": length - part["z"]} for part in reversed(parts)]

    shaft = rotor["shaft"] | {"sections": rotor["shaft"]["sections"][::-1]}
    if "sleeves" in shaft:
        ends = [(length - of["end"], length - of["begin"]) for of in shaft["sleeves"]]
        shaft["sleeves"] = [of | {"begin": a, "end": b} for of, (a, b) in zip(shaft["sleeves"], ends, strict=True)]
    kinds = ("bodies", "bearings", "seals", "sites", "sensors")
    return rotor | {"shaft": shaft} | {kind: turned(rotor[kind]) for kind in kinds if kind in rotor}


def halved(rotor: dict[str, Any]) -> dict[str, Any]:
    """Return the data of a rotor file with each section as two of half the length, and a tenth of the mesh's error."""
    halves = [of | {"length": 0.5 * of["length"]} for of in rotor["shaft"]["sections"] for _ in range(2)]
    mesh = rotor.get("mesh", {}) | {"accuracy": 1e-5}
    return rotor | {"shaft": rotor["shaft"] | {"sections": halves}, "mesh": mesh}


def in_other_units(text: str) -> str:
    """Return the text of a TOML file with the values whose unit is in `UNITS` in another one."""

    def other(match: re.Match[str]) -> str:
        if match[2] not in UNITS:
            return match[0]
        factor, unit = UNITS[match[2]]
        return f'"{factor * float(match[1]):.15g} {unit}"'

    return VALUE.sub(other, text)


def read(path: Path) -> dict[str, Any]:
    """Return the data of a TOML file."""
    return tomllib.loads(path.read_text(encoding="utf-8"))
