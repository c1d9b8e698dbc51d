"""NetCDF files of recorded signals, by h5py: hundreds of small variables take xarray's writer several times as long.

A NetCDF-4 file is an HDF5 file in which dimensions are dimension scales, and names and attributes keep their order.
Files are made in memory: HDF5 ends the process where a disk is full.
"""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

import h5py

from amb_cosim.cosim.signals import SignalTable

if TYPE_CHECKING:
    import xarray as xr

COMPRESSION = {"compression": "gzip", "compression_opts": 4, "shuffle": True}


def netcdf(signals: SignalTable | xr.Dataset) -> bytes:
    """Return the content of a NetCDF-4 file of signals, compressed."""
    return _of_table(signals) if isinstance(signals, SignalTable) else _of_dataset(signals)


def _of_table(table: SignalTable) -> bytes:
    others = " ".join(name for name in table.coordinates if name != "time")
    with h5py.File("signals", "w", driver="core", backing_store=False, track_order=True) as file:
        file.attrs.update(table.attrs)
        time = file.create_dataset("time", data=table["time"].values, track_order=True)
        time.make_scale("time")
        time.attrs.update(table["time"].attrs)
        for name, variable in {**table.variables, **table.coordinates}.items():
            if name == "time":
                continue
            is_data = name in table.variables
            packed = COMPRESSION if is_data and len(variable.values) else {}
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
    encoding = {name: {"zlib": True, "complevel": 4, "shuffle": True} for name in dataset.data_vars}
    with h5netcdf.File(content, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file), encoding=encoding)
    return content.getvalue()
