"""Saves rotors with ROSS 3.1, and the modes that it computes for them.

    python3.13 -m pip install "ross-rotordynamics>=3.1" "plotly<7"
    python3.13 tools/ross/ross31_rotors.py

rewrites the files in `ross31/`. ROSS 3 has coefficients over the spin `speed` or over the whirl `frequency`, and
magnetic bearings whose closed loop is a table over frequency. `matched` are eigenvalues (rad/s, [real, imaginary])
whose coefficients ROSS takes at the mode's own frequency; those `at_speed` have the coefficients at that spin speed.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import ross

FOLDER = Path(__file__).parents[2] / "tests" / "reference" / "ross31"
STEEL = ross.Material("steel", 7810.0, E=211e9, G_s=81.2e9)
SPEEDS = (0.0, 200.0, 400.0)  # rad/s


def rotor(bearings, name):
    shaft = [ross.ShaftElement(0.25, 0.0, 0.05, material=STEEL) for _ in range(6)]
    discs = [ross.DiskElement.from_geometry(n, STEEL, 0.07, 0.05, 0.28) for n in (2, 4)]
    return ross.Rotor(shaft, discs, bearings, tag=name)


def coefficients(n, **axis):
    k, c = [1e6, 2e6, 3e6, 4e6], [1000.0, 800.0, 600.0, 500.0]
    return ross.BearingElement(n, kxx=k, kyy=k, cxx=c, cyy=c, tag=f"bearing{n}", **axis)


INTEGRAL = {"i0": 2.5, "nw": 120, "kp_pid": 40000.0, "ki_pid": 2e5, "kd_pid": 70.0, "k_amp": 1.3, "k_sense": 0.9}
TABLE = np.linspace(20.0, 1500.0, 12)  # rad/s
FINE = np.geomspace(20.0, 1500.0, 60)  # damping by an integral part falls with the square of the frequency


def magnet(n, table=TABLE, **other):
    values = {"g0": 0.4e-3, "i0": 3.0, "ag": 1.5e-3, "nw": 100, "alpha": 0.392}
    values |= {"kp_pid": 60000.0, "kd_pid": 120.0, "n_f": 20000.0} | other
    return ross.MagneticBearingElement(n, **values, frequency=table.tolist(), tag=f"magnet{n}")


def main():
    FOLDER.mkdir(exist_ok=True)
    axis = np.array([0.0, 200.0, 400.0, 800.0])
    rotors = {
        "over_speed": rotor([coefficients(n, speed=axis) for n in (0, 6)], "over_speed"),
        "over_frequency": rotor([coefficients(n, frequency=axis) for n in (0, 6)], "over_frequency"),
        "magnets": rotor([magnet(n) for n in (0, 6)], "magnets"),
        "integral": rotor([magnet(0), magnet(6, FINE, **INTEGRAL)], "integral"),
    }
    results = {"ross": ross.__version__}
    for name, saved in rotors.items():
        saved.save(str(FOLDER / f"{name}.toml"))
        kind = "at_speed" if name == "over_speed" else "matched"
        modes = {}
        for speed in SPEEDS:
            modal = saved.run_modal(speed, num_modes=12, matched_whirl=kind == "matched")
            selected = [v for v in modal.evalues if 20.0 < v.imag < 900.0]
            modes[str(speed)] = [[v.real, v.imag] for v in sorted(selected, key=lambda v: v.imag)]
        results[name] = {kind: modes}
        if kind == "matched" and name != "over_frequency":
            results[name]["k_s"], results[name]["k_i"] = saved.bearing_elements[-1].ks, saved.bearing_elements[-1].ki
    (FOLDER / "results.json").write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
