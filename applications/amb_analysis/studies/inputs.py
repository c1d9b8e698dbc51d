"""Arguments of studies: numbers in SI units, or strings with a unit."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from amb_cosim.cosim.fmu.fmus import FmuSource
from amb_cosim.cosim.system.values import Raw, quantity, stated
from amb_cosim.presentation.units import speed_unit
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_files.checks import require
from amb_files.plain_values import listed
from array_types import Array
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, numbered_positions

LEAST, MOST = 1e-12, 1e12  # of a positive number, in any unit
DEFAULT_RANGE = "6000 rpm"  # highest speed of diagrams of a rotor alone, and of a machine at rest
GRADE = 2.5e-3  # m/s: balancing grade G 2.5, if the machine states none
BEYOND = 1.25  # highest speed of diagrams of a rotor, over the operating speed
HIGHEST = 1e5  # rad/s; dentists' drills turn at a third of it

Number = Raw
"""A number in the requested unit, or a string with another unit of the same dimension (`"16 Hz"`)."""


def controlled(
    scenario: str | Path | Scenario | None, rotor: RotorSource, controller: FmuSource | PathLike[str] | None
) -> Scenario:
    """Return the scenario for a study of a controlled machine.

    Parameters
    ----------
    scenario
        A `Scenario`, the name of a packaged scenario, or a TOML file; by default the packs' default scenario.
    rotor
        A rotor, the name of a packaged rotor, or a rotor file, to use instead of the scenario's.
    controller
        Controller file, object or FMU, which replaces the scenario's controller.
    """
    return as_scenario(scenario, rotor, fmu=None if controller is None else {CONTROLLER: controller})


def spin_speed(raw: Number, name: str = "speed") -> float:
    """Return a spin speed (rad/s) from a number or a string, such as 90, `"90 rad/s"` or `"16 Hz"`.

    Raises
    ------
    ValueError
        If the value is not a speed, is negative, or is above `HIGHEST`.
    """
    value = quantity(raw, "rad/s", name)
    allowed = f">= {speed_unit().text(0.0)} and <= {speed_unit().text(HIGHEST)}"
    require(0.0 <= value <= HIGHEST, name, stated(speed_unit().text(value), raw), allowed)
    return value


def spin_speeds(raw: Number | Sequence[Number]) -> list[float]:
    """Return spin speeds (rad/s) from one speed, a sequence of speeds, or a comma-separated string."""
    return [spin_speed(part, "speeds") for part in (raw.split(",") if isinstance(raw, str) else listed(raw))]


def reach_of(rotor: Rotor, speed: float | None = None) -> Number:
    """Return the highest speed for a diagram of a rotor: 1.25 times the operating speed (rad/s), if this is known.

    Otherwise, the diagram ends at the highest speed that the rotor file states (`[reduction] speed`), or else at 6000
    rpm.
    """
    return BEYOND * speed if speed else rotor.reduction.speed or DEFAULT_RANGE


def speed_range(up_to: Number, points: int, lowest: float = 0.0) -> Array:
    """Return evenly spaced spin speeds (rad/s) from the lowest speed to `up_to`, shape (points,).

    Raises
    ------
    ValueError
        If `up_to` is not a speed above the lowest.
    """
    highest = spin_speed(up_to, "up_to")
    require(highest > lowest, "up_to", stated(speed_unit().text(highest), up_to), f"> {speed_unit().text(lowest)}")
    return np.linspace(lowest, highest, points)


def positive(raw: Number, unit: str, name: str, reason: str = "") -> float:
    """Return a positive, finite number, converted to a unit.

    Raises
    ------
    ValueError
        If the value is not such a number or is not between `LEAST` and `MOST`; `reason` is appended to the allowed
        range.
    """
    value, unit_text = quantity(raw, unit, name), unit.replace(".", " ")
    shown = stated(f"{value:g} {unit_text}", raw)
    require(0.0 < value < float("inf"), name, shown, f"> 0 {unit_text}{reason}")
    require(LEAST <= value <= MOST, name, shown, f">= {LEAST:g} {unit_text} and <= {MOST:g} {unit_text}")
    return value


def node_numbers(raw: str | int | Sequence[int], name: str, rotor: Rotor, source: RotorSource) -> tuple[int, ...]:
    """Return the nodes of a rotor that have these numbers in its file, from a sequence or a comma-separated string.

    The rotor may also have nodes without a number in its file, because `z` and `[mesh]` add nodes
    (`rotor_file.numbered_positions`).

    Raises
    ------
    ValueError
        If one of the numbers does not denote a node in the file.
    """
    numbers = (raw,) if isinstance(raw, int) else raw
    if isinstance(numbers, str):
        parts = [part.strip() for part in numbers.split(",")]
        require(all(part.isdecimal() for part in parts), name, numbers, "node numbers separated by commas")
        numbers = tuple(int(part) for part in parts)
    positions = numbered_positions(source)
    for number in numbers:
        require(
            1 <= number <= len(positions), name, number, f"a node number of the rotor file, from 1 to {len(positions)}"
        )
    nodes = [rotor.shaft.node_at(positions[number - 1]) for number in numbers]
    return tuple(node for node in nodes if node is not None)
