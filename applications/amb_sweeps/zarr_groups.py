"""Groups of Zarr arrays whose chunks have checksums, which detect damage by a disk or a copy.

The checksum is computed from the compressed bytes, so damaged data are never unpacked. The groups have Zarr format 2
with its checksum codec. Format 3 also has a checksum codec, but does not specify an index of all metadata. Zarr reads a
missing chunk as an empty one. Empty chunks are therefore also written, and a missing chunk is an error.

A store from elsewhere is not trusted: its chunks must be files of the store, not links, and may only use the codecs
with which this package writes. A Zstandard block of 4 bytes expands to at most 128 KiB, so all arrays together have at
most 32768 times the size of their chunks.
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
CODECS = {"vlen-utf8", "zstd", CHECKSUM}
MOST_UNPACKED = 2**15  # bytes that a byte of Zstandard stands for
MOST_MISSING = 2**27  # bytes of the arrays of 0.2.0, which may lack chunks
LONGEST = 400  # most characters of an error


def write_group(dataset: xr.Dataset, folder: Path, chunks: Mapping[Any, Any] | None = None) -> Path:
    """Write a data set as a group and return the group's folder; `chunks` are the chunk shapes of the arrays."""
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
    # The unit `hours` of a varied value makes no times of its numbers.
    plain: Any = {"chunks": None, "decode_times": False, "decode_timedelta": False}
    try:
        _check_descriptions(path)
        with xr.open_zarr(path, group=group or None, consolidated=False, **plain) as dataset:
            announced, stored = 0, 0
            for name, variable in dataset.variables.items():
                where = f"{path.name}/{group and group + '/'}{name}"
                stored += _check_chunks(path / group / str(name))
                announced += variable.size * variable.dtype.itemsize
                if announced > max(MOST_UNPACKED * stored, MOST_MISSING):
                    raise ValueError(
                        f"it declares {announced} bytes of data, more than its {stored} bytes of chunks can hold"
                    )
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
    """Raise ValueError if the metadata file of a group or an array differs from the metadata of the whole store."""
    for name, content in json.loads((path / INDEX).read_bytes())["metadata"].items():
        expected = (
            {"zarr_format": 2} if name.endswith(".zgroup") else content
        )  # for groups Zarr writes more into the index
        if json.loads((path / name).read_bytes()) != expected:
            raise ValueError(f"{name} and {INDEX} differ")


def _check_chunks(folder: Path) -> int:
    """Return the total size of an array's chunks; raise ValueError for a missing chunk, a link or a forbidden codec.

    Arrays written by version 0.2.0 have no checksums and may lack chunks.
    """
    import zarr

    array: Any = zarr.open_array(folder, mode="r", zarr_format=2)
    codecs = [codec.codec_id for codec in (*(array.metadata.filters or ()), array.metadata.compressor) if codec]
    if not set(codecs) <= CODECS:
        raise ValueError(f"its codecs are {', '.join(codecs)}; they must be among {', '.join(sorted(CODECS))}")
    if CHECKSUM in codecs and array.nchunks_initialized < array.nchunks:
        raise ValueError(f"{array.nchunks - array.nchunks_initialized} of its {array.nchunks} chunks are missing")
    files = [file for file in folder.rglob("*") if not file.is_dir()]
    if links := [file.name for file in (folder, *files) if file.is_symlink()]:
        raise ValueError(f"{links[0]} is a link, which is not allowed; data must be in the store")
    return sum(file.stat().st_size for file in files)


def _reason(error: Exception) -> str:
    """Return the first line of an error."""
    return (str(error).strip() or type(error).__name__).splitlines()[0][:LONGEST]
