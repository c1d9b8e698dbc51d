"""Free modes and undamped critical speeds, as ROSS computes them.

    python -m pip install "ross-rotordynamics>=2.3" "plotly<7"
    python tools/ross/ross_critical_speeds.py

rewrites `ross/critical_speeds.json`. The rotors are those of `ross_rotors.py`, without their bearings. Frequencies and
speeds in rad/s, stiffness in N/m; nodes count from 1.

ROSS computes its map of critical speeds (`run_ucs`) for a rotor at rest; these come from its matrices M, G and K with
the whirl at the spin speed.
"""

from __future__ import annotations

import json
import re
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import ross
from ross.rotor_assembly import compressor_example
from ross_rotors import three_materials, two_discs
from scipy.linalg import eig, eigh

FILE = Path(__file__).parents[2] / "tests" / "reference" / "ross" / "critical_speeds.json"
ROTORS = {"two_discs": two_discs, "three_materials": three_materials, "compressor": compressor_example}
STIFFNESSES = (1e6, 2e7, 3e8)  # N/m, equal at both bearings
COUNT = 3  # critical speeds


def on_bearings(rotor: Any, **coefficients: Any) -> Any:
    """Return the same rotor on other bearings at the same nodes."""
    bearings = [ross.BearingElement(n, **coefficients) for n in places(rotor)]
    return ross.Rotor(rotor.shaft_elements, rotor.disk_elements, bearings)


def places(rotor: Any) -> list[int]:
    """Return the nodes of the first two bearings, from 0, without seals, which ROSS lists among bearings."""
    return [b.n for b in rotor.bearing_elements if type(b).__name__ == "BearingElement"][:2]


def bending(rotor: Any) -> tuple[Any, Any, Any]:
    """Return ROSS's M, G and K at rest over the translations and slopes of bending, without axial motion and twist."""
    rows = [6 * n + k for n in range(len(rotor.nodes)) for k in (0, 1, 3, 4)]
    at = np.ix_(rows, rows)
    return rotor.M(0.0)[at], rotor.G()[at], rotor.K(0.0)[at]


def bending_frequencies(rotor: Any) -> list[float]:
    """Return the natural frequencies of the free rotor at rest, one of each pair."""
    M, _, K = bending(on_bearings(rotor, kxx=0.0, cxx=0.0))
    squares = eigh(K, M, eigvals_only=True)
    return [float(np.sqrt(square)) for square in squares[4 : 4 + 2 * COUNT : 2]]


def critical_speeds(rotor: Any) -> list[float]:
    """Return the lowest forward critical speeds: K q = Omega^2 (M - i G) q, y = -i x."""
    M, G, K = bending(rotor)
    squares, shapes = eig(K.astype(complex), M - 1j * G)
    x, y = shapes[0::4], shapes[1::4]
    forward = (x * y.conj()).imag.sum(axis=0) > 0.0
    speeds = sorted(
        float(np.sqrt(s.real)) for s, is_forward in zip(squares, forward, strict=True) if is_forward and s.real > 0.0
    )
    return speeds[:COUNT]


def computed(rotor: Any) -> dict[str, Any]:
    return {
        "bearings": [n + 1 for n in places(rotor)],
        "bending": bending_frequencies(rotor),
        "critical_speeds": {f"{k:g}": critical_speeds(on_bearings(rotor, kxx=k, cxx=0.0)) for k in STIFFNESSES},
    }


def main() -> None:
    results: dict[str, Any] = {"version": version("ross-rotordynamics")}
    results |= {name: computed(make()) for name, make in ROTORS.items()}
    text = re.sub(r"\[\s+([^][{}]*?)\s+\]", lambda row: f"[{' '.join(row[1].split())}]", json.dumps(results, indent=1))
    FILE.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
