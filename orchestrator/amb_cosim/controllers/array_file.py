"""Controllers as files of plain arrays: `.npz` of numpy, `.mat` of Matlab, Octave, scipy and Julia.

    A, B, C, D       matrices; with a table of speeds A(:, :, k) and so on
    Ts               sample time (s); 0 or missing: continuous
    inputs, outputs  names: cell arrays of text or char matrices in `.mat`, arrays of text in `.npz`
    speeds           rad/s, with a table

Files written by this package also contain `slow_time`, `allow_unstable` and start values of parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.controllers.laws import Law
from amb_files.array_files import SUFFIXES, read_content
from amb_files.atomic import write_atomically

MATRICES = ("A", "B", "C", "D")
NAMES = ("inputs", "outputs", "start_names", "input_units", "output_units")
KEYS = (*MATRICES, *NAMES, "Ts", "speeds", "slow_time", "allow_unstable", "start_values")


def write_arrays(path: Path, laws: Mapping[float, Law], facts: Mapping[str, Any]) -> Path:
    """Write laws by speed, and `facts` by key, into a file whose suffix selects the format; return the file's path.

    Raises
    ------
    ValueError
        If the suffix is not allowed.
    """
    each = list(laws.values())
    content: dict[str, Any] = {
        name: np.stack([getattr(law, name) for law in each], axis=-1) if len(each) > 1 else getattr(each[0], name)
        for name in MATRICES
    }
    content |= {name: np.array(value) for name, value in facts.items()}
    if len(each) > 1:
        content["speeds"] = np.array(list(laws))
    if path.suffix == ".npz":
        write_atomically(path, lambda file: np.savez(file, **content))
    elif path.suffix == ".mat":
        from scipy.io import savemat

        cells = {name: value.astype(object) if name in NAMES else value for name, value in content.items()}
        write_atomically(path, lambda file: savemat(str(file), cells, appendmat=False))
    else:
        raise ValueError(f"file {str(path)!r} is not allowed; its name must end with {' or '.join(SUFFIXES)}")
    return path


def read_arrays(path: Path) -> dict[str, Any]:
    """Return the content of a file as a dict with the arguments of `linear_controller` and `starts`.

    Raises
    ------
    ValueError
        If the file cannot be read, lacks a matrix, or contains an invalid array.
    """
    content = read_content(path, KEYS)
    lacks = [name for name in MATRICES if name not in content]
    if lacks:
        raise ValueError(f"it lacks {', '.join(lacks)}; it must have the arrays A, B, C, D")
    time = _number(content, "Ts", 0.0)
    if time < 0.0:
        raise ValueError(f"Ts = {time:g} s is not allowed; it must be > 0, or 0 for a continuous law")
    step = time if time > 0.0 else None
    result: dict[str, Any] = {"sample_time": step, "allow_unstable": _number(content, "allow_unstable", 0.0) != 0.0}
    result |= {key: _names(key, content[key]) for key in ("inputs", "outputs") if key in content}
    if "slow_time" in content:
        result["slow_time"] = _number(content, "slow_time", 0.0)
    if "start_names" in content:
        result["starts"] = _starts(content)
    return result | {"K": _laws(content, step)}


def _laws(content: Mapping[str, Any], step: float | None) -> Law | dict[float, Law]:
    matrices = {name: np.asarray(content[name]) for name in MATRICES}
    for name, matrix in matrices.items():
        if matrix.dtype.kind not in "fiuc":  # NumPy also converts dates, truth values and records of one field
            raise ValueError(f"{name} of type {matrix.dtype} is not allowed; it must contain numbers")
    if "speeds" not in content:
        return Law(**matrices, sample_time=step)
    speeds = np.ravel(content["speeds"])
    if speeds.dtype.kind not in "fiu" or not len(speeds):
        raise ValueError("speeds must contain one or more numbers in rad/s")
    for name, matrix in matrices.items():
        if matrix.ndim != 3 or matrix.shape[2] != len(speeds):
            raise ValueError(
                f"{name} of shape {matrix.shape} is not allowed; with {len(speeds)} speeds, the shape must be "
                f"rows x columns x {len(speeds)}"
            )
    table = {
        float(speed): Law(**{name: matrix[:, :, k] for name, matrix in matrices.items()}, sample_time=step)
        for k, speed in enumerate(speeds)
    }
    if len(table) < len(speeds):
        raise ValueError(f"speeds = {speeds.tolist()} rad/s is not allowed; the speeds must differ")
    return table


def _starts(content: Mapping[str, Any]) -> dict[str, float]:
    names, values = _names("start_names", content["start_names"]), np.ravel(content.get("start_values", ()))
    if len(names) != len(values) or values.dtype.kind not in "fiu":
        raise ValueError(f"start_values must contain {len(names)} numbers, one for each of start_names")
    return dict(zip(names, map(float, values), strict=True))


def _number(content: Mapping[str, Any], name: str, default: float) -> float:
    value = np.ravel(content.get(name, default))
    if value.shape != (1,) or value.dtype.kind not in "fiub" or not np.isfinite(value[0]):
        raise ValueError(f"{name} must be a finite number")
    return float(value[0])


def _names(key: str, value: Any) -> list[str]:
    names = np.ravel(value)
    if names.dtype.kind != "U":
        raise ValueError(f"{key} must contain names")
    return [name.strip() for name in names.tolist()]
