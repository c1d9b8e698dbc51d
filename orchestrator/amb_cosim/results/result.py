"""The result of a run: its data set, summary, figures, and outcome."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, overload

import numpy as np

from amb_cosim.cosim.record.signals import Signals, variables_of
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.dataset import Run, load
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.cosim.system.values import Raw
from amb_files.atomic import plain_file, remove_files, write_file
from amb_files.checks import as_path
from amb_files.suggestions import suggest

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from amb_cosim.results.plots import Plots
    from amb_cosim.results.summary import Summary

RESULT, SUMMARY, CHECKPOINT = "result.nc", "summary.json", "checkpoint_*.npz"


class Result(Run):
    """A run of a scenario.

    Attributes
    ----------
    dataset
        Every recorded variable over `time` (s) and `cycle`, with units and descriptions (`xarray.Dataset`).
    outcome
        How it ended: `status` (completed, stopped, failed, interrupted), `time` (s), `component`, `reason`.
    checkpoints
        States saved at the times in `save_at`, by communication point; see `checkpoint`. `save` writes them, too.

    Examples
    --------
    >>> import amb_cosim
    >>> folder = amb_cosim.run("compressor_levitated", until="20 ms").save("compressor", plots=False)
    >>> print(Result.load(folder).outcome)
    completed at t = 0.02 s
    """

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a result from its folder, or from its file `result.nc`, with the checkpoints of this run beside it.

        Raises
        ------
        ValueError
            If there is no result, or it is damaged.
        """
        file = as_path("path", path)
        file = file / RESULT if file.is_dir() else file
        if not file.is_file():
            raise ValueError(f"no result {file}; it must be a folder with {RESULT}, or that file")
        try:
            from amb_cosim.results.stored_attributes import check_signals

            dataset = load(file)
            check_signals(dataset)
            states = _checkpoints_beside(file, dataset)
            return cls(dataset, Outcome(*json.loads(dataset.attrs["outcome"])), states)
        except Exception as error:  # HDF5, its readers and JSON each raise their own
            raise ValueError(
                f"{file} is not a result of a run, or is damaged ({error or type(error).__name__}); it must be a "
                f"folder with {RESULT}, or that file"
            ) from error

    @property
    def scenario(self) -> str:
        """Name of the scenario.

        Raises
        ------
        ValueError
            If it is the result of a system of FMUs without a scenario.
        """
        if "scenario" not in self.signals.attrs:
            system = self.signals.attrs.get("system", "FMUs")
            raise ValueError(
                f"this is the result of the system {system}, not of a scenario; its variables can be plotted"
            )
        return str(self.signals.attrs["scenario"])

    @cached_property
    def summary(self) -> Summary:
        """Key values of the run, whose units `Summary` documents; raises ValueError as `scenario` does."""
        from amb_cosim.results.summary import summarise

        _ = self.scenario
        return summarise(self.signals)

    @property
    def plot(self) -> Plots:
        """Figures of a run: `plot("left.x")`, `plot.orbits()`, `turns`, `contact`, `magnets`, ..."""
        from amb_cosim.results.plots import Plots

        return Plots(self.signals)

    @overload
    def __getitem__(self, name: str) -> xr.DataArray: ...

    @overload
    def __getitem__(self, name: list[str] | tuple[str, ...]) -> xr.Dataset: ...

    def __getitem__(self, name: str | list[str] | tuple[str, ...]) -> xr.DataArray | xr.Dataset:
        """Return a variable of the data set by its name, with or without its component: `result["left.x"]`.

        A list of names selects a data set of these variables.

        Raises
        ------
        KeyError
            If the run did not record it.
        """
        if not isinstance(name, str):
            return self.dataset[[self._whole(each) for each in name]]
        return self.dataset[self._whole(name)]

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and bool(self._named(name))

    def __iter__(self) -> Iterator[str]:
        return iter(variables_of(self.signals))

    def _named(self, name: str) -> list[str]:
        """Return the variables of a name with its component, or of a name without one."""
        names = variables_of(self.signals)
        if name in names or name in self.dataset.coords:
            return [name]
        return [each for each in names if each.partition(".")[2] == name]

    def _whole(self, name: str) -> str:
        """Return the name of a variable with its component."""
        names = self._named(name)
        if len(names) == 1:
            return names[0]
        all_names = variables_of(self.signals)
        options = names or [each if "." not in name else each.partition(".")[2] or each for each in all_names]
        raise KeyError(f"{name!r} is {'ambiguous' if names else 'not recorded'}; {suggest(name, options)}")

    def save(self, folder: str | Path, plots: bool = True) -> Path:
        """Write `result.nc`, `summary.json`, checkpoints and, if requested, figures that suit the run.

        The folder is returned. Figures of a run that was saved there before are removed, with or without new ones.
        """
        from amb_cosim.results.plots import MODULES, draw_all

        folder = as_path("folder", folder)
        folder.mkdir(parents=True, exist_ok=True)
        remove_files(folder, (f"{name}.png" for name in MODULES))
        self._save(plain_file(folder, RESULT))
        write_file(plain_file(folder, SUMMARY), self.summary.to_json())
        for state in self.checkpoints.values():
            if not state.is_held:
                state.save(plain_file(folder, checkpoint_name(f"{state.time:.9g} s")))
        if plots:
            draw_all(self.signals, folder)
        return folder

    def to_dataframe(
        self, *variables: str | Sequence[str], begin: Raw | None = None, until: Raw | None = None
    ) -> pd.DataFrame:
        """Return variables as a table of pandas over `time` (s); see `plot` for the arguments.

        The units of the columns are in `attrs["units"]` of the table.
        """
        import pandas as pd

        from amb_cosim.results.selection import select

        selection = select(self.signals, variables, begin, until)
        table = pd.DataFrame(
            {name: selection.values(name) for name in selection.names},
            index=pd.Index(selection.values("time"), name="time"),
        )
        table.attrs["units"] = {name: selection.unit(name) for name in ("time", *selection.names)}
        return table

    def to_csv(
        self, path: str | Path, *variables: str | Sequence[str], begin: Raw | None = None, until: Raw | None = None
    ) -> Path:
        """Write variables as a table with names and units in its first row; see `plot` for the arguments."""
        from amb_cosim.results.selection import select, to_csv

        path = as_path("path", path)
        to_csv(select(self.signals, variables, begin, until), path)
        return path

    def to_mat(
        self, path: str | Path, *variables: str | Sequence[str], begin: Raw | None = None, until: Raw | None = None
    ) -> Path:
        """Write variables as a MAT file, with underscores instead of dots in names; see `plot` for the arguments."""
        from amb_cosim.results.selection import select, to_mat

        path = as_path("path", path)
        to_mat(select(self.signals, variables, begin, until), path)
        return path

    def __repr__(self) -> str:
        return f"<Result of {self.scenario}: {self.outcome}; {len(self.dataset.data_vars)} variables>"

    def _repr_html_(self) -> str:
        from amb_cosim.results.notebook import html_of

        return html_of(self.signals, self.summary, self.outcome)


def checkpoint_name(moment: str) -> str:
    """Return the name of the file of a checkpoint at a time such as `cycle 5` or `0.3 s`.

    Examples
    --------
    >>> checkpoint_name("cycle 5")
    'checkpoint_cycle_5.npz'
    """
    return CHECKPOINT.replace("*", re.sub("[^0-9A-Za-z.]+", "_", moment))


def _checkpoints_beside(file: Path, dataset: Signals) -> dict[int, Checkpoint]:
    """Return the checkpoints in the folder of a result that are states of this run, by communication point."""
    states = {}
    for path in sorted(file.parent.glob(CHECKPOINT)):
        try:
            state = Checkpoint.load(path)
        except ValueError:  # of another version; `Checkpoint.load` of the user says so
            continue
        if _is_state_of(state, dataset):
            states[state.point] = state
    return states


def _is_state_of(state: Checkpoint, dataset: Signals) -> bool:
    """Return whether the record in a checkpoint begins the record of a run, to the last bit."""
    count, names = len(state.points), variables_of(dataset)
    if not set(state.recorded) <= {*names} or state.step_size != dataset.attrs["communication_step_s"]:
        return False
    columns = (np.asarray(dataset[name].values[:count], np.float64) for name in state.recorded)
    return all(np.array_equal(a, b, equal_nan=True) for a, b in zip(columns, state.table.T, strict=True))
