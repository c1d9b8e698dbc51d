"""The Zarr store of a sweep: results of each point over the axes.

    folder/sweep.zarr      opens as xarray.open_zarr(path); rounds of refinement are groups, contact_1, contact_2, ...
    folder/runs            full records of selected points

A single process writes the store. Every chunk is a file with a checksum, and is replaced atomically. `outcome` is
written last and shows which points have results, so a sweep that was killed at any moment can resume. Metadata of the
arrays are stored twice, in a file per array and in a common file (`.zmetadata`), so damage to either is detected. The
only files that are removed are temporary files of a killed process, a store without results (`discard`), and a store
whose results a larger one holds: more points of the same sample are added to the points that a folder has.
"""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from amb_cosim.cosim.system.differences import list_differences
from amb_files.atomic import plain_file, write_file
from amb_files.temporary_folders import temporary_folder
from amb_sweeps.metrics import KEY_VALUES
from amb_sweeps.outcomes import COLOURS
from amb_sweeps.sampling import GROWING, SamplePlan
from amb_sweeps.worker import PointResult
from amb_sweeps.zarr_groups import EVERY_CHUNK, consolidate, forget_group, read_group, write_group

if TYPE_CHECKING:
    import xarray as xr

STORE, RUNS = "sweep.zarr", "runs"
BEFORE = "sweep.zarr.before"  # a store while a larger one replaces it
CHUNK = 16384  # most points that are written together
LONGEST = 400  # most characters of a reason
PARTIAL = re.compile(r"\.[0-9a-f]{32}\.partial$")  # Zarr's temporary files of chunks
VALUES = {  # unit and description
    **KEY_VALUES,
    "outcome": ("", f"{', '.join(filter(None, COLOURS))}; empty: not run yet"),
    "reason": ("", "Why a run failed or stopped"),
    "metric_error": ("", "Error of a user's metric, whose numbers are then missing"),
    "late_events": ("1", "Number of events without effect, because the run ends before them; NaN: none"),
    "seconds": ("s", "Wall-clock time of the run"),
    "shared": ("", "Fraction of the steps of the run that were restored from another point"),
}


class SweepStore:
    """Results of the points of a design, in memory and in a group of the store.

    Parameters
    ----------
    folder
        Folder of the sweep.
    design
        Points of the sweep.
    request
        The request, as JSON data; an existing store must have the same request.
    provenance
        Versions and other information to save with the results, as JSON data.
    group
        Group of the store; its root by default.

    Raises
    ------
    ValueError
        If the store was made for another request (the message lists the differences), unless it has fewer points of
        the same sample; if it is damaged, or if its path is not a store. Nothing is changed.
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
        self._rows = max(1, CHUNK // max(1, design.size // design.shape[0]))  # length of a chunk along the first axis
        self._dirty: set[int] = set()
        requested = json.loads(json.dumps(dict(request)))
        self._attrs = {"request": json.dumps(requested), "provenance": json.dumps(dict(provenance))}
        self._finish_interrupted_growth()
        if os.path.lexists(self.path / group):
            existing = open_sweep(folder, group)
            stored = json.loads(existing.attrs.get("request", "null"))
            fewer = None if group else self._fewer_points(stored)
            check_same(
                requested if fewer is None else json.loads(json.dumps({**requested, "design": fewer.as_dict()})),
                stored,
                folder,
            )
            self._values = {str(name): np.array(variable.values) for name, variable in existing.data_vars.items()}
            self._finish_interrupted_write()
            if fewer is not None:
                self._grow(fewer)
        else:
            self._create()

    def _fewer_points(self, stored: Any) -> SamplePlan | None:
        """Return the design with the points of the stored request; None unless it is a smaller sample.

        The files of kept records have the number of their point, which crossed axes would change.
        """
        sampling = str(((stored or {}).get("design") or {}).get("sampling", ""))
        method, _, number = sampling.partition(":")
        is_crossed = len(self.design.axes) > 1 and (self.folder / RUNS).exists()
        if method not in GROWING or method != self.design.method or not number.isdecimal() or is_crossed:
            return None
        count = int(number)
        return self.design.first(count) if count < len(self.design.axes[-1]) else None

    def _grow(self, fewer: SamplePlan) -> None:
        """Replace the store by a store with all points of the design, with the results of the fewer points."""
        of_fewer = tuple(slice(length) for length in fewer.shape)
        for name, values in self._values.items():
            numeric = values.dtype.kind == "f"
            grown = np.full(self.design.shape, np.nan if numeric else "", values.dtype)
            grown[of_fewer] = values
            self._values[name] = grown
        before = self.folder / BEFORE
        with temporary_folder(self.folder) as temporary:
            staged = self._staged(self._labelled(tuple(self._values)), temporary)
            consolidate(staged)
            self.path.rename(before)
            staged.rename(self.path)
        shutil.rmtree(before)

    def _finish_interrupted_growth(self) -> None:
        """Restore a store whose replacement was interrupted, or remove it if it was replaced."""
        before = self.folder / BEFORE
        if not os.path.lexists(before):
            return
        if os.path.lexists(self.path):
            shutil.rmtree(before)
        else:
            before.rename(self.path)

    @property
    def missing(self) -> list[int]:
        """Points without a result."""
        return [int(n) for n in np.flatnonzero(self._values["outcome"].ravel() == "")]

    def add(self, results: Sequence[PointResult]) -> None:
        """Add results, and write their chunks and the selected records."""
        names = dict.fromkeys(name for result in results for name in result.metrics)
        self._add_arrays([name for name in names if name not in self._values], np.nan)
        if any(result.metric_error for result in results) and "metric_error" not in self._values:
            self._add_arrays(["metric_error"], "")
        for result in results:
            if result.record is not None:
                runs = self.folder / RUNS
                runs.mkdir(exist_ok=True)
                write_file(plain_file(runs, f"{self.group or 'grid'}_{result.point}.nc"), result.record)
            index = np.unravel_index(result.point, self.design.shape)
            for name, value in (*result.metrics.items(), ("seconds", result.seconds)):
                self._values[name][index] = value
            self._values["reason"][index] = result.reason[:LONGEST]
            if result.metric_error:
                self._values["metric_error"][index] = result.metric_error.text[:LONGEST]
            self._values["outcome"][index] = result.outcome
            self._dirty.add(int(index[0]) // self._rows)
        self._write()

    def discard(self) -> None:
        """Remove the store if it has no result, so that another request may use its folder."""
        if len(self.missing) == self.design.size:
            shutil.rmtree(self.path)

    def dataset(self) -> xr.Dataset:
        """Return the results so far as a data set over the axes."""
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
        unit, described = VALUES.get(name.partition(".")[0], ("", ""))
        return {**({"units": unit} if unit else {}), **({"description": described} if described else {})}

    def _create(self) -> None:
        """Create the store without results, atomically."""
        self._values["outcome"] = np.full(self.design.shape, "", "<U16")
        self._values["reason"] = np.full(self.design.shape, "", object)  # of any length, so that most take no space
        self._values["seconds"] = np.full(self.design.shape, np.nan)
        self.folder.mkdir(parents=True, exist_ok=True)
        with temporary_folder(self.folder) as temporary:
            staged = self._staged(self._labelled(tuple(self._values)), temporary)
            if not self.group:
                consolidate(staged)
            staged.rename(self.path / self.group)
        consolidate(self.path)

    def _labelled(self, names: Sequence[str]) -> xr.Dataset:
        import xarray as xr

        data = {name: (self._dims, self._values[name], self._attributes(name)) for name in names}
        return xr.Dataset(data, self._coordinates(), self._attrs)

    def _staged(self, dataset: xr.Dataset, folder: Path) -> Path:
        """Write arrays of results into a folder, which is then moved into the store, and return the folder's path."""
        chunks = (min(self._rows, self.design.shape[0]), *self.design.shape[1:])
        return write_group(dataset, folder / STORE, dict.fromkeys(dataset.data_vars, chunks))

    def replace_group(self, name: str, dataset: xr.Dataset) -> None:
        """Write a data set as a group of the store, replacing the group of an earlier sweep."""
        target = self.path / name
        if os.path.lexists(target):
            open_sweep(self.folder, name)
        with temporary_folder(self.folder) as temporary:
            staged = write_group(dataset, temporary / "new")
            forget_group(self.path, name)
            if target.exists():
                target.rename(temporary / "old")
            staged.rename(target)
        consolidate(self.path)

    def _add_arrays(self, names: Sequence[str], fill: float | str) -> None:
        """Add arrays of one value for new variables, each atomically."""
        if not names:
            return
        of_type = object if isinstance(fill, str) else np.float64  # texts of any length
        self._values |= {name: np.full(self.design.shape, fill, of_type) for name in names}
        with temporary_folder(self.folder) as temporary:
            staged = self._staged(self._labelled(names).drop_vars(list(self._coordinates())), temporary)
            for name in names:
                (staged / name).rename(self.path / self.group / name)
        consolidate(self.path)

    def _write(self) -> None:
        """Write the changed chunks; the chunks of the outcomes are written last."""
        for name in sorted(self._values, key=lambda name: name == "outcome"):
            for block in self._dirty:
                rows = slice(block * self._rows, (block + 1) * self._rows)
                self._array(name)[rows] = self._values[name][rows]
        self._dirty.clear()

    def _array(self, name: str) -> Any:
        """Return an array of the store; each array is opened only once."""
        import zarr

        if name not in self._arrays:
            with zarr.config.set(EVERY_CHUNK):
                self._arrays[name] = zarr.open_array(self.path / self.group / name, mode="r+", zarr_format=2)
        return self._arrays[name]

    def _finish_interrupted_write(self) -> None:
        """Remove temporary files of a process that was killed while writing, and finish adding its arrays."""
        for partial in self.path.rglob("*.partial"):
            if PARTIAL.search(partial.name):
                partial.unlink()
        consolidate(self.path)


def open_sweep(folder: str | Path, group: str = "") -> xr.Dataset:
    """Read the results of a sweep, or of a round of its refinement, into memory.

    Raises
    ------
    ValueError
        If there are no results, or the store is damaged.
    """
    path = Path(folder) / STORE
    if not (path / group / ".zattrs").is_file():
        raise ValueError(f"no sweep in {folder}; it must be a folder in which a sweep created {STORE}")
    return read_group(path, group)


def check_same(request: Mapping[str, Any], stored: Mapping[str, Any], folder: Path) -> None:
    """Raise ValueError if a request differs from the request of the sweep in a folder.

    GUIDs depend on the rest of the request, the code, and files other than the rotor file. Differences of GUIDs are
    therefore listed only if nothing else differs.
    """
    differences = list_differences({**stored, "guids": None}, {**request, "guids": None})
    if not differences and (fmu_differences := list_differences(stored, request)):
        differences = f"{fmu_differences}\n  (the code of these FMUs, or a file from which they are made, differs)"
    if differences:
        raise ValueError(f"the sweep in {folder} was made for another request; choose another folder\n{differences}")
