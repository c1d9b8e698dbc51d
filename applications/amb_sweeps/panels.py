"""Panels of a sweep, one for each of its alternatives."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from amb_cosim.presentation.units import ShownUnit, speed_unit
from amb_sweeps.axes import Axis, is_moment
from amb_sweeps.sampling import SAMPLE, SamplePlan

if TYPE_CHECKING:
    import xarray as xr

NOTHING: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class MapPanel:
    """A panel: its title, and its index along each fixed axis."""

    title: str
    at: dict[str, int]


def numeric_axes(design: SamplePlan) -> list[str]:
    """Return the numeric axes, including the axis of a sample."""
    return [axis.name for axis in design.axes if axis.name == SAMPLE or (axis.columns[0].numeric and len(axis) > 1)]


def panels(design: SamplePlan, across: Collection[str], described: Mapping[str, str] = NOTHING) -> list[MapPanel]:
    """Return a panel for each combination of values of the axes that are not plotted.

    Titles use the descriptions in `described`; for a variable without a description, they use its name.
    """
    others = [axis for axis in design.axes if axis.name not in across]
    result = []
    for index in np.ndindex(*(len(axis) for axis in others)):
        values = [_titled(axis, axis.columns[0].values[k], described) for axis, k in zip(others, index, strict=True)]
        at = {axis.name: int(k) for axis, k in zip(others, index, strict=True)}
        result.append(MapPanel(", ".join(values), at))
    return result


def descriptions(dataset: xr.Dataset) -> dict[str, str]:
    """Return the descriptions of the variations of a sweep, by name."""
    return {str(name): str(c.attrs["description"]) for name, c in dataset.coords.items() if "description" in c.attrs}


def value_text(name: str, value: Any, unit: str, described: str = "") -> str:
    """Return a value as text: `u = 25 g m`, or `Unbalance: 25 g m` if described; speeds are in the chosen unit."""
    begin = f"{words_of(name, described)}:" if described else f"{short(name)} ="
    if unit == "rad/s" and not isinstance(value, str):
        return f"{begin} {speed_unit().text(value)}"
    number = value if isinstance(value, str) else format(value, ".4g")
    return f"{begin} {number} {shown_unit(unit) if unit != '1' else ''}".rstrip()


def shown_unit(unit: str) -> str:
    """Return a unit as written in figures, with a space between factors: `g m` for `g.m`."""
    return ShownUnit(unit, 1.0).label.replace(".", " ")


def words_of(name: str, described: str) -> str:
    """Return the name of a variable in words: the beginning of its description, or `short`."""
    return first_words(described) or short(name)


def first_words(described: str) -> str:
    """Return the beginning of a description, without its explanation but with the event from which it applies."""
    return re.split(r"; |, (?!from |before )| \(| at the beginning", described)[0]


def short(name: str) -> str:
    """Return the last part of a variable's name; for the moment of an event, add the label of the event."""
    label, _, last = name.rpartition(".")
    return f"{last} of the {label.replace('_', ' ')}" if is_moment(name) else last


def _titled(axis: Axis, value: Any, described: Mapping[str, str]) -> str:
    if axis.alternatives or axis.name == "scenario":
        return str(value)
    return value_text(axis.name, value, axis.columns[0].unit, described.get(axis.name, ""))
