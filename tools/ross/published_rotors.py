"""Computes the published rotors with ROSS, a rotor-dynamics program that shares no code with this project.

    python -m pip install "ross-rotordynamics>=2.3" "plotly<7"
    python tools/ross/published_rotors.py

rewrites the key `ross` of `published_rotors.json`; `-o FILE` writes to another file. Rotors are read from
`rotors/*.toml` without the project's reader. Speeds are in rev/min, eigenvalues and frequencies in rad/s, as
[real, imaginary]; all else is in SI units. Nodes count from 1.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import tomllib
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import ross

HERE = Path(__file__).parents[2] / "tests" / "reference"
STORED = HERE / "published_rotors.json"

SPEEDS = {  # rev/min
    "nelson_mcvaugh": (0, 30000, 100000),
    "nelson_mcvaugh_coupled": (0, 30000, 100000),
    "friswell_5_9_1": (0, 2000, 4000),
    "friswell_5_9_2": (0, 2000, 4000),
    "friswell_5_9_3": (0, 2000, 4000),
    "friswell_5_9_4": (0, 2000, 4000),
    "friswell_5_9_5": (0, 2000, 4000),
    "friswell_5_9_6": (1500,),  # the speed of the coefficients of its oil film
    "friswell_5_9_9": (0, 2000, 4000),
}
THEORIES = ("rayleigh", "timoshenko")
COUNT = 10  # eigenvalues of smallest size, one of each conjugate pair

UNBALANCES = ({"node": 3, "magnitude": 2e-3, "phase": 0.4}, {"node": 5, "magnitude": 1e-3, "phase": -1.9})
RESPONSES = {"friswell_5_9_5": (400, 830, 2500, 3100, 8000), "friswell_5_9_6": (1500,)}
OBSERVED = (1, 3, 5, 7)

OIL_FILM_SPEED = 1500 * np.pi / 30
OIL_FILM = {
    "weight": 525.0,
    "bearing_length": 0.03,
    "journal_diameter": 0.1,
    "radial_clearance": 1e-4,
    "oil_viscosity": 0.1,
}


def read(name: str) -> dict[str, Any]:
    """Return the content of a rotor file."""
    return tomllib.loads((HERE / "rotors" / f"{name}.toml").read_text(encoding="utf-8"))


def build(data: dict[str, Any], theory: str) -> Any:
    """Return the rotor in ROSS."""
    discs = [
        ross.DiskElement(b["node"] - 1, b["mass"], b["diametral_inertia"], b["polar_inertia"]) for b in data["bodies"]
    ]
    bearings = [
        ross.BearingElement(b["node"] - 1, **tensor("k", b["stiffness"]), **tensor("c", b.get("damping", 0)))
        for b in data["bearings"]
    ]
    return ross.Rotor(cylinders(data, theory), discs, bearings)


def cylinders(data: dict[str, Any], theory: str) -> list[Any]:
    """Return the shaft of the file."""
    shaft = data["shaft"]
    lengths = np.diff(shaft["nodes"])
    outer, inner = (np.broadcast_to(shaft.get(key, 0.0), lengths.shape) for key in ("diameter", "inner_diameter"))
    return [
        ross.ShaftElement(length, d_i, d_o, material=material(shaft), shear_effects=theory == "timoshenko")
        for length, d_i, d_o in zip(lengths, inner, outer, strict=True)
    ]


def material(shaft: dict[str, Any]) -> Any:
    return ross.Material("shaft", shaft["density"], E=shaft["youngs_modulus"], Poisson=shaft["poissons_ratio"])


def tensor(letter: str, value: Any) -> dict[str, float]:
    (xx, xy), (yx, yy) = value if isinstance(value, list) else ((value, 0.0), (0.0, value))
    return {f"{letter}xx": xx, f"{letter}xy": xy, f"{letter}yx": yx, f"{letter}yy": yy}


def eigenvalues(rotor: Any, speed: float) -> list[list[float]]:
    """Return the eigenvalues of bending modes; ROSS also has axial and torsional ones."""
    modal = rotor.run_modal(speed * np.pi / 30, sparse=False)
    motion = np.abs(modal.evectors[: rotor.ndof]) ** 2
    bending = np.isin(np.arange(rotor.ndof) % 6, (0, 1, 3, 4))
    values = modal.evalues[motion[bending].sum(axis=0) > 0.5 * motion.sum(axis=0)]
    values = values[values.imag >= 0.0]
    return pairs(values[np.argsort(np.abs(values), kind="stable")][:COUNT])


def unbalance_response(rotor: Any, speeds: tuple[float, ...]) -> dict[str, Any]:
    """Return complex x, y at the nodes `OBSERVED`: q(t) = Re[q exp(i theta)]."""
    places = [6 * (node - 1) + axis for node in OBSERVED for axis in (0, 1)]
    forced = rotor.run_unbalance_response(
        [u["node"] - 1 for u in UNBALANCES],
        [u["magnitude"] for u in UNBALANCES],
        [u["phase"] for u in UNBALANCES],
        frequency=np.array(speeds) * np.pi / 30,
    ).forced_resp
    return {str(speed): pairs(forced[places, k]) for k, speed in enumerate(speeds)}


def oil_film() -> dict[str, Any]:
    """Return the coefficients of the short bearing of example 5.9.6."""
    bearing = ross.CylindricalBearing(0, np.array([OIL_FILM_SPEED]), **OIL_FILM)
    K, C = (matrix(OIL_FILM_SPEED)[:2, :2].tolist() for matrix in (bearing.K, bearing.C))
    return {"stiffness": K, "damping": C}


def pairs(values: np.ndarray) -> list[list[float]]:
    """Return [real, imaginary] of each value, to ten digits of its magnitude."""
    decimals = [9 - math.floor(math.log10(abs(v))) for v in values]
    return [[round(v.real, n) + 0.0, round(v.imag, n) + 0.0] for v, n in zip(values.tolist(), decimals, strict=True)]


def compute() -> dict[str, Any]:
    rotors = {name: {theory: build(read(name), theory) for theory in THEORIES} for name in SPEEDS}
    return {
        "version": version("ross-rotordynamics"),
        "eigenvalues": {
            name: {
                theory: {str(speed): eigenvalues(rotors[name][theory], speed) for speed in speeds}
                for theory in THEORIES
            }
            for name, speeds in SPEEDS.items()
        },
        "unbalance_response": {
            "unbalances": UNBALANCES,
            "nodes": OBSERVED,
            "x_y": {
                name: {theory: unbalance_response(rotors[name][theory], speeds) for theory in THEORIES}
                for name, speeds in RESPONSES.items()
            },
        },
        "oil_film": oil_film(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=STORED, metavar="FILE")
    target = parser.parse_args().output
    numbers = json.loads(STORED.read_text(encoding="utf-8"))
    numbers["ross"] = compute()
    text = re.sub(r"\[\s+([^][{}]*?)\s+\]", lambda row: f"[{' '.join(row[1].split())}]", json.dumps(numbers, indent=1))
    target.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
