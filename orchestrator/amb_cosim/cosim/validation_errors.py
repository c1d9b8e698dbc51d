"""What pydantic finds wrong with a scenario, in one sentence each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import BaseModel, ValidationError

from amb_cosim.cosim.interface import suggest

_UNION = ("bool", "int", "float", "str")  # members of a union, which pydantic adds to the place of a mistake


def mistakes(error: ValidationError, model: type[BaseModel], nested: Mapping[str, type[BaseModel]]) -> list[str]:
    """A sentence for each mistake: its place, the value, what is allowed.

    Parameters
    ----------
    error
        What the validation of `model` raised.
    nested
        The models of its tables by their names, to suggest fields from.
    """
    # One for each place; a union would report one for each of its members.
    unique = list({_place(e["loc"]): e for e in reversed(error.errors())}.values())[::-1]
    return [_sentence(dict(e), model, nested) for e in unique]


def _place(location: Sequence[int | str]) -> str:
    return ".".join(str(part) for part in location if part not in _UNION)


def _sentence(error: dict[str, Any], model: type[BaseModel], nested: Mapping[str, type[BaseModel]]) -> str:
    place, kind, given = _place(error["loc"]), error["type"], error["input"]
    if kind == "extra_forbidden":
        fields = list(nested.get(place.split(".")[0], model).model_fields)
        return f"unknown field {place}; {suggest(place.rpartition('.')[2], fields)}"
    if kind == "missing":
        return f"{place} is missing"
    shown = repr(given) if isinstance(given, str | int | float) else type(given).__name__
    if any(part in _UNION for part in error["loc"]):
        return f"{place} = {shown} is not allowed; it must be a number, true, false, or a string with a unit"
    message = str(error["msg"]).replace("Input should be", "it must be").replace("valid ", "").replace("tuple", "list")
    return f"{place} = {shown} is not allowed; {message}"
