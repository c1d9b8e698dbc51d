"""Tables of immutable records."""

from __future__ import annotations

from typing import Any, NoReturn, TypeVar

K = TypeVar("K")
V = TypeVar("V")


class FrozenTable(dict[K, V]):
    """A dict that cannot be changed and has a hash; `|` and `copy` return a dict that can.

    Examples
    --------
    >>> table = FrozenTable(a=1)
    >>> table["a"] = 2
    Traceback (most recent call last):
    TypeError: this table belongs to an immutable record; make a changed copy of the record instead
    >>> table | {"a": 2}
    {'a': 2}
    """

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("this table belongs to an immutable record; make a changed copy of the record instead")

    __setitem__ = __delitem__ = clear = pop = popitem = setdefault = update = _refuse
    __ior__ = _refuse

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(frozenset(self.items()))

    def __reduce__(self) -> tuple[Any, ...]:
        return FrozenTable, (dict(self),)
