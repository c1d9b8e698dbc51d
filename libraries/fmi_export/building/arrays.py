"""The variables of a model as FMI 3.0 has them: numbered ones together as arrays, all others alone.

A variable that is named after a place keeps its name and stays alone in FMI 3.0 too: bearing axes, discs and contact
sites are wired one by one, and each is looked for by its name (`mb1.f_x`). An array is what only has a number,
of which there are as many as the rotor has sensors, and what is a matrix by nature: the sensors of the plant and of the
controller, which one connection joins, their weights and scales, the sensor planes, and the identified receptance. Its
elements stand one after another in the table, row by row, so that the array is a piece of the model's flat arrays.

Positions in the table are value references; an array has that of its first element.
"""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import dataclass, replace

from fmi_export.variables import Interface, Variable


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


def slots(table: Interface) -> list[Slot]:
    """Return the variables of FMI 3.0 in the order of the table.

    Raises
    ------
    ValueError
        If the elements of an array differ in more than name, description, start value and dependencies, or do not fill
        its shape, or two variables have one name.
    """
    found = []
    numbered = enumerate(table.variables)
    for _, group in itertools.groupby(numbered, key=lambda item: (item[1].causality, item[1].array or item[0])):
        references, variables = zip(*group, strict=True)
        found.append(Slot(references[0], variables, _shape(variables)))
    names = [slot.name for slot in found]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"two variables of FMI 3.0 have one name: {', '.join(sorted(twice))}")
    return found


def lengths(table: Interface) -> list[int]:
    """Return for each variable how many values its reference stands for: 1, an array's size, or 0 within an array."""
    found = [0] * len(table.variables)
    for slot in slots(table):
        found[slot.reference] = len(slot.variables)
    return found


def _shape(variables: tuple[Variable, ...]) -> tuple[int, ...]:
    """Return the shape of an array from the indices in the fields of its elements; the parts of each come last."""
    first = variables[0]
    if first.array is None:
        return ()
    alike = {replace(v, name="", description="", start=first.start, field="", depends_on=()) for v in variables}
    if len(alike) > 1:
        raise ValueError(f"the elements of the array {first.array.name} differ: {first.name} is not like the others")
    indices = [tuple(int(i) for i in _index_of(v.field).split(",")) for v in variables]
    shape = tuple(1 + max(of_one) for of_one in zip(*indices, strict=True))
    parts = len(variables) // len(set(indices))
    if parts * math.prod(shape) != len(variables) or indices != sorted(indices):
        raise ValueError(f"the elements of the array {first.array.name} do not fill a shape of {shape}")
    return shape if parts == 1 else (*shape, parts)


def _index_of(field: str) -> str:
    found = re.search(r"\[([\d,]+)\]", field)
    if found is None:
        raise ValueError(f"{field} has no index, and cannot be in an array")
    return found[1]
