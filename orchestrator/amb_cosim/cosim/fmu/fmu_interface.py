"""The part of a modelDescription that wiring, scenarios and results need; `fmu_description` reads it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from amb_files.suggestions import suggest
from amb_files.wildcards import matching_names
from fmi_export.variables import OverStep

UnitDefinition = tuple[float, ...]  # exponents of kg, m, s, A, K, mol, cd, rad, then factor and offset


@dataclass(frozen=True)
class Port:
    """A scalar variable of an FMU, or an element of an array.

    `type` is Real, Integer or Boolean; `stored` is the type in the FMU, for example Float64, Int8 or Enumeration in FMI
    3.0. An array of `size` elements has one value reference and is exchanged as a whole. `element` counts the elements
    from 0; `array` is the array's name and the element's indices, which count from 1. `definition` is None if the FMU
    does not define the unit; `units` contains all units that the FMU defines, and the display units of this unit. For
    an output, `depends_on` lists the inputs that reach it without delay. If an output is a warning, `warning` is its
    sentence. `over_step` says how an output summarises a step. For an Enumeration, whose `type` is Integer, `items`
    maps names to values. A `relative` quantity is a difference, such as a rise in temperature, so it is converted
    between units without their offsets. `has_start` is true for an output or local variable, such as a state, whose
    start value the FMU lets a user set.
    """

    name: str
    type: str
    causality: str
    reference: int
    unit: str | None = None
    definition: UnitDefinition | None = None
    minimum: float = -math.inf
    maximum: float = math.inf
    start: float | None = None
    description: str = ""
    depends_on: tuple[str, ...] = ()
    warning: str = ""
    over_step: OverStep = "end"
    items: Mapping[str, int] = field(default_factory=dict)
    variability: str = "continuous"
    stored: str = ""
    element: int = 0
    size: int = 1
    array: tuple[str | int, ...] = ()
    units: Mapping[str, UnitDefinition] = field(default_factory=dict, compare=False, repr=False)
    relative: bool = False
    has_start: bool = False

    @property
    def set_as(self) -> str:
        """How a user sets the variable: as an `input` or a `parameter`; an empty text if only the FMU computes it.

        A start value, such as the initial height of a falling ball, is set before initialisation like a parameter.
        """
        if self.causality in ("input", "parameter"):
            return self.causality
        return "parameter" if self.has_start else ""

    @property
    def position(self) -> int:
        """Position of the value in the memory of an FMU exported by this project; each array element has its own."""
        return self.reference + self.element

    @property
    def declared(self) -> str:
        """The type for messages: the type in the FMU, if it is known."""
        return self.stored or self.type

    @property
    def display_unit(self) -> str:
        """The unit with a leading space; empty if there is no unit."""
        return "" if self.unit in (None, "", "1") else f" {self.unit}"

    @property
    def kind(self) -> str:
        """The causality with its article, such as `an input`."""
        return f"{'an' if self.causality[0] in 'io' else 'a'} {self.causality}"

    def allowed(self) -> str:
        """Allowed values in words."""
        if self.type == "Boolean":
            return "true or false"
        if self.items:
            return f"one of {', '.join(f'{value} ({name})' for name, value in self.items.items())}"
        if f"{self.minimum:g}" == f"{self.maximum:g}":  # apart from rounding, as of a controller's sample time
            return f"{self.minimum:g}{self.display_unit}"
        low = f">= {self.minimum:g}" if self.minimum > -math.inf else ""
        high = f"<= {self.maximum:g}" if self.maximum < math.inf else ""
        bounds = " and ".join(bound for bound in (low, high) if bound)
        if not bounds:
            return "a finite number"
        return bounds + self.display_unit


@dataclass(frozen=True)
class TextVariable:
    """A String or Binary variable of an FMU; its value is set before initialisation and is not exchanged.

    `size` is the number of elements of an array.
    """

    name: str
    type: Literal["String", "Binary"]
    causality: str
    reference: int
    size: int = 1

    @property
    def kind(self) -> str:
        """The causality with its article, such as `an input`."""
        return f"{'an' if self.causality[0] in 'io' else 'a'} {self.causality}"

    def value(self, raw: object, name: str) -> str | bytes:
        """Return a value in the form that the FMU accepts: text, or bytes, which users write as hexadecimal digits.

        Raises
        ------
        ValueError
            If it is not allowed; the message begins with `name`.
        """
        if self.size != 1:
            raise ValueError(
                f"{name} is an array of type {self.type}, which cannot be set; only scalars of this type can be set"
            )
        if not isinstance(raw, str):
            raise ValueError(f"{name} = {raw} is not allowed; a {self.type} must be set to text in quotes")
        if self.type == "String":
            if "\0" in raw:
                raise ValueError(
                    f"{name} = {raw!r} is not allowed; a String must not contain the character with code 0"
                )
            return raw
        try:
            return bytes.fromhex(raw)
        except ValueError as error:
            digits = "hexadecimal digits, such as '00 ff'"
            raise ValueError(f"{name} = {raw!r} is not allowed; it is a Binary and must be {digits}") from error


@dataclass(frozen=True)
class FmuInterface:
    """An FMU's identity and its variables by name, in the order of the modelDescription.

    If `takes_any_step` is set, the FMU can handle communication steps of any size. If `saves_state` is set, it can
    return to an earlier state. If `serialises_state` is set, a state can be converted to bytes. `states` are the names
    of the continuous states and their time derivatives, if an FMI 2.0 FMU lists them and provides directional
    derivatives. `fmi` is the version of FMI. A process can have only one instance of an FMU that is `once_per_process`.
    `texts` are its String and Binary variables. `deviations` lists the rules of FMI that its description breaks.
    `internal_step` and `tolerance` are the step size (s) and the relative tolerance of its default experiment. If
    `reports_faults` is set, the FMU was made by this project, so its output `fault_code` is 0 unless there is a fault.
    """

    identifier: str
    guid: str
    version: str
    ports: Mapping[str, Port]
    takes_any_step: bool = False
    saves_state: bool = False
    serialises_state: bool = False
    states: tuple[tuple[str, str], ...] = ()
    fmi: Literal[2, 3] = 2
    once_per_process: bool = False
    texts: Mapping[str, TextVariable] = field(default_factory=dict)
    reports_faults: bool = False
    deviations: tuple[str, ...] = ()
    internal_step: float | None = None
    tolerance: float | None = None

    def of(self, causality: str) -> tuple[Port, ...]:
        """Return the variables with this causality."""
        return self._by_causality.get(causality, ())

    @cached_property
    def _by_causality(self) -> dict[str, tuple[Port, ...]]:
        kinds = dict.fromkeys(port.causality for port in self.ports.values())
        return {kind: tuple(port for port in self.ports.values() if port.causality == kind) for kind in kinds}

    @cached_property
    def start_parameters(self) -> dict[str, float | None]:
        """Start values of the parameters by name."""
        return {port.name: port.start for port in self.of("parameter")}

    def elements(self, name: str, place: tuple[int, ...] = ()) -> tuple[Port, ...]:
        """Return the variable `name`; for an array, its elements row by row, or only the element at `place`."""
        if name in self.ports and not place:
            return (self.ports[name],)
        return tuple(p for p in self.ports.values() if p.array[:1] == (name,) and place in ((), p.array[1:]))

    def matching(self, pattern: str) -> tuple[Port, ...]:
        """Return the variables whose names match a pattern with `*` and `?`."""
        if pattern not in self._matching:
            self._matching[pattern] = tuple(self.ports[name] for name in matching_names(self.ports, pattern))
        return self._matching[pattern]

    @cached_property
    def _matching(self) -> dict[str, tuple[Port, ...]]:
        return {}

    def port(self, name: str, component: str) -> Port:
        """Return the variable `name`.

        Raises
        ------
        ValueError
            If no variable has this name; the message lists similar names.
        """
        if name in self.texts:
            restriction = "its value can be set at the start, but not changed, connected or recorded"
            raise ValueError(f"{component}.{name} is a {self.texts[name].type}; {restriction}")
        if name not in self.ports:
            raise ValueError(f"{component} has no variable {name!r}; {suggest(name, [*self.ports, *self.texts])}")
        return self.ports[name]

    def whole(self, port: Port) -> tuple[Port, ...]:
        """Return the elements of a variable's array in order; for a scalar, only the scalar."""
        return (port,) if port.size == 1 else self._arrays[port.reference]

    @cached_property
    def _arrays(self) -> dict[int, tuple[Port, ...]]:
        result: dict[int, dict[int, Port]] = {}
        for port in self.ports.values():
            if port.size > 1:
                result.setdefault(port.reference, {}).setdefault(port.element, port)
        return {reference: tuple(by_element.values()) for reference, by_element in result.items()}
