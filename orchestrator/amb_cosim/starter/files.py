"""The files of a new machine: a folder of texts with the sizes filled in, which appears whole or not at all."""

from __future__ import annotations

import math
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from string import Template

from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.values import RPM
from amb_cosim.starter.levitation import Gains, OperatingPoint, best_gains, candidates, operating_points
from amb_cosim.starter.sizing import SAMPLE_TIME, SHAFT_SHARE, STEEL, MachineSizes
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.rotor_file import load_rotor

TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class NewMachine:
    """What was written: the folder, the sizes, the operating points of the bearings, and the gains that levitate it."""

    folder: Path
    sizes: MachineSizes
    points: tuple[OperatingPoint, OperatingPoint]
    gains: Gains


def new_machine(folder: Path, sizes: MachineSizes, flavour: Flavour = "native") -> NewMachine:
    """Write rotor, scenarios, machine file and a page about them into a new folder, with gains that levitate it.

    Parameters
    ----------
    folder
        Where; its name is that of the machine.
    sizes
        Of `machine_sizes`.
    flavour
        Flavour of the FMUs that are asked for their linear model.

    Raises
    ------
    ValueError
        If the folder exists, its name is none for a rotor, or no gains levitate the rotor.
    """
    if folder.exists():
        raise ValueError(f"{folder} exists; a new machine needs a new folder")
    points = operating_points(sizes)
    with tempfile.TemporaryDirectory() as place:
        draft = Path(place) / folder.name
        draft.mkdir()
        k_b, c_b = candidates(sizes)[0]
        _fill(draft, _values(folder.name, sizes, points, Gains(k_b, c_b, 0.0, 0.0)) | {"first_bending": "0"})
        gains = best_gains(draft / "levitation.toml", sizes, flavour)
        bending = {"first_bending": f"{_first_bending(draft / 'rotor.toml'):.0f}"}
        _fill(draft, _values(folder.name, sizes, points, gains) | bending)
        folder.parent.mkdir(parents=True, exist_ok=True)
        shutil.move(draft, folder)
    return NewMachine(folder, sizes, points, gains)


def _fill(folder: Path, values: dict[str, str]) -> None:
    for template in sorted(TEMPLATES.iterdir()):
        text = Template(template.read_text(encoding="utf-8")).substitute(values)
        (folder / template.name).write_text(text, encoding="utf-8")


def _first_bending(file: Path) -> float:
    """First bending frequency of the free rotor (Hz)."""
    full = assemble(load_rotor(file))
    return float(free_modes(full.M[::2, ::2], full.K[::2, ::2])[0][0] / (2.0 * math.pi))


def _values(
    name: str, sizes: MachineSizes, points: tuple[OperatingPoint, OperatingPoint], gains: Gains
) -> dict[str, str]:
    """The texts that the templates ask for."""
    r = 0.5 * sizes.diameter
    race_mass = 0.01 * sizes.mass
    per_side = {
        f"{what}_{side}": f"{value:.4g}"
        for what, pair in {
            "bearing": sizes.bearings,
            "sensor": sizes.sensors,
            "retainer": sizes.retainers,
            "load": sizes.load,
            "static": [point.static_current for point in points],
            "k_s": [point.k_s for point in points],
            "k_i": [point.k_i for point in points],
        }.items()
        for side, value in zip(("left", "right"), pair, strict=True)
    }
    numbers = {
        "mass": sizes.mass,
        "length": float(sizes.length),
        "rpm": sizes.speed * RPM,
        "slow_rpm": 0.05 * sizes.speed * RPM,
        "least_rpm": 0.8 * sizes.speed * RPM,
        "shaft_share": SHAFT_SHARE,
        "diameter": sizes.diameter,
        "density": STEEL,
        "wheel": sizes.wheel,
        "wheel_mass": sizes.wheel_mass,
        "wheel_radius": sizes.wheel_radius,
        "wheel_width": sizes.wheel_width,
        "k_b": gains.k_b,
        "c_b": gains.c_b,
        "cross_coupling": 0.01 * gains.k_b,
        "in_range": gains.in_range,
        "beyond": gains.beyond,
        "clearance": sizes.clearance,
        "clearance_mm": 1e3 * sizes.clearance,
        "sample_time": 1e6 * SAMPLE_TIME,
        "turns": sizes.turns,
        "pole_area": 1e4 * sizes.pole_area,
        "gap": 1e3 * sizes.gap,
        "bias_current": sizes.bias_current,
        "current_limit": sizes.current_limit,
        "resistance": sizes.resistance,
        "inductance": 1e3 * sizes.inductance,
        "voltage_limit": sizes.voltage_limit,
        "unbalance": 1e6 * sizes.unbalance,
        "drive_gain": 1e-3 * sizes.mass * sizes.diameter,
        "drive_torque": 0.1 * sizes.mass * sizes.diameter,
        "race_inertia": race_mass * r**2,
        "race_drag": 0.0015 * 0.5 * sizes.mass * 9.81 * r,
    }
    return {"name": name} | {key: f"{value:.5g}" for key, value in numbers.items()} | per_side
