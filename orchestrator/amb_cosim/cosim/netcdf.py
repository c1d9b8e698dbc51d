"""NetCDF files of recorded signals, by h5py: hundreds of small variables take xarray's writer several times as long.

A NetCDF-4 file is an HDF5 file in which dimensions are dimension scales, and names and attributes keep their order.
"""

from __future__ import annotations

from pathlib import Path

import h5py

from amb_cosim.cosim.signals import SignalTable

COMPRESSION = {"compression": "gzip", "compression_opts": 4, "shuffle": True}


def write_netcdf(table: SignalTable, path: Path) -> None:
    """Write signals as a NetCDF-4 file, compressed, with the dimension `time`."""
    others = " ".join(name for name in table.coordinates if name != "time")
    with h5py.File(path, "w", track_order=True) as file:
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
