"""Reads files of named arrays: `.npz` of numpy, and `.mat` of Matlab (including 7.3), Octave, scipy and Julia."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from amb_files.checks import single_line

if TYPE_CHECKING:
    from numpy.typing import NDArray

MOST_SHOWN = 200  # characters of a reason
SUFFIXES = (".npz", ".mat")
MOST_BYTES = 2**28  # bytes of all arrays of a file: a law of 600 states at 90 speeds; an archive of 1 MB can hold 1 GB
MAT_SPACE, READ_TIME = 2**31, 120  # memory limit (bytes) and time limit (s) of the process that reads a .mat file

# Run in a separate process, because a damaged .mat file can crash scipy's reader.
READ_MAT = """
import sys
from contextlib import suppress
from io import BytesIO
import numpy as np
from scipy.io import loadmat

def text(cell):
    single = isinstance(cell, np.ndarray) and cell.size == 1
    return cell if isinstance(cell, str) else text(cell.item()) if single else "?"

def of_hdf5(file, keys):  # Matlab's format 7.3: arrays are transposed, cells are references, structures are groups
    import h5py

    def own(holder, key):
        if not isinstance(holder.get(key, getlink=True), h5py.HardLink):
            raise ValueError(f"{key} is a link to another place, which is not allowed")
        item = holder[key]
        if isinstance(item, h5py.Dataset) and (item.is_virtual or item.external or item.nbytes > int(most)):
            raise ValueError(f"{key} is in another file, or has > {most} bytes, which is not allowed")
        return item

    def value(item):
        if isinstance(item, h5py.Group):
            return np.array("?")
        if "MATLAB_empty" in item.attrs:
            return np.array("") if item.attrs.get("MATLAB_class") == b"char" else np.empty(0)
        if h5py.check_ref_dtype(item.dtype):
            return np.array([text(value(file[cell])) for cell in item[()].T.ravel()])
        if item.attrs.get("MATLAB_class") == b"char":
            return np.array("".join(map(chr, item[()].T.ravel())))
        data = item[()].T
        return data["real"] + 1j * data["imag"] if data.dtype.names == ("real", "imag") else data

    result = {}
    for key in keys or [key for key in file if not key.startswith("#")]:
        if key in file:
            item = own(file, key)
            if isinstance(item, h5py.Group):
                result |= {f"{key}.{field}": np.array(text(value(own(item, field)))) for field in item}
            else:
                result[key] = value(item)
    return result

def flat(name, value):
    if value.dtype.names:
        return {f"{name}.{field}": np.array(text(value[field])) for field in value.dtype.names}
    return {name: np.array([text(cell) for cell in np.ravel(value)]) if value.dtype.kind in "OU" else value}

space, most, source, *keys = sys.argv[1:]
with suppress(Exception):  # Windows has no such limit
    import resource
    resource.setrlimit(resource.RLIMIT_DATA, (int(space), int(space)))
try:
    result = {}
    if b"\\x89HDF\\r\\n\\x1a\\n" in open(source, "rb").read(520):  # after 512 bytes of Matlab's header
        import h5py
        result = {key: np.atleast_1d(array) for key, array in of_hdf5(h5py.File(source), keys).items()}
        content = {}
    else:
        content = loadmat(source, appendmat=False)
    for key in keys or [key for key in content if not key.startswith("__")]:
        if key in content:
            result |= flat(key, np.asarray(content[key]))
    size = sum(array.nbytes for array in result.values())
    if size > int(most):
        raise ValueError(f"its arrays have {size} bytes; they must have <= {most} bytes")
    np.savez(arrays := BytesIO(), **result)
    sys.stdout.buffer.write(arrays.getvalue())
except Exception as error:
    sys.exit(" ".join(str(error).split()) or type(error).__name__)
"""


def read_content(path: Path, keys: Sequence[str] = ()) -> dict[str, NDArray[Any]]:
    """Return the arrays of a file by name: those in `keys` that the file contains, or all if `keys` is empty.

    Cell arrays of text become arrays of text. Fields of structures are named `structure.field`, and their values are
    returned as text.

    Raises
    ------
    ValueError
        If the file cannot be read.
    """
    if path.suffix == ".npz":
        return _load_npz(path, keys)
    command = [sys.executable, "-P", "-c", READ_MAT, str(MAT_SPACE), str(MOST_BYTES), str(path), *keys]
    try:
        process = subprocess.run(command, capture_output=True, check=False, timeout=READ_TIME)
    except subprocess.TimeoutExpired:
        raise ValueError(f"it cannot be read as a .mat file in {READ_TIME} s") from None
    if process.returncode:
        lines = process.stderr.decode(errors="replace").strip().splitlines() if process.returncode > 0 else []
        raise ValueError(f"it cannot be read as a .mat file: {_cut(lines[-1] if lines else 'it is damaged')}")
    return _load_npz(BytesIO(process.stdout), keys)


def _load_npz(path: Path | IO[bytes], keys: Sequence[str]) -> dict[str, NDArray[Any]]:
    import numpy as np

    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > MOST_BYTES:
            raise ValueError(f"its arrays have {size} bytes; they must have <= {MOST_BYTES} bytes")
        with np.load(path, allow_pickle=False) as file:
            return {key: file[key] for key in keys or file.files if key in file.files}
    except Exception as error:  # damaged files raise various errors
        reason = single_line(error)
        if "pickle" in reason:  # numpy's message suggests unpickling
            reason = "it contains an array of Python objects, which is not allowed"
        raise ValueError(f"it cannot be read as an .npz file: {_cut(reason)}") from error


def _cut(text: str) -> str:
    """Shorten an error message; if a file is damaged, zipfile's message contains the whole garbled name."""
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}..."
