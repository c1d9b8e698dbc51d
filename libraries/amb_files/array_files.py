"""Reads files of named arrays: `.npz` of numpy, `.mat` of Matlab, Octave, scipy and Julia."""

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
    return cell if isinstance(cell, str) else text(cell.item()) if np.size(cell) == 1 else "?"

def flat(name, value):
    if value.dtype.names:
        return {f"{name}.{field}": np.array(text(value[field])) for field in value.dtype.names}
    return {name: np.array([text(cell) for cell in np.ravel(value)]) if value.dtype.kind in "OU" else value}

space, most, source, *keys = sys.argv[1:]
with suppress(Exception):  # Windows has no such limit
    import resource
    resource.setrlimit(resource.RLIMIT_DATA, (int(space), int(space)))
try:
    content = loadmat(source, appendmat=False)
    keys = keys or [key for key in content if not key.startswith("__")]
    result = {}
    for key in keys:
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
    """Return arrays of a file by name: those of `keys` that it has, all by default.

    Cells of text become arrays of text; a field of a structure is called `structure.field`, and its value is text.

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
            reason = "it has an array of Python objects, which is not allowed"
        raise ValueError(f"it cannot be read as an .npz file: {_cut(reason)}") from error


def _cut(text: str) -> str:
    """Shorten a reason: for a damaged file, zipfile prints the whole garbled name."""
    return text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]}..."
