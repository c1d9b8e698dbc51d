"""The Zarr store of a sweep: what each point led to, over the axes of the sweep.

    folder/sweep.zarr      opens as xarray.open_zarr(path); rounds of refinement are groups, contact_1, contact_2, ...
    folder/runs            full records of points that are kept

One process writes it. Every chunk is a file that is replaced whole, with a checksum; that of `outcome`, the last one
written, says which points are there: a sweep that was killed at any moment goes on from it. What describes the arrays
is there twice, in a file for each and in one for all (`.zmetadata`), so that damage to either shows. Nothing is removed
but the temporary files of a process that was killed.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.basics.differences import told_differences
from amb_cosim.sweeps.metrics import UNITS
from amb_cosim.sweeps.sampling import SamplePlan
from amb_cosim.sweeps.worker import PointResult
from amb_cosim.sweeps.zarr_groups import EVERY_CHUNK, consolidate, forget_group, read_group, write_group
from amb_files.atomic import write_atomically
from amb_files.temporary_folders import temporary_folder

if TYPE_CHECKING:
    import xarray as xr

STORE, RUNS = "sweep.zarr", "runs"
CHUNK = 16384  # points at most that are written together
LONGEST = 400  # characters of a reason
PARTIAL = re.compile(r"\.[0-9a-f]{32}\.partial$")  # what Zarr writes before a chunk appears whole
DESCRIPTIONS = {
    "outcome": "unstable, trapped, landed, recovered, prevented; completed, stopped; failed, invalid, crashed; empty",
    "reason": "Why a run failed or stopped",
    "seconds": "Wall-clock time of the run",
    "shared": "Share of the steps of the run whose result was restored from another point",
    "contact": "1 where the rotor touched from cycle 0 on",
    "recovered": "1 where the rotor is stable and free of contact for good at the end",
    "rolling": "1 where the rotor rolled on a site through a turn of its whirl or more",
    "contact_share": "Share of the time between disturbance and relief in contact",
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
        If the store was made for something else, where the message says what differs; if it is damaged; or if what
        lies in its place is none. It stays as it is.
    """

    def __init__(
        self,
        folder: Path,
        design: SamplePlan,
        request: Mapping[str, Any],
        provenance: Mapping[str, Any],
        group: str = "",
    ) -> None:
        self.folder, self.design, self.group = folder, design, group
        self.path = folder / STORE
        self._values: dict[str, NDArray[Any]] = {}
        self._arrays: dict[str, Any] = {}
        self._rows = max(1, CHUNK // max(1, design.size // design.shape[0]))  # of a chunk, along the first axis
        self._dirty: set[int] = set()
        requested = json.loads(json.dumps(dict(request)))
        self._attrs = {"request": json.dumps(requested), "provenance": json.dumps(dict(provenance))}
        if os.path.lexists(self.path / group):
            present = open_sweep(folder, group)
            check_same(requested, json.loads(present.attrs.get("request", "null")), folder)
            self._values = {str(name): np.array(variable.values) for name, variable in present.data_vars.items()}
            self._clear_up()
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
        described = json.loads(self._attrs["provenance"]).get("descriptions", {})
        for axis in self.design.axes:
            for column in axis.columns:
                values = column.values if column.numeric else [str(v) for v in column.values]
                attributes = {"units": column.unit} if column.unit else {}
                if column.name in described:
                    attributes["description"] = described[column.name]
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
        with temporary_folder(self.folder) as temporary:
            whole = self._staged(self._labelled(tuple(self._values)), temporary)
            if not self.group:
                consolidate(whole)
            whole.rename(self.path / self.group)
        consolidate(self.path)

    def _labelled(self, names: Sequence[str]) -> xr.Dataset:
        import xarray as xr

        data = {name: (self._dims, self._values[name], self._attributes(name)) for name in names}
        return xr.Dataset(data, self._coordinates(), self._attrs)

    def _staged(self, dataset: xr.Dataset, folder: Path) -> Path:
        """Write arrays of results into a folder, and return where; what is moved into the store then is whole."""
        chunks = (min(self._rows, self.design.shape[0]), *self.design.shape[1:])
        return write_group(dataset, folder / STORE, dict.fromkeys(dataset.data_vars, chunks))

    def replace_group(self, name: str, dataset: xr.Dataset) -> None:
        """Write a data set as a group of the store, in place of one that a sweep has written there."""
        target = self.path / name
        if os.path.lexists(target):
            open_sweep(self.folder, name)
        with temporary_folder(self.folder) as temporary:
            whole = write_group(dataset, temporary / "new")
            forget_group(self.path, name)
            if target.exists():
                target.rename(temporary / "old")
            whole.rename(target)
        consolidate(self.path)

    def _write_new(self, names: Sequence[str]) -> None:
        """Add arrays that no result has had before, each of them whole or not at all."""
        with temporary_folder(self.folder) as temporary:
            whole = self._staged(self._labelled(names).drop_vars(list(self._coordinates())), temporary)
            for name in names:
                (whole / name).rename(self.path / self.group / name)
        consolidate(self.path)

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
            with zarr.config.set(EVERY_CHUNK):
                self._arrays[name] = zarr.open_array(self.path / self.group / name, mode="r+", zarr_format=2)
        return self._arrays[name]

    def _clear_up(self) -> None:
        """Remove what a process left that was killed while it wrote, and take up what it had begun to add."""
        for left in self.path.rglob("*.partial"):
            if PARTIAL.search(left.name):
                left.unlink()
        consolidate(self.path)


def open_sweep(folder: str | Path, group: str = "") -> xr.Dataset:
    """Read the results of a sweep, or of a round of its refinement, into memory.

    Raises
    ------
    ValueError
        If there are none, or what is there is damaged.
    """
    path = Path(folder) / STORE
    if not (path / group / ".zattrs").is_file():
        raise ValueError(f"no sweep in {folder}; it must be a folder with {STORE}, and that one that a sweep has made")
    return read_group(path, group)


def check_same(asked: Mapping[str, Any], there: Mapping[str, Any], folder: Path) -> None:
    """Raise ValueError if what is asked for is not what the sweep in a folder was made for."""
    if message := told_differences(there, asked):
        raise ValueError(f"the sweep in {folder} was made for something else; choose another folder\n{message}")
