"""The Zarr store of a sweep: what each point led to, over the axes of the sweep.

    folder/sweep.zarr      opens as xarray.open_zarr(path); rounds of refinement are groups, contact_1, contact_2, ...
    folder/runs            full records of points that are kept

One process writes it. Every chunk is a file that is replaced whole; that of `outcome`, the last one written, says which
points are there: a sweep that was killed at any moment goes on from it.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from amb_cosim.sweeps.metrics import UNITS
from amb_cosim.sweeps.sampling import Design
from amb_cosim.sweeps.worker import PointResult
from amb_files.atomic import write_atomically

if TYPE_CHECKING:
    import xarray as xr

STORE, RUNS = "sweep.zarr", "runs"
CHUNK = 16384  # points at most that are written together
LONGEST = 400  # characters of a reason
DESCRIPTIONS = {
    "outcome": "unstable, trapped, recovered, prevented; completed, stopped; failed, invalid, crashed; empty: not run",
    "reason": "Why a run failed or stopped",
    "seconds": "Wall-clock time of the run",
    "contact": "1 where the rotor touched from cycle 0 on",
    "recovered": "1 where the rotor is stable and free of contact for good at the end",
    "rolling": "1 where the rotor rolled on a site through a turn of its whirl or more",
    "contact_share": "Share of the time between step and removal in contact",
}


class SweepStore:
    """Results of the points of a design, in memory and in a group of the store.

    Parameters
    ----------
    folder
        Of the sweep.
    design
        Its points.
    request
        What was asked for, as JSON data; a store that is there must have been made for the same.
    provenance
        Versions and whatever else is kept beside the results, as JSON data.
    group
        Of the store; its root by default.

    Raises
    ------
    ValueError
        If the store was made for something else; the message says what differs.
    """

    def __init__(
        self, folder: Path, design: Design, request: Mapping[str, Any], provenance: Mapping[str, Any], group: str = ""
    ) -> None:
        self.folder, self.design, self.group = folder, design, group
        self.path = folder / STORE
        self._values: dict[str, NDArray[Any]] = {}
        self._arrays: dict[str, Any] = {}
        self._rows = max(1, CHUNK // max(1, design.size // design.shape[0]))  # of a chunk, along the first axis
        self._dirty: set[int] = set()
        asked = json.loads(json.dumps(dict(request)))
        self._attrs = {"request": json.dumps(asked), "provenance": json.dumps(dict(provenance))}
        if (self.path / group / ".zattrs").is_file():
            check_same(asked, self._request(), folder)
            self._read()
        else:
            self._create()

    @property
    def missing(self) -> list[int]:
        """Points that have no result yet."""
        return [int(n) for n in np.flatnonzero(self._values["outcome"].ravel() == "")]

    def add(self, results: Sequence[PointResult]) -> None:
        """Take results, and write the chunks that they are in, and the records that are kept."""
        names = dict.fromkeys(name for result in results for name in result.metrics)
        if new := [name for name in names if name not in self._values]:
            self._values |= {name: np.full(self.design.shape, np.nan) for name in new}
            self._write_new(new)
        for result in results:
            if result.record is not None:
                file = self.folder / RUNS / f"{self.group or 'grid'}_{result.point}.nc"
                file.parent.mkdir(exist_ok=True)
                content = result.record
                write_atomically(file, lambda path, content=content: path.write_bytes(content))  # type: ignore[misc]
            index = np.unravel_index(result.point, self.design.shape)
            for name, value in (*result.metrics.items(), ("seconds", result.seconds)):
                self._values[name][index] = value
            self._values["reason"][index] = result.reason[:LONGEST]
            self._values["outcome"][index] = result.outcome
            self._dirty.add(int(index[0]) // self._rows)
        self._write()

    def dataset(self) -> xr.Dataset:
        """Return what is there as a data set over the axes."""
        return self._labelled(tuple(self._values)).copy(deep=True)

    @property
    def _dims(self) -> tuple[str, ...]:
        return tuple(axis.name for axis in self.design.axes)

    def _coordinates(self) -> dict[str, Any]:
        coordinates: dict[str, Any] = {}
        for axis in self.design.axes:
            for column in axis.columns:
                values = column.values if column.numeric else [str(v) for v in column.values]
                attributes = {"units": column.unit} if column.unit else {}
                coordinates[column.name] = (axis.name, np.array(values), attributes)
        return coordinates

    def _attributes(self, name: str) -> dict[str, str]:
        unit = "s" if name == "seconds" else UNITS.get(name.partition(".")[0], "")
        described = DESCRIPTIONS.get(name)
        return {**({"units": unit} if unit else {}), **({"description": described} if described else {})}

    def _create(self) -> None:
        """Make the store with no results, whole or not at all."""
        self._values["outcome"] = np.full(self.design.shape, "", "<U16")
        self._values["reason"] = np.full(self.design.shape, "", object)  # of any length, so that most take nothing
        self._values["seconds"] = np.full(self.design.shape, np.nan)
        self.folder.mkdir(parents=True, exist_ok=True)
        stage, target = self._staged(self._labelled(tuple(self._values))), self.path / self.group
        if target.exists():  # a group or a store that has not come so far
            shutil.rmtree(target)
        stage.rename(target)
        self._consolidate()

    def _labelled(self, names: Sequence[str]) -> xr.Dataset:
        import xarray as xr

        data = {name: (self._dims, self._values[name], self._attributes(name)) for name in names}
        return xr.Dataset(data, self._coordinates(), self._attrs)

    def _staged(self, dataset: xr.Dataset) -> Path:
        """Write a data set beside the store, and return where; what is moved into the store then is whole."""
        stage = self.folder / f".{STORE}.new"
        shutil.rmtree(stage, ignore_errors=True)
        chunks = (min(self._rows, self.design.shape[0]), *self.design.shape[1:])
        encoding = {name: {"chunks": chunks} for name in dataset.data_vars}
        dataset.to_zarr(stage, mode="w", zarr_format=2, consolidated=False, encoding=encoding)
        return stage

    def _write_new(self, names: Sequence[str]) -> None:
        """Add arrays that no result has had before, each of them whole or not at all."""
        stage = self._staged(self._labelled(names).drop_vars(list(self._coordinates())))
        for name in names:
            (stage / name).rename(self.path / self.group / name)
        shutil.rmtree(stage)
        self._consolidate()

    def _consolidate(self) -> None:
        """Write what arrays there are into one file, which xarray opens a store by."""
        import zarr

        zarr.consolidate_metadata(self.path, zarr_format=2)

    def _write(self) -> None:
        """Write the chunks that have changed, outcomes last."""
        for name in sorted(self._values, key=lambda name: name == "outcome"):
            for block in self._dirty:
                rows = slice(block * self._rows, (block + 1) * self._rows)
                self._array(name)[rows] = self._values[name][rows]
        self._dirty.clear()

    def _array(self, name: str) -> Any:
        """Return an array of the store, which is opened once."""
        import zarr

        if name not in self._arrays:
            self._arrays[name] = zarr.open_array(self.path / self.group / name, mode="r+", zarr_format=2)
        return self._arrays[name]

    def _read(self) -> None:
        for left in self.path.rglob("*.partial"):  # by a process that was killed while it wrote
            left.unlink()
        self._consolidate()
        dataset = open_sweep(self.folder, self.group)
        self._values = {str(name): np.array(variable.values) for name, variable in dataset.data_vars.items()}

    def _request(self) -> dict[str, Any]:
        import zarr

        found: dict[str, Any] = json.loads(str(zarr.open_group(self.path / self.group, mode="r").attrs["request"]))
        return found


def open_sweep(folder: str | Path, group: str = "") -> xr.Dataset:
    """Read the results of a sweep, or of a round of its refinement, into memory.

    Raises
    ------
    ValueError
        If there are none.
    """
    import xarray as xr

    path = Path(folder) / STORE
    if not (path / group).is_dir():
        raise ValueError(f"no sweep in {folder}; it must be a folder with {STORE}")
    with xr.open_zarr(path, group=group or None, consolidated=False, chunks=None) as dataset:
        return dataset.load()


def check_same(asked: Mapping[str, Any], there: Mapping[str, Any], folder: Path) -> None:
    """Raise ValueError if what is asked for is not what the sweep in a folder was made for."""
    if differing := list(_differences(there, asked)):
        told = "\n".join(
            f"  {where}: {_short(before)} there, {_short(now)} now" for where, before, now in differing[:10]
        )
        raise ValueError(f"the sweep in {folder} was made for something else; choose another folder\n{told}")


def _differences(there: Any, asked: Any, where: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield where two pieces of JSON data differ, and both values."""
    if isinstance(there, Mapping) and isinstance(asked, Mapping):
        for key in {**there, **asked}:
            yield from _differences(there.get(key), asked.get(key), f"{where}.{key}".lstrip("."))
    elif isinstance(there, list) and isinstance(asked, list) and len(there) == len(asked):
        for k, (before, now) in enumerate(zip(there, asked, strict=True)):
            yield from _differences(before, now, f"{where}[{k}]")
    elif there != asked:
        yield where, there, asked


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 160 else f"{text[:157]}..."
