"""Variables: declarations of the interface of an FMU.

Every variable of a model has a slot in a flat float64 array: parameters come first, then inputs, then outputs. The
value reference of a variable is its position in the array, so kernels, the pythonfmu slave and the modelDescription all
use the same table. Kernels see the array as records, whose fields follow from the table (`records`).
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, get_args

LARGEST = sys.float_info.max
FAULT_CODE = "fault_code"  # name of the last output of every model
TOOL = "amb-cosim"  # whose annotations in a modelDescription contain warnings and rules over a step

Causality = Literal["parameter", "input", "output"]
Type = Literal["Real", "Integer", "Boolean"]
OverStep = Literal["end", "largest", "sum", "mean"]
ORDER: tuple[Causality, ...] = get_args(Causality)  # of the variables in a table


class Array(NamedTuple):
    """The array that numbered variables form in FMI 3.0; `repeated` gives its shape."""

    name: str
    description: str
    shape: tuple[int, ...] = ()


@dataclass(frozen=True)
class Enumeration:
    """Values of a switch or a status: the numbers 0, 1, 2 and so on, each with a name and a description.

    `name` is the name of the type in a modelDescription, capitalised like the name of a class.
    """

    name: str
    items: tuple[tuple[str, str], ...]

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self.items)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Descriptions of the values; a value without a description is described by its name."""
        return tuple(description or name for name, description in self.items)

    def in_words(self) -> str:
        """All numbers with their names and descriptions, in a single line."""
        values = (f"{k} {name}{what and f': {what}'}" for k, (name, what) in enumerate(self.items))
        return "; ".join(values)


@dataclass(frozen=True)
class Variable:
    """An FMI variable. `unit` is an SI unit in FMI notation, such as `N.s/m`, or `1` if dimensionless.

    `depends_on` of an output lists the inputs that affect it without delay; in a co-simulation, connections to these
    may close an algebraic loop. `field` is the variable's name in the record that kernels read, such as
    `sites[2].clearance`, if it differs from `name`; see `records`.

    `array` is the array in FMI 3.0 that contains this variable and its neighbours.

    `initially_depends_on` of an output lists the parameters and inputs on which its value depends at initialisation,
    for the InitialUnknowns of FMI. An entry is the name of a variable, or a name such as `sites[*].clearance` for the
    variables of all `repeated` parts. If `initially_depends_on` is None, the output may depend on all parameters and
    inputs. `initially_equals` names the parameter or input whose value the output takes at initialisation. Both options
    describe a successful initialisation.

    `display_unit` of a Real overrides the usual display unit for its unit (`building.units.DISPLAYED`). `enumeration`
    names the values of an Integer; see `enumerated`.

    `warning` makes a Boolean output a warning, and is the text that is logged when the output becomes true. In the
    text, `{name}` is replaced by the value of that variable.

    `over_step` says how an output summarises a step: by the value at its end, or by the largest value, the sum or the
    mean over the step.
    """

    name: str
    causality: Causality
    unit: str
    description: str
    start: float = 0.0
    minimum: float = -LARGEST
    maximum: float = LARGEST
    type: Type = "Real"
    tunable: bool = False
    depends_on: tuple[str, ...] = ()
    initially_depends_on: tuple[str, ...] | None = None
    initially_equals: str = ""
    field: str = ""
    warning: str = ""
    over_step: OverStep = "end"
    enumeration: Enumeration | None = None
    display_unit: str = ""
    array: Array | None = None

    def __post_init__(self) -> None:
        if not self.minimum <= self.start <= self.maximum:
            raise ValueError(f"start of {self.describe_range(self.start)}")
        if self.enumeration and (self.type, self.minimum, self.maximum) != (
            "Integer",
            0,
            len(self.enumeration.items) - 1,
        ):
            raise ValueError(
                f"{self.name} must be an Integer from the first to the last value of "
                f"{self.enumeration.name}; see `enumerated`"
            )
        if self.warning and (self.causality, self.type) != ("output", "Boolean"):
            raise ValueError(f"{self.name} cannot be a warning; only a Boolean output can")

    @property
    def variability(self) -> str:
        if self.causality == "parameter":
            return "tunable" if self.tunable else "fixed"
        return "continuous" if self.type == "Real" else "discrete"

    def literal(self, value: float, real: str = "") -> str:
        """Return `value` as text of the variable's type; `real` is the format of a Real, by default with all digits."""
        if self.type == "Boolean":
            return "true" if value else "false"
        return str(int(value)) if self.type == "Integer" else f"{float(value):{real}}"

    def describe_range(self, value: float) -> str:
        """Return the message for a value that is not allowed: name, value, unit and allowed range."""
        if self.enumeration:
            names = ", ".join(f"{k} ({name})" for k, name in enumerate(self.enumeration.names))
            return f"{self.name} = {value:g} is not allowed; it must be one of {names}"
        unit = "" if self.unit == "1" else f" {self.unit}"
        low = f">= {self.minimum:g}" if self.minimum > -LARGEST else ""
        high = f"<= {self.maximum:g}" if self.maximum < LARGEST else ""
        bounds = " and ".join(bound for bound in (low, high) if bound)
        allowed = f"{bounds}{unit}" if bounds else "a finite number"
        return f"{self.name} = {value:g}{unit} is not allowed; it must be {allowed}"


def enumerated(enumeration: Enumeration) -> dict[str, Any]:
    """Return the options that declare a variable with the values of an enumeration."""
    return {"type": "Integer", "minimum": 0, "maximum": len(enumeration.items) - 1, "enumeration": enumeration}


def named_in(sentence: str) -> list[str]:
    """Return the names of the variables that a text contains in the form `{name}`."""
    return re.findall(r"\{([^}]+)\}", sentence)


def filled(sentence: str, value: Callable[[str], float]) -> str:
    """Return a text in which values replace the names of variables."""
    return re.sub(r"\{([^}]+)\}", lambda match: f"{value(match[1]):g}", sentence)


def parameter(name: str, unit: str, description: str, start: float, **options: object) -> Variable:
    """Declare a parameter; see `Variable` for the options."""
    return Variable(name, "parameter", unit, description, start, **options)  # type: ignore[arg-type]


def input_(name: str, unit: str, description: str, **options: object) -> Variable:
    """Declare an input; see `Variable` for the options."""
    return Variable(name, "input", unit, description, **options)  # type: ignore[arg-type]


def output(name: str, unit: str, description: str, **options: object) -> Variable:
    """Declare an output; see `Variable` for the options."""
    return Variable(name, "output", unit, description, **options)  # type: ignore[arg-type]


FAULT = output(
    FAULT_CODE,
    "1",
    "Code of the fault that stopped the model, explained in the log, or 0 without a fault",
    type="Integer",
    initially_depends_on=(),
)


def at_place(pattern: str, place: str) -> tuple[Callable[..., Variable], ...]:
    """Return variants of `parameter`, `input_` and `output` for variables of one component, such as a bearing axis.

    The names of the variables are the declared names, inserted into a `pattern` such as `left.{}_x`. By default,
    `field` is the declared name. In a description, `{}` is replaced by `place`.
    """

    def of_place(declare: Callable[..., Variable]) -> Callable[..., Variable]:
        def declared(name: str, unit: str, description: str, *start: float, **options: object) -> Variable:
            placed = {"field": name} | options
            return declare(pattern.format(name), unit, description.format(place), *start, **placed)

        return declared

    return of_place(parameter), of_place(input_), of_place(output)
