"""Values as users pass them: numbers of Python and numpy, arrays with one number, texts and quantities of pint."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, SupportsFloat

Plain = bool | int | float | str
Raw = str | SupportsFloat
"""A number, numpy scalar or array of shape (), a text with a unit (`"16 Hz"`), or a quantity of pint."""


def plain_value(value: object, name: str) -> Plain:
    """Return a user's value as a Boolean, a number of Python, or a text with a unit.

    A quantity of pint is read as its text, so that 50 Hz of pint are the speed that `"50 Hz"` is.

    Parameters
    ----------
    value
        A Boolean, a number, a text, a numpy scalar, an array or xarray of shape (), or a quantity of any pint registry.
    name
        Name of the argument, for messages.

    Raises
    ------
    ValueError
        If it is a list, an array of several numbers, a complex number, or another object.

    Examples
    --------
    >>> import numpy as np
    >>> plain_value(np.int64(200), "Omega"), plain_value(np.array(0.5), "until")
    (200, 0.5)
    """
    if isinstance(value, bool | int | float | str):
        return value if type(value) in (bool, int, float, str) else _basic(value)
    if hasattr(value, "magnitude") and hasattr(value, "units"):
        number = plain_value(value.magnitude, name)
        return f"{number!r} {value.units:~C}".rstrip()
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        item = value.item()
        if isinstance(item, bool | int | float | str):
            return item
    elif isinstance(value, SupportsFloat) and not hasattr(value, "shape"):  # a fraction or decimal number
        return float(value)
    raise ValueError(
        f"{name} = {_shown(value)} is not allowed; it must be a number, a text with a unit, or a quantity of pint"
    )


def plain_values(values: Mapping[str, Raw] | None, name: str) -> dict[str, Plain]:
    """Return the values of a table by their names, as `plain_value` returns each; the argument `name` has the table.

    Raises
    ------
    ValueError
        If it is not a table, a key is not a text, or a value is not allowed.
    """
    if not isinstance(values, Mapping | None):
        raise ValueError(f"{name} = {_shown(values)} is not allowed; it must be a table, such as {{'Omega': '60 Hz'}}")
    for key in values or ():
        if not isinstance(key, str):
            raise ValueError(f"{name}: the key {_shown(key)} is not allowed; it must be a name")
    return {key: plain_value(value, key) for key, value in (values or {}).items()}


def listed(values: Any) -> list[Any]:
    """Return the elements of a sequence, an array or an array quantity of pint, or a list of the single value."""
    numbers = getattr(values, "magnitude", values)
    is_single = isinstance(numbers, str) or not isinstance(numbers, Iterable) or getattr(numbers, "shape", None) == ()
    return [values] if is_single else [*values]


def _basic(value: Any) -> Plain:
    """Return a value of a derived class, such as numpy's float64, as its class of Python."""
    kind = next(kind for kind in (bool, int, float, str) if isinstance(value, kind))
    return kind(value)


def _shown(value: object) -> str:
    """Return a value in one short line."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
