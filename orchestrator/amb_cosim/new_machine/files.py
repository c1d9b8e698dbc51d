"""The files of a new machine: a folder of texts with the sizes filled in, which appears whole or not at all."""

from __future__ import annotations

import math
import shutil
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path
from string import Template

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.system.values import RPM
from amb_cosim.new_machine.levitation import Gains, OperatingPoint, best_gains, candidates, operating_points
from amb_cosim.new_machine.rotor_text import damping, require_name, supports
from amb_cosim.new_machine.sizing import SAMPLE_TIME, MachineSizes, machine_sizes
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor

TEMPLATES = Path(__file__).parent / "templates"


@dataclass(frozen=True)
class NewMachine:
    """What was written: the folder, the sizes, the operating points by bearing, and the gains that levitate it.

    assumed
        Parts of the rotor file that it did not have: `bearings`, with retainers and sensors, and `damping`.
    """

    folder: Path
    assumed: tuple[str, ...]
    sizes: MachineSizes
    points: dict[str, OperatingPoint]
    gains: Gains


def new_machine(
    folder: Path, rotor: str, speed: float, bearings: tuple[float, float] | None = None, flavour: Flavour = "native"
) -> NewMachine:
    """Write rotor, scenarios, machine file and a page about them into a new folder, with gains that levitate it.

    Parameters
    ----------
    folder
        Where; its name is that of the machine.
    rotor
        Text of a rotor file: of `plain_shaft`, or of a drawing. Damping is assumed where it has no `[damping]`.
    speed
        Its highest speed in operation (rad/s).
    bearings
        Positions of two magnetic bearings (m), where the rotor file has none; `supports` places them without.
    flavour
        Flavour of the FMUs that are asked for their linear model.

    Raises
    ------
    ValueError
        If the folder exists, its name cannot stand in a TOML file, the rotor file is not valid, it has bearings and
        positions are given, it lacks what `machine_sizes` needs, or no gains levitate the rotor.
    """
    require_name(folder.name)
    if folder.exists():
        raise ValueError(f"{folder} exists; a new machine needs a new folder")
    with tempfile.TemporaryDirectory() as place:
        draft = Path(place) / folder.name
        draft.mkdir()
        file = draft / "rotor.toml"
        has_damping = "damping" in tomllib.loads(rotor)
        rotor = rotor if has_damping else rotor + damping()
        bare = _rotor_of(file, rotor)
        if bare.bearings and bearings:
            present = ", ".join(f"{b.name} at {bare.shaft.nodes[b.node - 1]:g} m" for b in bare.bearings)
            raise ValueError(f"bearings are given, but the rotor file has its own: {present}; leave one of the two out")
        if not bare.bearings:
            _rotor_of(file, rotor + supports(bare, bearings))
        sizes = machine_sizes(load_rotor(file), speed)
        points = operating_points(sizes)
        _fill(draft, _values(folder.name, sizes, points, Gains(*candidates(sizes)[0], 0.0, 0.0)))
        gains = best_gains(draft / "levitation.toml", sizes, flavour)
        if not bare.bearings:
            _rotor_of(file, rotor + supports(bare, bearings, gains.k_b, gains.c_b))
        _fill(draft, _values(folder.name, sizes, points, gains))
        folder.parent.mkdir(parents=True, exist_ok=True)
        shutil.move(draft, folder)
    assumed = {"bearings": not bare.bearings, "damping": not has_damping}
    return NewMachine(folder, tuple(part for part, is_so in assumed.items() if is_so), sizes, points, gains)


def _rotor_of(file: Path, text: str) -> Rotor:
    """Write a rotor file, and return its rotor."""
    file.write_text(text, encoding="utf-8")
    return load_rotor(file)


def _fill(folder: Path, values: dict[str, str]) -> None:
    for template in sorted(TEMPLATES.iterdir()):
        text = Template(template.read_text(encoding="utf-8")).substitute(values)
        (folder / template.name).write_text(text, encoding="utf-8")


def _first_bending(rotor: Rotor) -> float:
    """First bending frequency of the free rotor (Hz)."""
    full = assemble(rotor)
    return float(free_modes(full.M[::2, ::2], full.K[::2, ::2])[0][0] / (2.0 * math.pi))


def _values(name: str, sizes: MachineSizes, points: dict[str, OperatingPoint], gains: Gains) -> dict[str, str]:
    """The texts that the templates ask for."""
    r = 0.5 * sizes.diameter
    race_inertia, race_drag = 0.01 * sizes.mass * r**2, 0.0015 * 0.5 * sizes.mass * 9.81 * r
    races = [
        f'"{site.name}.race_inertia" = "{race_inertia:.5g} kg.m2"\n"{site.name}.race_drag" = "{race_drag:.5g} N.m"'
        for site in sizes.retainers
    ]
    rows = [
        f"| {bearing} | {sizes.loads[bearing]:.4g} N | {p.static_current:.4g} A | {p.k_s:.4g} N/m | {p.k_i:.4g} N/A |"
        for bearing, p in points.items()
    ]
    texts = {
        "name": name,
        "plane": sizes.plane.name,
        "sensor": sizes.rotor.sensors[0].x,
        "races": "\n".join(races),
        "bearing_rows": "\n".join(rows),
        "first_bending": f"{_first_bending(sizes.rotor):.0f}",
    }
    numbers = {
        "mass": sizes.mass,
        "rpm": sizes.speed * RPM,
        "slow_rpm": 0.05 * sizes.speed * RPM,
        "least_rpm": 0.8 * sizes.speed * RPM,
        "k_b": gains.k_b,
        "c_b": gains.c_b,
        "cross_coupling": 0.01 * gains.k_b,
        "in_range": gains.in_range,
        "beyond": gains.beyond,
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
    }
    return texts | {key: f"{value:.5g}" for key, value in numbers.items()}
