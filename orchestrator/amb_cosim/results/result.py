"""The result of a run: its data set, summary, figures, and outcome."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from amb_cosim.cosim.run.dataset import Run, load
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.cosim.system.values import Raw
from amb_files.atomic import plain_file, remove_files, write_file
from amb_files.checks import as_path

if TYPE_CHECKING:
    from amb_cosim.results.plots import Plots
    from amb_cosim.results.summary import Summary

RESULT, SUMMARY = "result.nc", "summary.json"


class Result(Run):
    """A run of a scenario.

    Attributes
    ----------
    dataset
        Every recorded variable over `time` (s) and `cycle`, with units and descriptions (`xarray.Dataset`).
    outcome
        How it ended: `status` (completed, stopped, failed, interrupted), `time` (s), `component`, `reason`.
    checkpoints
        States saved at the times in `save_at`, by communication point; see `checkpoint`.

    Examples
    --------
    >>> import amb_cosim
    >>> folder = amb_cosim.run("compressor_levitated", until="20 ms").save("compressor", plots=False)
    >>> print(Result.load(folder).outcome)
    completed at t = 0.02 s
    """

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a result from its folder, or from its file `result.nc`.

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
            return cls(dataset, Outcome(*json.loads(dataset.attrs["outcome"])))
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

    def save(self, folder: str | Path, plots: bool = True) -> Path:
        """Write `result.nc`, `summary.json` and, if requested, the figures that suit the run; return the folder.

        Figures of a run that was saved there before are removed, with or without new ones.
        """
        from amb_cosim.results.plots import MODULES, draw_all

        folder = as_path("folder", folder)
        folder.mkdir(parents=True, exist_ok=True)
        remove_files(folder, (f"{name}.png" for name in MODULES))
        self._save(plain_file(folder, RESULT))
        write_file(plain_file(folder, SUMMARY), self.summary.to_json())
        if plots:
            draw_all(self.signals, folder)
        return folder

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
