"""Checks of values, with messages that state the allowed values."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Hashable, Iterable, Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T", bound=Hashable)


def require(condition: bool, what: str, value: object, allowed: str) -> None:
    """Raise a ValueError unless `condition` holds; the message contains `what`, its value and the allowed values."""
    if not condition:
        raise ValueError(f"{what} = {value} is not allowed; it must be {allowed}")


def require_choice(name: str, value: object, choices: Collection[str] | Collection[int]) -> None:
    """Raise a ValueError unless the argument `name` is one of `choices`; the message lists them.

    Examples
    --------
    >>> require_choice("fmi", "3", (2, 3))
    Traceback (most recent call last):
    ValueError: fmi = '3' is not allowed; it must be 2 or 3
    """
    *others, last = (str(choice) for choice in choices)
    is_one = isinstance(value, Hashable) and value in {*choices}
    require(is_one, name, repr(value), f"{', '.join(others)} or {last}")


def as_path(name: str, value: object) -> Path:
    """Return the path that the argument `name` states; raise a ValueError if it is neither a text nor a path."""
    require(isinstance(value, str | PathLike), name, repr(value), "a name or a path")
    return Path(value)  # type: ignore[arg-type]


def require_kind(name: str, value: object, kind: type | tuple[type, ...], allowed: str) -> None:
    """Raise a ValueError unless the argument `name` has the type `kind`; the message describes what is `allowed`."""
    require(isinstance(value, kind), name, " ".join(repr(value).split())[:60], allowed)


def as_items(value: Any) -> tuple[Any, ...]:
    """Return the items of an argument that takes several; a text, a path, a number or any other single value is one.

    Examples
    --------
    >>> as_items("rotor_contact"), as_items(["rotor_contact", "amb_actuator"])
    (('rotor_contact',), ('rotor_contact', 'amb_actuator'))
    """
    if isinstance(value, str | PathLike):
        return (value,)
    try:
        return tuple(value)
    except TypeError:  # a number, also as an array or a quantity of pint
        return (value,)


def as_names(name: str, value: object) -> tuple[str, ...]:
    """Return the names that the argument `name` states: one text, or several.

    Raises
    ------
    ValueError
        If one of them is not a text.
    """
    names = as_items(value)
    for item in names:
        require_kind(name, item, str, "a text, or a list of texts")
    return names


def require_given(name: str, value: object) -> None:
    """Raise a ValueError if the argument `name`, which has no default, is None."""
    if value is None:
        raise ValueError(f"{name} = None is not allowed; this argument has no default")


def require_positive(record: object, **units: str) -> None:
    """Raise a ValueError unless each field of `record` named in `units` is finite and above zero."""
    for name, unit in units.items():
        value = getattr(record, name)
        require(0.0 < value < math.inf, name, f"{value:g} {unit}".rstrip(), f"> 0 {unit}".rstrip())


def repeated(names: Iterable[T]) -> list[T]:
    """Return the names that occur more than once, without repetition and in the order of first occurrence."""
    return [name for name, count in Counter(names).items() if count > 1]


def single_line(error: object) -> str:
    """Return the message of an error in a single line, or the error's type if it has no message."""
    return " ".join(str(error).split()) or type(error).__name__


@contextmanager
def errors_in(place: str) -> Iterator[None]:
    """Prepend `place`, if it is not empty, to the message of a ValueError raised within the context."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{place}: {error}" if place else str(error)) from error
