"""The parts of a sweep that stand side by side: one for each of its alternatives."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from amb_cosim.sweeps.axes import Axis, is_moment
from amb_cosim.sweeps.sampling import SAMPLE, SamplePlan

if TYPE_CHECKING:
    import xarray as xr

PREPOSITIONS = ("at", "of", "in", "on", "to")
NOTHING: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True)
class MapPanel:
    """A part of a sweep: its title, and its index along each axis that is fixed in it."""

    title: str
    at: dict[str, int]


def numeric_axes(design: SamplePlan) -> list[str]:
    """Return the axes of numbers, the axis of a sample among them."""
    return [axis.name for axis in design.axes if axis.name == SAMPLE or (axis.columns[0].numeric and len(axis) > 1)]


def panels(design: SamplePlan, across: Collection[str], described: Mapping[str, str] = NOTHING) -> list[MapPanel]:
    """Return a panel for each combination of values of the axes that do not go across it.

    Its title has the words of `described`, descriptions by name, or else names.
    """
    others = [axis for axis in design.axes if axis.name not in across]
    result = []
    for index in np.ndindex(*(len(axis) for axis in others)):
        values = [_titled(axis, axis.columns[0].values[k], described) for axis, k in zip(others, index, strict=True)]
        at = {axis.name: int(k) for axis, k in zip(others, index, strict=True)}
        result.append(MapPanel(", ".join(values), at))
    return result


def descriptions(dataset: xr.Dataset) -> dict[str, str]:
    """Return the descriptions of what a sweep varies, by name, where there are any."""
    return {str(name): str(c.attrs["description"]) for name, c in dataset.coords.items() if "description" in c.attrs}


def common_words(descriptions: Sequence[str]) -> str:
    """Return the words with which all descriptions begin, without a preposition at the end: `Friction`, not `at A`."""
    at_each_place = zip(*(text.split() for text in descriptions), strict=False)  # as many as the shortest has
    words = [words[0] for words in takewhile(lambda words: len(set(words)) == 1, at_each_place)]
    return " ".join(words[:-1] if words and words[-1] in PREPOSITIONS else words)


def shown(name: str, value: Any, unit: str, described: str = "") -> str:
    """Return the value of a variable as text, `u = 25 g.m`, or `Unbalance: 25 g.m` where it is described."""
    number = value if isinstance(value, str) else format(value, ".4g")
    begin = f"{words_of(name, described)}:" if described else f"{short(name)} ="
    return f"{begin} {number} {unit if unit != '1' else ''}".rstrip()


def words_of(name: str, described: str) -> str:
    """Return what a variable is, by the first words of its description, or `short`."""
    return first_words(described) or short(name)


def first_words(described: str) -> str:
    """Return what a description begins with, up to what explains it."""
    return re.split(r"; | \(| at the beginning", described)[0]


def short(name: str) -> str:
    """Return the last part of the name of a variable, of a moment with its event."""
    label, _, last = name.rpartition(".")
    return f"{last} of the {label.replace('_', ' ')}" if is_moment(name) else last


def _titled(axis: Axis, value: Any, described: Mapping[str, str]) -> str:
    if axis.alternatives or axis.name == "scenario":
        return str(value)
    return shown(axis.name, value, axis.columns[0].unit, described.get(axis.name, ""))
