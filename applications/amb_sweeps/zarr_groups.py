"""Groups of Zarr arrays whose chunks have checksums, which detect damage by a disk or a copy.

The checksum is of the compressed bytes, so damaged data are never unpacked. Empty chunks are written too; a missing
chunk is therefore an error.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from amb_files.atomic import write_file

if TYPE_CHECKING:
    import xarray as xr

INDEX = ".zmetadata"  # the file with all metadata
CHECKSUM = "crc32"  # a codec of numcodecs
EVERY_CHUNK = {"array.write_empty_chunks": True}  # Zarr's configuration while arrays are created or opened
LONGEST = 400  # most characters of an error


def write_group(dataset: xr.Dataset, folder: Path, chunks: Mapping[Any, Any] | None = None) -> Path:
    """Write a data set as a group and return its folder; `chunks` are the shapes of the chunks of arrays."""
    import zarr
    from numcodecs import CRC32, VLenUTF8, Zstd

    encoding: dict[Any, dict[str, Any]] = {}
    for name, variable in dataset.variables.items():
        texts = [VLenUTF8()] if variable.dtype == object else []
        encoding[name] = {"filters": [*texts, Zstd(), CRC32()], "compressors": None}
    for name, shape in (chunks or {}).items():
        encoding[name]["chunks"] = shape
    with zarr.config.set(EVERY_CHUNK):
        dataset.to_zarr(folder, mode="w", encoding=encoding, zarr_format=2, consolidated=False)
    return folder


def read_group(path: Path, group: str = "") -> xr.Dataset:
    """Read a group of a store into memory.

    Raises
    ------
    ValueError
        If any part is damaged or missing; the message names it.
    """
    import xarray as xr

    where = path.name
    try:
        _check_descriptions(path)
        with xr.open_zarr(path, group=group or None, consolidated=False, chunks=None) as dataset:
            for name, variable in dataset.variables.items():
                where = f"{path.name}/{group and group + '/'}{name}"
                _check_chunks(path / group / str(name))
                variable.load()
            return dataset.load()
    except Exception as error:  # errors of Zarr, its codecs, xarray and the system differ
        raise ValueError(f"the sweep in {path.parent} is damaged, {where}: {_reason(error)}") from error


def consolidate(path: Path) -> None:
    """Write the metadata of all groups and arrays of a store into one file, which xarray reads.

    Raises
    ------
    ValueError
        If metadata are damaged.
    """
    import zarr

    try:
        zarr.consolidate_metadata(path, zarr_format=2)
    except Exception as error:  # Zarr has many errors
        raise ValueError(f"the sweep in {path.parent} is damaged, {path.name}: {_reason(error)}") from error


def forget_group(path: Path, group: str) -> None:
    """Remove the metadata of a group from the file with all metadata, before the group is replaced."""
    index = json.loads((path / INDEX).read_bytes())
    index["metadata"] = {name: item for name, item in index["metadata"].items() if not name.startswith(f"{group}/")}
    write_file(path / INDEX, json.dumps(index))


def _check_descriptions(path: Path) -> None:
    """Raise ValueError if the metadata file of a group or an array differs from the store's."""
    for name, content in json.loads((path / INDEX).read_bytes())["metadata"].items():
        expected = (
            {"zarr_format": 2} if name.endswith(".zgroup") else content
        )  # for groups Zarr writes more into the index
        if json.loads((path / name).read_bytes()) != expected:
            raise ValueError(f"{name} and {INDEX} differ")


def _check_chunks(folder: Path) -> None:
    """Raise ValueError if an array lacks a chunk; arrays of 0.2.0, without checksums, may lack chunks."""
    import zarr

    array: Any = zarr.open_array(folder, mode="r", zarr_format=2)
    checked = any(codec.codec_id == CHECKSUM for codec in array.metadata.filters or ())
    if checked and array.nchunks_initialized < array.nchunks:
        raise ValueError(f"{array.nchunks - array.nchunks_initialized} of its {array.nchunks} chunks are missing")


def _reason(error: Exception) -> str:
    """Return the first line of an error."""
    return (str(error).strip() or type(error).__name__).splitlines()[0][:LONGEST]
