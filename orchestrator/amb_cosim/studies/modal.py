"""Modes of a rotor at some speeds, as data and as text; what the analysing commands read their input with."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from rich.table import Table

from amb_cosim.cosim.values import quantity
from rotor_analysis.assembly import MassModel, Matrices
from rotor_analysis.modes import modes, overdamped
from rotor_analysis.rotor import Rotor, require
from rotor_analysis.rotor_file import RIG, load_rotor
from rotor_analysis.supported import supported

ROUNDING = 1e-9  # a damping ratio above minus this is that of an undamped mode, not of a growing one


def read_rotor(path: Path | None) -> Rotor:
    """The rotor in the file, or the rig of the thesis."""
    return load_rotor(path or RIG)


def speed(text: str, name: str = "speed") -> float:
    """A spin speed (rad/s) from `90`, `90 rad/s` or `16 Hz`."""
    value = quantity(text, "rad/s", name)
    require(0.0 <= value < float("inf"), name, f"{value:g} rad/s", ">= 0 rad/s and finite")
    return value


def speed_list(text: str) -> list[float]:
    """Spin speeds (rad/s) from a list with commas."""
    return [speed(part, "speeds") for part in text.split(",")]


def node_list(text: str, name: str) -> tuple[int, ...]:
    """Node numbers from a list with commas."""
    parts = [part.strip() for part in text.split(",")]
    require(all(part.isdecimal() for part in parts), name, text, "node numbers with commas between them")
    return tuple(int(part) for part in parts)


def modes_at(rotor: Rotor, mass: MassModel, speeds: list[float], count: int) -> dict[str, Any]:
    """Lowest modes of the full model at each speed, ready for JSON."""
    model = supported(rotor, mass).model
    return {
        "rotor": rotor.name,
        "mass": mass,
        "speeds": {f"{Omega:g}": _lists(model, Omega, count) for Omega in speeds},
    }


def as_text(data: dict[str, Any]) -> list[Table | str]:
    """What `modes_at` returned, to print."""
    title = f"{data['rotor']}, {data['mass']} mass; speed in rad/s"
    table = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
    for heading in ("speed", "mode", "frequency (rad/s)", "(Hz)", "damping ratio"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("whirl", no_wrap=True)
    remarks: list[Table | str] = []
    for Omega, found in data["speeds"].items():
        rows = zip(found["frequencies_rad_s"], found["damping_ratios"], found["whirl"], strict=True)
        for k, (frequency, ratio, whirl) in enumerate(rows, start=1):
            hertz = f"{frequency / (2.0 * math.pi):.3f}"
            unstable = ", unstable" if ratio < -ROUNDING else ""
            table.add_row(Omega, str(k), f"{frequency:.3f}", hertz, f"{round(ratio, 4) + 0.0:.4f}", whirl + unstable)
        real = ", ".join(f"{value:.4g}" for value in found["real_eigenvalues_per_s"])
        if real:
            remarks.append(f"at {Omega} rad/s also motion that does not oscillate, exp(s t) with s = {real} 1/s")
    return [table, *remarks]


def _lists(model: Matrices, Omega: float, count: int) -> dict[str, list[Any]]:
    found = modes(model, Omega, count)
    return {
        "frequencies_rad_s": [mode.frequency for mode in found],
        "damping_ratios": [mode.damping_ratio for mode in found],
        "whirl": [mode.whirl for mode in found],
        "real_eigenvalues_per_s": [mode.eigenvalue.real for mode in overdamped(model, Omega)],
    }
