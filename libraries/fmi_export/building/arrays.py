"""The variables of a model as FMI 3.0 has them: numbered ones together as arrays, all others alone.

A variable that is named after a place keeps its name and stays alone in FMI 3.0 too: bearing axes, discs and contact
sites are wired one by one, and each is looked for by its name (`seal.f_n`). An array is what only has a number,
of which there are as many as the rotor has sensors, and what is a matrix by nature: the sensors of the plant and of the
controller, which one connection joins, their weights and scales, the sensor planes, and the identified receptance. Its
elements stand one after another in the table, row by row, so that the array is a piece of the model's flat arrays.

Positions in the table are value references; an array has that of its first element. For hosts that read one value per
reference a model `without_arrays` has each element as a variable of its own, as in FMI 2.0.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

from fmi_export.interface import Interface
from fmi_export.model import Model
from fmi_export.variables import Variable


@dataclass(frozen=True)
class Slot:
    """A variable of FMI 3.0: a value reference, the scalar variables it stands for, and its shape, () of a scalar."""

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
    """Return a model whose variables all stand alone in FMI 3.0, with the names and references of FMI 2.0."""
    variables = tuple(replace(v, array=None) for v in model.interface.variables)
    return replace(model, interface=Interface(variables))


def slots(table: Interface) -> list[Slot]:
    """Return the variables of FMI 3.0 in the order of the table.

    Raises
    ------
    ValueError
        If the elements of an array differ in more than name, description, start value and dependencies, or do not fill
        its shape, or two variables have one name.
    """
    result = []
    numbered = enumerate(table.variables)
    for _, group in itertools.groupby(numbered, key=lambda item: (item[1].causality, item[1].array or item[0])):
        references, variables = zip(*group, strict=True)
        result.append(Slot(references[0], variables, _shape(variables)))
    names = [slot.name for slot in result]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"two variables of FMI 3.0 have one name: {', '.join(sorted(twice))}")
    return result


def lengths(table: Interface) -> list[int]:
    """Return for each variable how many values its reference stands for: 1, an array's size, or 0 within an array."""
    result = [0] * len(table.variables)
    for slot in slots(table):
        result[slot.reference] = len(slot.variables)
    return result


def _shape(variables: tuple[Variable, ...]) -> tuple[int, ...]:
    first = variables[0]
    if first.array is None:
        return ()
    if len({_without_its_own(v) for v in variables}) > 1:
        raise ValueError(f"the elements of the array {first.array.name} differ: {first.name} is not like the others")
    if math.prod(first.array.shape) != len(variables):
        raise ValueError(f"{len(variables)} variables do not fill the array {first.array.name} of {first.array.shape}")
    return first.array.shape


def _without_its_own(v: Variable) -> Variable:
    """Return a variable without what each element of an array may have for itself."""
    start = min(max(0.0, v.minimum), v.maximum)
    return replace(v, name="", description="", field="", start=start, depends_on=(), starts_from=None, starts_as="")
