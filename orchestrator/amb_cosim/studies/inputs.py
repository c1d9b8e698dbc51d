"""How studies read their arguments: numbers in SI units, or texts with a unit."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path

import numpy as np

from amb_cosim.cosim.system.values import quantity
from amb_cosim.results.places import CONTROLLER
from amb_cosim.scenario.scenario import Scenario, given_scenario
from fmi_export.model import Array
from rotor_analysis.checks import require
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor

LEAST, MOST = 1e-12, 1e12  # of a positive number, in any unit
HIGHEST = 1e5  # rad/s; dentists' drills turn at a third of it

Number = float | str
"""A number in the unit that is asked for, or a text with another unit of the same dimension (`"16 Hz"`)."""

RotorFile = Path | str | None
"""Name of a rotor of a pack, path of a rotor file, or None for the packs' default."""

RotorSource = Rotor | Path | str | None
"""A rotor, the name of one of a pack, the path of a rotor file, or None for the packs' default."""


def rotor_of(source: RotorSource) -> Rotor:
    """Return a rotor.

    Raises
    ------
    ValueError
        If there is no such rotor, or a file cannot be read or holds none.
    """
    return source if isinstance(source, Rotor) else load_rotor(source)


def controlled(
    scenario: str | Path | Scenario | None, rotor: RotorFile, controller: str | PathLike[str] | None
) -> Scenario:
    """Return the scenario of a study of a machine under control.

    Parameters
    ----------
    scenario
        A `Scenario`, the name of one of a pack, or a TOML file; the packs' default without.
    rotor
        Name of a rotor of a pack, or rotor file, in place of the scenario's.
    controller
        Controller file, object or FMU in place of the scenario's controller.
    """
    values = given_scenario(scenario, rotor)
    return values if controller is None else values.changed(fmu={CONTROLLER: fspath(controller)})


def spin_speed(raw: Number, name: str = "speed") -> float:
    """Return a spin speed (rad/s) given as 90, `"90 rad/s"` or `"16 Hz"`.

    Raises
    ------
    ValueError
        If it is no speed, negative or beyond `HIGHEST`.
    """
    value = quantity(raw, "rad/s", name)
    require(0.0 <= value <= HIGHEST, name, f"{value:g} rad/s", f">= 0 rad/s and <= {HIGHEST:g} rad/s")
    return value


def spin_speeds(raw: Number | Sequence[Number]) -> list[float]:
    """Return spin speeds (rad/s): one, those of a sequence, or of a text with commas."""
    if isinstance(raw, int | float):
        return [spin_speed(raw, "speeds")]
    return [spin_speed(part, "speeds") for part in (raw.split(",") if isinstance(raw, str) else raw)]


def speed_range(up_to: Number, points: int, lowest: float = 0.0) -> Array:
    """Return evenly spaced spin speeds (rad/s) from the lowest to `up_to`, shape (points,).

    Raises
    ------
    ValueError
        If `up_to` is no speed above the lowest.
    """
    highest = spin_speed(up_to, "up-to")
    require(highest > lowest, "up-to", f"{highest:g} rad/s", f"> {lowest:.4g} rad/s")
    return np.linspace(lowest, highest, points)


def positive(raw: Number, unit: str, name: str, reason: str = "") -> float:
    """Return a positive, finite number in a unit.

    Raises
    ------
    ValueError
        If it is none, or not from `LEAST` to `MOST`; the message ends with the reason.
    """
    value, displayed = quantity(raw, unit, name), unit.replace(".", " ")
    require(0.0 < value < float("inf"), name, f"{value:g} {displayed}", f"> 0 {displayed}{reason}")
    require(
        LEAST <= value <= MOST, name, f"{value:g} {displayed}", f">= {LEAST:g} {displayed} and <= {MOST:g} {displayed}"
    )
    return value


def node_numbers(raw: str | Sequence[int], name: str) -> tuple[int, ...]:
    """Return node numbers given in a sequence or in a text with commas.

    Raises
    ------
    ValueError
        If one of them is no whole number.
    """
    if not isinstance(raw, str):
        return tuple(raw)
    parts = [part.strip() for part in raw.split(",")]
    require(all(part.isdecimal() for part in parts), name, raw, "node numbers with commas between them")
    return tuple(int(part) for part in parts)
