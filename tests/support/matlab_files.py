"""Writes `.mat` files of Matlab's format 7.3: HDF5 after a header of 512 bytes, arrays transposed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

HEADER = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan 05 10:00:00 2026 HDF5 schema 1.00 ."


def write_mat73(path: Path, content: Mapping[str, Any]) -> Path:
    """Write arrays of numbers, texts, lists of texts (cells), and mappings (structures), as `save -v7.3` does."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in content.items():
            _write(file, file, name, value)
    with path.open("r+b") as raw:
        raw.write(HEADER.ljust(124) + b"\0\x02IM")
    return path


def _write(file: h5py.File, group: h5py.Group, name: str, value: Any) -> None:
    if isinstance(value, Mapping):
        inner = group.create_group(name)
        inner.attrs["MATLAB_class"] = np.bytes_("struct")
        for field, item in value.items():
            _write(file, inner, field, item)
    elif isinstance(value, str):
        data = group.create_dataset(name, data=np.array([[ord(sign)] for sign in value], np.uint16))
        data.attrs["MATLAB_class"] = np.bytes_("char")
    elif isinstance(value, list):
        refs = file.require_group("#refs#")
        for k, item in enumerate(value):
            _write(file, refs, f"{name}{k}", item)
        cells = np.array([[refs[f"{name}{k}"].ref] for k in range(len(value))], h5py.ref_dtype)
        group.create_dataset(name, data=cells.T).attrs["MATLAB_class"] = np.bytes_("cell")
    else:
        array = np.atleast_2d(value).T
        if np.iscomplexobj(array):
            array = array.astype(np.complex128).view([("real", "<f8"), ("imag", "<f8")])
        group.create_dataset(name, data=array).attrs["MATLAB_class"] = np.bytes_("double")
