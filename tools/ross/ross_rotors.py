"""Saves rotors with ROSS, and what ROSS computes for them: natural frequencies, damping, unbalance response.

    python -m pip install "ross-rotordynamics>=2.3" "plotly<7"
    python tools/ross/ross_rotors.py

rewrites the files in `ross/`; `-o FOLDER` writes to another folder. Speeds are in rad/s, eigenvalues in rad/s as
[real, imaginary], amplitudes in m; nodes count from 1, as in a rotor file. `compressor_example` and
`rotor_example_with_damping` are examples that come with ROSS; the others are made here.
"""

from __future__ import annotations

import argparse
import json
import re
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import ross
from published_rotors import eigenvalues, pairs
from ross.rotor_assembly import compressor_example, rotor_example_with_damping

FOLDER = Path(__file__).parents[2] / "tests" / "reference" / "ross"
STEEL = ross.Material("steel", 7810.0, E=211e9, G_s=81.2e9)
ALUMINIUM = ross.Material("aluminium", 2700.0, E=70e9, Poisson=0.33)
TITANIUM = ross.Material("Ti-6Al-4V", 4430.0, E=114e9, Poisson=0.34)


def two_discs() -> Any:
    """Return a uniform shaft with two discs in orthotropic bearings."""
    shaft = [ross.ShaftElement(0.25, 0.0, 0.05, material=STEEL) for _ in range(6)]
    discs = [
        ross.DiskElement.from_geometry(2, STEEL, 0.07, 0.05, 0.28),
        ross.DiskElement.from_geometry(4, STEEL, 0.07, 0.05, 0.35),
    ]
    bearings = [ross.BearingElement(n, kxx=1e6, kyy=8e5, cxx=2e2, cyy=1e2) for n in (0, 6)]
    return ross.Rotor(shaft, discs, bearings, tag="two_discs")


def cone() -> Any:
    """Return a hollow conical shaft, without shear, in cross-coupled bearings."""
    ends = np.linspace(0.08, 0.04, 11)
    bores = np.linspace(0.03, 0.01, 11)
    shaft = [
        ross.ShaftElement(0.1, i, o, i_end, o_end, material=STEEL, shear_effects=False)
        for (o, o_end), (i, i_end) in zip(pairwise(ends), pairwise(bores), strict=True)
    ]
    oil = {"kxx": 2e7, "kxy": 8e6, "kyx": -5e6, "kyy": 3e7, "cxx": 4e3, "cxy": -5e2, "cyx": 3e2, "cyy": 6e3}
    bearings = [ross.BearingElement(n, **oil) for n in (1, 9)]
    discs = [ross.DiskElement(5, 20.0, 0.15, 0.28, tag="impeller"), ross.DiskElement(10, 4.0, 0.01, 0.02, tag="fan")]
    return ross.Rotor(shaft, discs, bearings, tag="cone")


def three_materials() -> Any:
    """Return stepped, conical and hollow pieces of three materials, in bearings with three speeds."""
    pieces = [
        (0.10, 0.0, 0.05, 0.05, STEEL),
        (0.15, 0.02, 0.06, 0.09, TITANIUM),
        (0.20, 0.04, 0.09, 0.09, ALUMINIUM),
        (0.20, 0.04, 0.09, 0.09, ALUMINIUM),
        (0.15, 0.02, 0.09, 0.06, TITANIUM),
        (0.10, 0.0, 0.05, 0.05, STEEL),
    ]
    shaft = [ross.ShaftElement(L, bore, left, bore, right, material=m) for L, bore, left, right, m in pieces]
    over_speed = {
        "frequency": [0.0, 400.0, 1000.0],
        "kxx": [3e7, 2.5e7, 1.5e7],
        "kxy": [0.0, 2e6, 6e6],
        "kyx": [0.0, -2e6, -6e6],
        "cxx": [9e3, 6e3, 3e3],
    }
    bearings = [ross.BearingElement(n, **over_speed) for n in (1, 5)]
    return ross.Rotor(shaft, [ross.DiskElement(3, 15.0, 0.1, 0.18)], bearings, tag="three_materials")


def seals() -> Any:
    """Return two discs in bearings, a cross-coupled seal with mass over four speeds, and an unsymmetric seal."""
    shaft = [ross.ShaftElement(0.12, 0.0, 0.05, material=STEEL) for _ in range(10)]
    discs = [ross.DiskElement(n, 12.0, 0.06, 0.11) for n in (3, 7)]
    bearings = [ross.BearingElement(n, kxx=1.2e7, cxx=2e3) for n in (0, 10)]
    speeds = np.array([0.0, 300.0, 700.0, 1000.0])  # on a cubic: ROSS's spline, which smooths, changes nothing
    rising = {
        "frequency": speeds.tolist(),
        "kxx": (2e6 + 900.0 * speeds - 1e-3 * speeds**3).tolist(),
        "kxy": (3e3 * speeds + 0.5 * speeds**2).tolist(),
        "kyx": (-3e3 * speeds - 0.5 * speeds**2).tolist(),
        "cxx": (4e3 - 1.5 * speeds).tolist(),
        "cxy": (0.4 * speeds).tolist(),
        "cyx": (-0.4 * speeds).tolist(),
        "mxx": (3.0 - 1e-3 * speeds).tolist(),
    }
    unlike = {"kxx": 4e5, "kyy": -2e5, "kxy": 1e5, "kyx": 3e4, "cxx": 800.0, "cyy": 300.0, "mxx": 0.5, "myy": 1.5}
    seal_elements = [ross.SealElement(5, tag="balance piston", **rising), ross.SealElement(2, tag="eye", **unlike)]
    return ross.Rotor(shaft, discs, [*bearings, *seal_elements], tag="seals")


ROTORS = {
    "two_discs": (two_discs, (0.0, 200.0, 500.0)),
    "cone": (cone, (0.0, 300.0, 900.0)),
    "three_materials": (three_materials, (0.0, 150.0, 700.0)),
    "compressor": (compressor_example, (450.0, 800.0, 1100.0)),
    "seals": (seals, (0.0, 250.0, 640.0)),
    "damped": (rotor_example_with_damping, (0.0, 300.0, 900.0)),
}
UNBALANCE, PHASES = (2e-3, 1e-3), (0.4, -1.9)  # kg m and rad, at the first disc and at the last


def computed(rotor: Any, speeds: tuple[float, ...]) -> dict[str, Any]:
    """Return eigenvalues at each speed, and complex x, y of three nodes under the unbalances: Re[q exp(i theta)]."""
    loaded = [rotor.disk_elements[0].n, rotor.disk_elements[-1].n]
    turning = [speed for speed in speeds if speed]
    forced = rotor.run_unbalance_response(loaded, UNBALANCE, PHASES, frequency=np.array(turning)).forced_resp
    seen = [1, max(loaded) + 1, len(rotor.nodes)]
    places = [6 * (node - 1) + axis for node in seen for axis in (0, 1)]
    return {
        "mass": rotor.m,
        "eigenvalues": {f"{speed:g}": eigenvalues(rotor, speed * 30.0 / np.pi) for speed in speeds},
        "unbalances": [[n + 1, u, phase] for n, u, phase in zip(loaded, UNBALANCE, PHASES, strict=True)],
        "seen": seen,
        "x_y": {f"{speed:g}": pairs(forced[places, k]) for k, speed in enumerate(turning)},
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=FOLDER, metavar="FOLDER")
    folder = parser.parse_args().output
    folder.mkdir(exist_ok=True)
    results: dict[str, Any] = {"version": version("ross-rotordynamics")}
    for name, (make, speeds) in ROTORS.items():
        rotor, path = make(), folder / f"{name}.toml"
        path.unlink(missing_ok=True)
        rotor.save(path)
        results[name] = computed(rotor, speeds)
    text = re.sub(r"\[\s+([^][{}]*?)\s+\]", lambda row: f"[{' '.join(row[1].split())}]", json.dumps(results, indent=1))
    (folder / "results.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
