"""The variables of a model in FMI 3.0: numbered variables form arrays, and all others are scalars.

Variables that are named after a component remain scalars in FMI 3.0, because users connect bearing axes, discs and
contact sites one by one and look them up by name (`seal.f_n`). Numbered variables and matrices become arrays. Examples
are the sensor signals (which a single connection then takes from the plant to the controller), the weights and scales
of the sensors, the sensor planes, and the identified receptance. The elements of an array are consecutive in the table,
row by row, so the array is a slice of the model's flat arrays.

The value reference of a variable is its position in the table; an array has the reference of its first element. For
hosts that read one value per reference, `without_arrays` returns a model in which each element is a variable, as in FMI
2.0.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

from amb_files.checks import repeated
from fmi_export.interface import Interface
from fmi_export.model import Model
from fmi_export.variables import Variable


@dataclass(frozen=True)
class Slot:
    """A variable of FMI 3.0: its value reference, the scalar variables that it contains, and its shape."""

    reference: int
    variables: tuple[Variable, ...]
    shape: tuple[int, ...]

    @property
    def name(self) -> str:
        array = self.variables[0].array
        return array.name if array else self.variables[0].name

    @property
    def description(self) -> str:
        array = self.variables[0].array
        return array.description if array else self.variables[0].description


def without_arrays(model: Model) -> Model:
    """Return a model that has no arrays in FMI 3.0, but has the names and references of FMI 2.0."""
    variables = tuple(replace(v, array=None) for v in model.interface.variables)
    return replace(model, interface=Interface(variables))


def slots(table: Interface) -> list[Slot]:
    """Return the variables of FMI 3.0 in the order of the table.

    Raises
    ------
    ValueError
        If the elements of an array differ in more than name, description, start value and dependencies, if they do not
        fill its shape, or if two variables have the same name.
    """
    result = []
    numbered = enumerate(table.variables)
    for _, group in itertools.groupby(numbered, key=lambda item: (item[1].causality, item[1].array or item[0])):
        references, variables = zip(*group, strict=True)
        result.append(Slot(references[0], variables, _shape(variables)))
    if duplicates := repeated(slot.name for slot in result):
        raise ValueError(f"two variables of FMI 3.0 have the same name: {', '.join(sorted(duplicates))}")
    return result


def lengths(table: Interface) -> list[int]:
    """Return the number of values at each reference: 1 for a scalar; for an array, its size at the first and then 0."""
    result = [0] * len(table.variables)
    for slot in slots(table):
        result[slot.reference] = len(slot.variables)
    return result


def _shape(variables: tuple[Variable, ...]) -> tuple[int, ...]:
    first = variables[0]
    if first.array is None:
        return ()
    if len({_without_name(v) for v in variables}) > 1:
        raise ValueError(f"the elements of the array {first.array.name} differ: {first.name} is not like the others")
    if math.prod(first.array.shape) != len(variables):
        raise ValueError(
            f"{len(variables)} variables do not fill array {first.array.name} of shape {first.array.shape}"
        )
    return first.array.shape


def _without_name(v: Variable) -> Variable:
    """Return a variable without those attributes in which the elements of an array may differ."""
    start = min(max(0.0, v.minimum), v.maximum)
    return replace(
        v, name="", description="", field="", start=start, depends_on=(), initially_depends_on=None, initially_equals=""
    )
