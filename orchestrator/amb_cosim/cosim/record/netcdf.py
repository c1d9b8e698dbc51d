"""NetCDF files of recorded signals, written by h5py: for hundreds of variables, xarray's writer is much slower.

A NetCDF-4 file is an HDF5 file in which dimensions are dimension scales, and names and attributes keep their order.
Files are created in memory, because HDF5 ends the process if a disk is full. All content has a checksum, so a flipped
bit causes an error on reading. However, HDF5 provides no checksum for the lists of chunks, and from a damaged list it
reads zeros or never returns. Therefore a CRC-32 of the file follows in four bytes after its end, which HDF5 ignores.

HDF5 would read a slash in a name as part of a path. A name such as `one.p/q` is therefore stored with another character
in place of the slash, and the original name is stored as an attribute.
"""

from __future__ import annotations

import errno
import os
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from amb_cosim.cosim.processes.interruption import undivided
from amb_cosim.cosim.record.signals import SignalTable

with undivided():  # objects of HDF5 that an exception leaves half-made cannot be cleared away
    import h5py

if TYPE_CHECKING:
    import xarray as xr

CHECKED = {"fletcher32": True}
COMPRESSION = {"compression": "gzip", "compression_opts": 4, "shuffle": True, **CHECKED}
NAME, DIVISION = "original_name", "\N{DIVISION SLASH}"  # attribute of a variable, and the sign in place of a slash
BLOCK = 1 << 24  # bytes that are read at once
MARGIN = 1.25  # memory for a file that cannot be compressed, over the size of its signals
WITH_CHECKSUMS = ("v108", "v108")  # the format of HDF5 1.8, whose descriptions have checksums too


def netcdf(signals: SignalTable | xr.Dataset) -> bytes:
    """Return the compressed content of a NetCDF-4 file of signals, followed by its checksum.

    Raises
    ------
    OSError
        If memory does not suffice for the file. If HDF5 itself runs out of memory, it ends the process.
    """
    groups = (signals.variables, signals.coordinates) if isinstance(signals, SignalTable) else (signals.variables,)
    size = sum(variable.values.nbytes for group in groups for variable in group.values())
    try:
        np.empty(round(MARGIN * size) + BLOCK, np.uint8)  # which is not written to, and freed at once
        with undivided():
            content = _of_table(signals) if isinstance(signals, SignalTable) else _of_dataset(signals)
        return content + zlib.crc32(content).to_bytes(4, "little")
    except MemoryError as error:
        raise OSError(errno.ENOMEM, f"{os.strerror(errno.ENOMEM)}: a record of {size / 1e6:.3g} MB") from error


def stored_names(names: Iterable[str]) -> dict[str, str]:
    """Map each name that contains a slash to its name in the file."""
    taken, result = set(names), {}
    for name in sorted(taken):
        if "/" in name:
            place = name.replace("/", DIVISION)
            while place in taken:
                place += "_"
            taken.add(place)
            result[name] = place
    return result


def with_own_names(dataset: xr.Dataset) -> xr.Dataset:
    """Return the data set of a file with its variables' original names; raises ValueError if two names are equal."""
    names = {name: variable.attrs[NAME] for name, variable in dataset.data_vars.items() if NAME in variable.attrs}
    for name in names:
        if not isinstance(names[name], str):
            raise ValueError(f"{NAME} of {name} is not allowed; it must be text")
        del dataset[name].attrs[NAME]
    return dataset.rename(names)


def check(path: Path) -> None:
    """Raise ValueError if bytes after the end of a NetCDF-4 file are not its checksum; other programs add no bytes."""
    with path.open("rb") as file:
        begin = file.read(36)
        if begin[8:9] not in (b"\2", b"\3"):  # earlier formats, which 0.2.0 wrote, store the length elsewhere
            return
        remaining = int.from_bytes(begin[28:36], "little")
        file.seek(0)
        crc = 0
        while remaining > 0 and (part := file.read(min(remaining, BLOCK))):
            crc, remaining = zlib.crc32(part, crc), remaining - len(part)
        stored = file.read()
    if remaining > 0 or stored not in (b"", crc.to_bytes(4, "little")):
        raise ValueError("its checksum does not match its content")


def _of_table(table: SignalTable) -> bytes:
    scales = [name for name, variable in table.coordinates.items() if name == variable.over]
    others = " ".join(name for name in table.coordinates if name not in scales)
    with h5py.File("signals", "w", driver="core", backing_store=False, track_order=True, libver=WITH_CHECKSUMS) as file:
        file.attrs.update(table.attrs)
        for name in scales:
            times = table[name].values
            scale = file.create_dataset(name, data=times, track_order=True, **(CHECKED if len(times) else {}))
            scale.make_scale(name)
            scale.attrs.update(table[name].attrs)
        stored = stored_names(table.variables)
        for name, variable in {**table.variables, **table.coordinates}.items():
            if name in scales:
                continue
            is_data = name in table.variables
            filters = (COMPRESSION if is_data else CHECKED) if len(variable.values) else {}
            place = stored.get(name, name)
            variable_data = file.create_dataset(place, data=variable.values, track_order=True, **filters)
            variable_data.dims[0].attach_scale(file[variable.over])
            variable_data.attrs.update(variable.attrs if place == name else {**variable.attrs, NAME: name})
            if is_data and others and variable.over == "time":
                variable_data.attrs["coordinates"] = others
        file.flush()
        return bytes(file.id.get_file_image())


def _of_dataset(dataset: xr.Dataset) -> bytes:
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    stored = stored_names(map(str, dataset.variables))
    dataset = dataset.assign({name: dataset[name].assign_attrs({NAME: name}) for name in stored}).rename(stored)
    filters = {"zlib": True, "complevel": 4, "shuffle": True}
    checked = {name: CHECKED for name, variable in dataset.variables.items() if variable.size}
    encoding = checked | {name: {**filters, **checked.get(name, {})} for name in dataset.data_vars}
    with h5netcdf.File("signals", "w", driver="core", backing_store=False, libver=WITH_CHECKSUMS) as file:
        dataset.dump_to_store(H5NetCDFStore(file), encoding=encoding)
        file.flush()
        file._h5file.flush()  # which h5netcdf does not do
        return bytes(file._h5file.id.get_file_image())
