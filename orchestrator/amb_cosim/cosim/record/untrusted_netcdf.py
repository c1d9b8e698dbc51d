"""Checks a NetCDF file from elsewhere before it is read: all its data must lie in this file and fit into it.

HDF5 follows links to other files and reads data stored there, so bytes of these files would appear in tables and
figures. HDF5 also allocates as much memory as a file announces, even for chunks that are not stored, chunks that
several arrays share, and chunks that are compressed twice. A byte of DEFLATE stands for at most 1032 bytes (two bits
for 258), so all data together have at most 1032 times the size of the file.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.processes.interruption import undivided

with undivided():
    import h5py

MOST_INFLATED = 1032  # bytes that a byte of DEFLATE stands for
FILTERS = {  # those of `netcdf`, each at most once
    h5py.h5z.FILTER_DEFLATE: "deflate",
    h5py.h5z.FILTER_SHUFFLE: "shuffle",
    h5py.h5z.FILTER_FLETCHER32: "fletcher32",
}
MOST_UNLIMITED = 100  # arrays; NetCDF knows no others without values, and their readers search all of them for each
NUMBERS = "fiu"  # kinds of the types of arrays
PLAIN = (h5py.h5t.INTEGER, h5py.h5t.FLOAT, h5py.h5t.ENUM, h5py.h5t.STRING)  # classes of attributes
TEXTS = ("CLASS", "NAME", "coordinates")  # attributes that readers take for texts without a check
CODED = ("missing_value", "scale_factor", "add_offset", "_Unsigned", "dtype", "_nc3_strict")
DIMENSIONS, REFERENCES = "DIMENSION_LIST", "REFERENCE_LIST"  # attributes that refer to arrays, of other classes


def check_content(path: Path) -> None:
    """Raise ValueError if an object of a NetCDF-4 file lies in another file, or has more data than the file can hold.

    The file may contain only what `netcdf` writes: one-dimensional arrays of numbers, and attributes that are numbers
    or single texts. Arrays are contiguous, or in chunks with the filters in `FILTERS`. Attributes that define an
    encoding of numbers (`CODED`) are not allowed.
    """
    size, stored, described, unlimited = path.stat().st_size, 0, 0, 0
    with h5py.File(path) as file:
        for item in _objects(file):
            if isinstance(item, h5py.Dataset):
                stored += _stored(item)
                unlimited += item.maxshape == (None,)
            if unlimited > MOST_UNLIMITED:
                raise ValueError(f"{item.name} and {MOST_UNLIMITED} other arrays lack a fixed length or values")
            described += _described(item)
            if stored + described > size:
                raise ValueError(f"{item.name} and the data before it take more bytes than the file has ({size})")


def _objects(file: Any) -> Iterator[Any]:
    """Yield all groups and arrays of a file; raises ValueError for a link, or for a second name of the same data."""
    groups, seen = [file], set()
    yield file
    while groups:
        group = groups.pop()
        for name in group:
            where = f"{group.name.rstrip('/')}/{name}"
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise ValueError(f"{where} is a link, which is not allowed; data must be in the file itself")
            item = group[name]
            if (address := h5py.h5o.get_info(item.id).addr) in seen:
                raise ValueError(f"{where} is a second name of the same data, which is not allowed")
            seen.add(address)
            if isinstance(item, h5py.Group):
                groups.append(item)
            if isinstance(item, h5py.Group | h5py.Dataset):
                yield item


def _stored(array: Any) -> int:
    """Return the number of bytes that an array occupies in the file; raises ValueError if its values cannot fit."""
    if array.ndim != 1 or array.shape is None:
        raise ValueError(f"{array.name} has the shape {array.shape}, which is not allowed; it must have one dimension")
    if other := [size for size in _sizes_of_dimension(array) if size != array.size]:  # readers fill up what is missing
        raise ValueError(f"{array.name} has {array.size} values, which is not allowed; it must have {other[0]}")
    created = array.id.get_create_plist()
    if created.get_external_count() or created.get_layout() == h5py.h5d.VIRTUAL:
        raise ValueError(f"{array.name} is in another file, which is not allowed")
    if array.dtype.kind not in NUMBERS:
        raise ValueError(f"{array.name} has the type {array.dtype}, which is not allowed; it must be numeric")
    filters = [created.get_filter(k)[0] for k in range(created.get_nfilters())]
    if not set(filters) <= FILTERS.keys() or len(set(filters)) < len(filters):
        raise ValueError(
            f"{array.name} has filters other than {', '.join(FILTERS.values())}, or uses one of them twice"
        )
    stored = int(array.id.get_storage_size())
    if not array.size:
        return stored
    chunk = array.chunks or array.shape
    announced = array.dtype.itemsize * math.prod(-(-n // m) * m for n, m in zip(array.shape, chunk, strict=True))
    if announced > stored * (MOST_INFLATED if array.chunks else 1):
        raise ValueError(
            f"{array.name} declares {announced} bytes of data, more than its {stored} bytes in the file can hold"
        )
    return stored


def _sizes_of_dimension(array: Any) -> list[int]:
    """Return the sizes of the arrays that an array uses as its dimension, or nothing if the reference is broken."""
    try:
        return [scale.size for scale in array.dims[0].values() if scale.ndim == 1]
    except (RuntimeError, ValueError, TypeError, KeyError):
        return []


def _described(item: Any) -> int:
    """Return the number of bytes of an object's attributes; raises ValueError unless they are numbers or texts."""
    described = 0
    for name in item.attrs:
        if name in CODED:
            raise ValueError(
                f"{item.name} has the attribute {name}, which is not allowed; numbers must be stored without encoding"
            )
        attribute = h5py.h5a.open(item.id, name.encode())
        kind, values = attribute.get_type(), math.prod(attribute.shape)
        described += values * kind.get_size()
        if name == DIMENSIONS and values <= getattr(item, "ndim", 0):
            continue
        if name == REFERENCES and not kind.detect_class(h5py.h5t.VLEN):
            continue
        if kind.get_class() not in PLAIN:
            raise ValueError(f"the attribute {name} of {item.name} is neither a number nor text")
        if kind.get_class() == h5py.h5t.STRING and kind.is_variable_str():
            if values > 1:
                raise ValueError(f"the attribute {name} of {item.name} has {values} texts; only one is allowed")
            described += len(str(item.attrs[name]))
        if name == "_FillValue" and (values != 1 or np.dtype(kind.dtype).kind not in NUMBERS):
            raise ValueError(f"the attribute {name} of {item.name} is not allowed; it must be a number")
        if name in TEXTS and kind.get_class() != h5py.h5t.STRING:
            raise ValueError(f"the attribute {name} of {item.name} is not allowed; it must be text")
    return described
