"""Record types of flat float64 arrays, made from the names of numbers: `Omega`, `energy.kinetic`, `sites[2].gap`.

A kernel views an array as a record, `p = parameters.view(PARAMETERS)[0]`, and reads `p.sites[2].gap` where the number
is stored, without copies or lookups at run time. In a name, a dot denotes a record within a record, and brackets denote
an array. Two adjacent numbers named `re` and `im` are one complex number.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import cast

import numpy as np

Index = tuple[int, ...]
Path = tuple[tuple[str, Index | None], ...]
Dtype = np.dtype[np.void]

_STEP = re.compile(r"([A-Za-z_]\w*)(?:\[(\d+(?:,\d+)*)\])?")
COMPLEX = ("re", "im")


def record(*fields: tuple[str, object] | tuple[str, object, Index | int]) -> np.dtype[np.record]:
    """Return a record type with these fields (name, type, shape), for the state or scratch memory of kernels."""
    return cast(np.dtype[np.record], np.dtype((np.record, list(fields))))


def size_of(dtype: np.dtype[np.record]) -> int:
    """Return how many float64 numbers a record contains."""
    return dtype.itemsize // 8


def record_of(places: Iterable[str]) -> np.dtype[np.record]:
    """Return the record type for consecutive numbers with these names.

    Raises
    ------
    ValueError
        If a name does not have the form described for the module, or if numbers of a record or array are not adjacent.
    """
    paths = [_parse(place) for place in places]
    dtype = _dtype(paths)
    for position, path in enumerate(paths):
        if _offset(dtype, path) != 8 * position:
            raise ValueError(f"{_text(path)} must be next to the other numbers of its record or array")
    if dtype.itemsize != 8 * len(paths):
        raise ValueError(f"{len(paths)} numbers do not fill their record; an array lacks one of its elements")
    return dtype


def _parse(place: str) -> Path:
    steps = [_STEP.fullmatch(step) for step in place.split(".")]
    if not all(steps):
        raise ValueError(f"{place!r} does not name a number of a record; write name, name.name or name[0,1].name")
    return tuple((s[1], tuple(int(i) for i in s[2].split(",")) if s[2] else None) for s in steps if s)


def _dtype(paths: list[Path]) -> np.dtype[np.record]:
    if paths == [()]:
        return np.dtype(np.float64)  # type: ignore[return-value]
    names = list(dict.fromkeys(path[0][0] for path in paths if path))
    if tuple(names) == COMPLEX and all(len(path) == 1 for path in paths):
        return np.dtype(np.complex128)  # type: ignore[return-value]
    return record(*(_field(name, [path for path in paths if path and path[0][0] == name]) for name in names))


def _field(name: str, paths: list[Path]) -> tuple[str, object] | tuple[str, object, Index]:
    elements: dict[Index | None, list[Path]] = {}
    for path in paths:
        elements.setdefault(path[0][1], []).append(path[1:])
    dtypes = [_dtype(rest) for rest in elements.values()]
    if None in elements:
        return name, dtypes[0]
    if any(dtype != dtypes[0] for dtype in dtypes):
        raise ValueError(f"the elements of {name} must have the same structure")
    return name, dtypes[0], tuple(int(n) + 1 for n in np.max(np.array(list(elements)), axis=0))


def _offset(dtype: Dtype, path: Path) -> int:
    """Return the offset (bytes) of a number in a record."""
    offset = 0
    for name, index in path:
        if dtype == np.complex128:
            return offset + 8 * COMPLEX.index(name)
        assert dtype.fields is not None
        dtype, start = dtype.fields[name][:2]
        offset += start
        if index is not None and dtype.subdtype is not None:
            dtype, shape = dtype.subdtype
            offset += dtype.itemsize * int(np.ravel_multi_index(index, shape))
    return offset


def _text(path: Path) -> str:
    return ".".join(name if index is None else f"{name}{list(index)}" for name, index in path)
