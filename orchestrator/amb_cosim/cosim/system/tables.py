"""Common parts of the TOML files of co-simulations: strict tables, values with units, times."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Annotated, Any, Literal, cast

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
)
from pydantic_core import CoreSchema, PydanticKnownError
from pydantic_core.core_schema import no_info_before_validator_function

from amb_cosim.cosim.system.values import Raw, plain_value, quantity, stated
from amb_files.frozen_table import FrozenTable
from amb_files.validation_errors import Allowed


def _plain(value: object) -> object:
    """Return a user's value as a value of TOML; anything else is left to the checks of the table."""
    with suppress(ValueError):
        return plain_value(value, "value")
    return value


Value = Annotated[
    StrictBool | StrictInt | StrictFloat | StrictStr,
    Field(union_mode="smart"),
    Allowed("a number, true, false, or a string with a unit"),
    BeforeValidator(_plain),
]
Values = Annotated[dict[str, Value], AfterValidator(FrozenTable)]
ByComponent = Annotated[dict[str, Values], AfterValidator(FrozenTable)]
Cycles = Annotated[float, Field(ge=-1e9, le=1e9)]
Count = Annotated[int, Field(ge=1, le=10**12)]

MOST_BASES = 20  # files of which each is the base of the next


_MESSAGES: dict[str, Literal["float_type", "int_type"]] = {"float": "float_type", "int": "int_type"}  # by schema
_NO_SCHEMAS = ("metadata", "default", "serialization", "expected")  # keys of a schema whose values are none


def _without_truth_values(part: Any) -> Any:
    """Return a part of a schema that refuses `true` and `false` as numbers, because pydantic reads them as 1 and 0."""
    if isinstance(part, list | tuple):
        return type(part)(_without_truth_values(each) for each in part)
    if not isinstance(part, dict):
        return part
    kind = part.get("type")
    skipped = _NO_SCHEMAS if isinstance(kind, str) else ()  # otherwise these are fields, by their names
    schema = {key: value if key in skipped else _without_truth_values(value) for key, value in part.items()}
    if kind not in ("float", "int"):
        return schema

    def check(value: Any) -> Any:
        if isinstance(value, bool):
            raise PydanticKnownError(_MESSAGES[kind])
        return value

    return no_info_before_validator_function(check, cast(CoreSchema, schema))


class Table(BaseModel):
    """An immutable TOML table that refuses unknown keys, and `true` and `false` in place of numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, validate_by_name=True, validate_by_alias=True)

    def __setattr__(self, name: str, value: Any) -> None:
        """Refuse a change, in a sentence instead of pydantic's."""
        kind = type(self).__name__
        raise AttributeError(f"{kind} is immutable: {name} cannot be changed; make a changed copy instead")

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        schema: CoreSchema = _without_truth_values(handler(source))
        return schema


def check_bases(name: str, derived: tuple[str, ...]) -> None:
    """Raise ValueError if a file is its own base, or if the chain of bases is too long.

    Parameters
    ----------
    name
        Kind and name of the file in messages.
    derived
        Names of the files that are derived from this file, in the order in which they were read.
    """
    file = name.partition(" ")[2]
    if file in derived:
        raise ValueError(f"{name}: the file is its own base ({' -> '.join((*derived, file))})")
    if len(derived) > MOST_BASES:
        raise ValueError(f"{name} is not allowed as a base: a file must have <= {MOST_BASES} bases in a chain")


def time_of(raw: Raw, name: str, least: float | None = None, most: float = math.inf) -> float:
    """Convert a time to s; it must be above 0, unless `least` or `most` (s) set another range.

    Raises
    ------
    ValueError
        If it is not a time, or is outside the range; the message begins with `name`.
    """
    value = quantity(raw, "s", name)
    shown = stated(f"{value:g} s", raw)
    if most < math.inf:
        if not -math.inf < value <= most:
            raise ValueError(f"{name} = {shown} is not allowed; it must be <= {most:g} s")
    elif least is not None:
        if not least <= value < math.inf:
            raise ValueError(f"{name} = {shown} is not allowed; it must be >= {least:g} s")
    elif not 0.0 < value < math.inf:
        raise ValueError(f"{name} = {shown} is not allowed; it must be > 0 s")
    return value


def moment_of(raw: Raw, period: float | None, name: str = "moment") -> float:
    """Convert a time such as `cycle 5` (of `period` s) or `0.3 s` to s; it must be 0 or later.

    Raises
    ------
    ValueError
        If it is not a time, or is stated in cycles although there are none.
    """
    raw = plain_value(raw, name)
    word, _, number = str(raw).strip().partition(" ")
    if word != "cycle":
        return time_of(raw, name, least=0.0)
    if period is None:
        raise ValueError(f"{raw} is not allowed, because the run has no cycles; it must be a time, such as 0.3 s")
    cycle = quantity(number, "1", "moment in cycles")
    if not 0.0 <= cycle < math.inf:
        raise ValueError(f"a time at cycle {cycle:g} is not allowed; it must be 0 or later")
    return cycle * period
