"""The parts of a sweep that stand side by side: one for each of its alternatives."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from amb_cosim.sweeps.axes import Axis
from amb_cosim.sweeps.sampling import SAMPLE, Design


@dataclass(frozen=True)
class MapPanel:
    """A part of a sweep: its title, and its index along each axis that is fixed in it."""

    title: str
    at: dict[str, int]


def numeric_axes(design: Design) -> list[str]:
    """Return the axes of numbers, the axis of a sample among them."""
    return [axis.name for axis in design.axes if axis.name == SAMPLE or (axis.columns[0].numeric and len(axis) > 1)]


def panels(design: Design, across: Collection[str]) -> list[MapPanel]:
    """Return a panel for each combination of values of the axes that do not go across it."""
    others = [axis for axis in design.axes if axis.name not in across]
    found = []
    for index in np.ndindex(*(len(axis) for axis in others)):
        values = [_titled(axis, axis.columns[0].values[k]) for axis, k in zip(others, index, strict=True)]
        at = {axis.name: int(k) for axis, k in zip(others, index, strict=True)}
        found.append(MapPanel(", ".join(values), at))
    return found


def shown(name: str, value: Any, unit: str) -> str:
    """Return the value of a variable as text, `u = 25 g.m`."""
    number = value if isinstance(value, str) else format(value, ".4g")
    return f"{short(name)} = {number} {unit if unit != '1' else ''}".rstrip()


def short(name: str) -> str:
    """Return the last part of the name of a variable, with the event that sets it."""
    label, _, rest = name.partition(".")
    last = name.rpartition(".")[2]
    return f"{last} of the {label}" if rest and label in ("step", "removal") else last


def _titled(axis: Axis, value: Any) -> str:
    if axis.alternatives or axis.name == "scenario":
        return str(value)
    return shown(axis.name, value, axis.columns[0].unit)
