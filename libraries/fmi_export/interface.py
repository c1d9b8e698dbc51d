"""The variable table of an FMU: the order of its variables, and their positions in the arrays of the kernels."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fmi_export.records import record_of
from fmi_export.variables import FAULT_CODE, ORDER, Array, Causality, Enumeration, Variable, named_in


@dataclass(frozen=True)
class Interface:
    """An ordered variable table and the positions of its variables.

    Raises
    ------
    ValueError
        If a name occurs twice; if the order is not parameters, inputs, outputs; if a dependency is not an input; if an
        output initially depends on anything other than parameters and inputs; if a warning names an unknown variable;
        or if two enumerations have the same name.
    """

    variables: tuple[Variable, ...]

    def __post_init__(self) -> None:
        names = Counter(v.name for v in self.variables)
        duplicates = sorted(name for name, count in names.items() if count > 1)
        if duplicates:
            raise ValueError(f"variables declared twice: {', '.join(duplicates)}")
        ranks = [ORDER.index(v.causality) for v in self.variables]
        if ranks != sorted(ranks):
            raise ValueError("variables must be in the order parameters, inputs, outputs")
        inputs = {v.name for v in self.variables if v.causality == "input"}
        for v in self.variables:
            unknown = set(v.depends_on) - inputs
            if unknown:
                raise ValueError(f"{v.name} depends on {', '.join(sorted(unknown))}, which are not inputs")
            unknown = set(named_in(v.warning)) - set(names)
            if unknown:
                raise ValueError(f"the warning of {v.name} names {', '.join(sorted(unknown))}, which are not variables")
        for kind in {v.enumeration for v in self.variables if v.enumeration}:
            if kind != self.enumerations[kind.name]:
                raise ValueError(f"there are two enumerations called {kind.name}")
        _ = self.initial_dependencies

    @cached_property
    def position(self) -> dict[str, int]:
        """Value reference of each variable, by name."""
        return {v.name: i for i, v in enumerate(self.variables)}

    def __getitem__(self, name: str) -> Variable:
        return self.variables[self.position[name]]

    def of(self, causality: Causality) -> tuple[Variable, ...]:
        return tuple(v for v in self.variables if v.causality == causality)

    @cached_property
    def initial_dependencies(self) -> dict[str, tuple[str, ...]]:
        """Names of the parameters and inputs on which each output depends at initialisation, if these are declared."""
        positions: dict[str, list[int]] = {}
        for i, v in enumerate(self.variables):
            for name in _dependency_names(v) if v.causality != "output" else ():
                positions.setdefault(name, []).append(i)
        result: dict[str, tuple[str, ...]] = {}
        names: dict[tuple[str, ...], tuple[str, ...]] = {}  # outputs of equal parts have the same start dependencies
        for v in self.of("output"):
            declared = _declared_dependencies(v)
            if declared is None:
                continue
            if declared not in names:
                unknown = [name for name in declared if name not in positions and not self._lacks(name)]
                if unknown:
                    raise ValueError(
                        f"{v.name} initially depends on {', '.join(unknown)}, which are neither parameters nor inputs"
                    )
                indices = {i for name in declared for i in positions.get(name, ())}
                names[declared] = tuple(self.variables[i].name for i in sorted(indices))
            result[v.name] = names[declared]
        return result

    def _lacks(self, name: str) -> bool:
        """Return whether `name`, such as `sites[*].clearance`, refers to parts that this interface does not have."""
        array, is_repeated, _ = name.partition("[*]")
        return bool(is_repeated) and not any(v.field.startswith(f"{array}[") for v in self.variables)

    def with_all_parts(self) -> Interface:
        """Return this interface after checking that it contains at least one part of each possible kind.

        Raises
        ------
        ValueError
            If an output initially depends on parts that the interface lacks. Because this interface should contain
            every kind of part, such parts do not exist in any interface of the model.
        """
        for v in self.of("output"):
            missing = [name for name in _declared_dependencies(v) or () if self._lacks(name)]
            if missing:
                raise ValueError(
                    f"{v.name} initially depends on {', '.join(missing)}, which belong to parts that do not exist"
                )
        return self

    @cached_property
    def enumerations(self) -> dict[str, Enumeration]:
        """The enumerations of the variables, by name, in the order of the table."""
        return {v.enumeration.name: v.enumeration for v in self.variables if v.enumeration}

    @cached_property
    def warnings(self) -> dict[int, str]:
        """Texts of those outputs that are warnings, by value reference."""
        return {i: v.warning for i, v in enumerate(self.variables) if v.warning}

    @cached_property
    def n_parameters(self) -> int:
        return len(self.of("parameter"))

    @cached_property
    def n_inputs(self) -> int:
        return len(self.of("input"))

    @cached_property
    def n_outputs(self) -> int:
        return len(self.of("output"))

    def index(self, causality: Causality, name: str) -> int:
        """Return the position of a variable within the array of its causality."""
        if name not in self.position or self[name].causality != causality:
            names = ", ".join(v.name for v in self.of(causality))
            raise ValueError(f"there is no {causality} called {name!r}; there are {names}")
        before = {"parameter": 0, "input": self.n_parameters, "output": self.n_parameters + self.n_inputs}
        return self.position[name] - before[causality]

    @cached_property
    def records(self) -> tuple[np.dtype[np.record], np.dtype[np.record], np.dtype[np.record]]:
        """Record types of the parameter, input and output arrays, for a model whose interface is always the same."""
        parameters, inputs, outputs = (record_of((v.field or v.name) for v in self.of(kind)) for kind in ORDER)
        return parameters, inputs, outputs

    def common_record(self, causality: Causality) -> np.dtype[np.record]:
        """Return the record type of the variables that are not repeated, which come first in their array."""
        common = [v.field or v.name for v in self.of(causality) if not _is_repeated(v)]
        return record_of(place for place in common if place != FAULT_CODE)

    def element_record(self, causality: Causality, field: str) -> np.dtype[np.record]:
        """Return the record type of each of the equal parts that `repeated` declared as `field`."""
        prefix = f"{field}[0]."
        return record_of(v.field.removeprefix(prefix) for v in self.of(causality) if v.field.startswith(prefix))

    @cached_property
    def start(self) -> NDArray[np.float64]:
        return np.array([v.start for v in self.variables], dtype=np.float64)

    @cached_property
    def minimum(self) -> NDArray[np.float64]:
        return np.array([v.minimum for v in self.variables], dtype=np.float64)

    @cached_property
    def maximum(self) -> NDArray[np.float64]:
        return np.array([v.maximum for v in self.variables], dtype=np.float64)

    def canonical(self) -> bytes:
        """Return bytes, for the guid, that change whenever the interface changes."""
        return json.dumps([asdict(v) for v in self.variables], sort_keys=True).encode()


def interface(*groups: Variable | Iterable[Variable]) -> Interface:
    """Return the interface with these variables and groups of variables.

    The variables are sorted into parameters, inputs and outputs. Within each kind, single variables precede repeated
    ones, so that the positions of single variables do not depend on the number of repeated ones. The last output is
    `fault_code`.
    """
    flat: list[Variable] = []
    for group in groups:
        flat.extend([group] if isinstance(group, Variable) else group)
    return Interface(tuple(sorted(flat, key=_rank)))


def _rank(v: Variable) -> tuple[int, bool, bool]:
    return ORDER.index(v.causality), v.name == FAULT_CODE, _is_repeated(v)


def _is_repeated(v: Variable) -> bool:
    return "[" in v.field


def _dependency_names(v: Variable) -> list[str]:
    """Return the names by which `initially_depends_on` may refer to a variable."""
    return [v.name, re.sub(r"\[[\d,]+\]", "[*]", v.field)] if _is_repeated(v) else [v.name]


def _declared_dependencies(v: Variable) -> tuple[str, ...] | None:
    return (*(v.initially_depends_on or ()), v.initially_equals) if v.initially_equals else v.initially_depends_on


def repeated(
    field: str,
    members: Sequence[tuple[object, ...]],
    declare: Callable[..., Iterable[Variable]],
    shape: tuple[int, ...] | None = None,
    array: Array | None = None,
) -> list[Variable]:
    """Declare the variables of several equal parts; kernels see an array of records, with `field[k]` for member k.

    Parameters
    ----------
    field
        Name of the array in the records that kernels use.
    members
        For each part, the arguments of `declare`.
    declare
        Function that returns the variables of a part. Within the record of a part, the name of a variable is its
        `field` or, by default, the end of its full name after the last dot. If its `field` is `"."`, the variable is
        the whole part.
    shape
        Shape of the array; the default is (len(members),).
    array
        Array that the parts form in FMI 3.0; by default, they are single variables.
    """
    variables = []
    size = shape or (len(members),)
    for k, member in enumerate(members):
        at = f"{field}[{','.join(str(i) for i in np.unravel_index(k, size))}]"
        parts = list(declare(*member))
        shaped = array and array._replace(shape=size if len(parts) == 1 else (*size, len(parts)))
        for v in parts:
            common = v.field or v.name.rpartition(".")[2]
            variables.append(replace(v, field=at if common == "." else f"{at}.{common}", array=shaped))
    return variables
