"""NetCDF files of recorded signals, by h5py: hundreds of small variables take xarray's writer several times as long.

A NetCDF-4 file is an HDF5 file in which dimensions are dimension scales, and names and attributes keep their order.
Files are made in memory: HDF5 ends the process where a disk is full. All that is in them has a checksum: a bit that a
disk or a copy has turned is an error when they are read.
"""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

import h5py

from amb_cosim.cosim.signals import SignalTable

if TYPE_CHECKING:
    import xarray as xr

CHECKED = {"fletcher32": True}
COMPRESSION = {"compression": "gzip", "compression_opts": 4, "shuffle": True, **CHECKED}
WITH_CHECKSUMS = ("v108", "v108")  # the format of HDF5 1.8, whose descriptions have checksums too


def netcdf(signals: SignalTable | xr.Dataset) -> bytes:
    """Return the content of a NetCDF-4 file of signals, compressed."""
    return _of_table(signals) if isinstance(signals, SignalTable) else _of_dataset(signals)


def _of_table(table: SignalTable) -> bytes:
    others = " ".join(name for name in table.coordinates if name != "time")
    with h5py.File("signals", "w", driver="core", backing_store=False, track_order=True, libver=WITH_CHECKSUMS) as file:
        file.attrs.update(table.attrs)
        times = table["time"].values
        time = file.create_dataset("time", data=times, track_order=True, **(CHECKED if len(times) else {}))
        time.make_scale("time")
        time.attrs.update(table["time"].attrs)
        for name, variable in {**table.variables, **table.coordinates}.items():
            if name == "time":
                continue
            is_data = name in table.variables
            packed = (COMPRESSION if is_data else CHECKED) if len(variable.values) else {}
            stored = file.create_dataset(name, data=variable.values, track_order=True, **packed)
            stored.dims[0].attach_scale(time)
            stored.attrs.update(variable.attrs)
            if is_data and others:
                stored.attrs["coordinates"] = others
        file.flush()
        return bytes(file.id.get_file_image())


def _of_dataset(dataset: xr.Dataset) -> bytes:
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    content = BytesIO()
    packed = {"zlib": True, "complevel": 4, "shuffle": True}
    checked = {name: CHECKED for name, variable in dataset.variables.items() if variable.size}
    encoding = checked | {name: {**packed, **checked.get(name, {})} for name in dataset.data_vars}
    with h5netcdf.File(content, "w", libver=WITH_CHECKSUMS) as file:
        dataset.dump_to_store(H5NetCDFStore(file), encoding=encoding)
    return content.getvalue()
