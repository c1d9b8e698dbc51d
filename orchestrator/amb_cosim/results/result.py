"""What a run leaves behind: its data set, its summary, its figures, and how it ended."""

from __future__ import annotations

import json
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from amb_cosim.cosim.run.dataset import Run, load
from amb_cosim.cosim.run.recording import Outcome
from amb_files.atomic import write_atomically

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
        States that `save_at` asked for, by communication point; see `checkpoint`.
    """

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a result from its folder, or from its file `result.nc`.

        Raises
        ------
        ValueError
            If there is none, or it is damaged.
        """
        file = Path(path) / RESULT if Path(path).is_dir() else Path(path)
        if not file.is_file():
            raise ValueError(f"no result {file}; it must be a folder with {RESULT}, or that file")
        try:
            dataset = load(file)
            return cls(dataset, Outcome(*json.loads(dataset.attrs["outcome"])))
        except Exception as error:  # HDF5, its readers and JSON have each their own
            raise ValueError(f"{file} is no result of a run, or damaged: {error or type(error).__name__}") from error

    @property
    def scenario(self) -> str:
        """Name of the scenario."""
        return str(self.signals.attrs["scenario"])

    @cached_property
    def summary(self) -> Summary:
        """Key values of the run, with units in the documentation of `Summary`."""
        from amb_cosim.results.summary import summarise

        return summarise(self.signals)

    @property
    def plot(self) -> Plots:
        """Figures of the run: `plot.orbits()`, `displacement`, `contact`, `whirl`, `magnets`, ...; `interactive()`."""
        from amb_cosim.results.plots import Plots

        return Plots(self.signals)

    def save(self, folder: str | Path, plots: bool = True) -> Path:
        """Write `result.nc`, `summary.json` and, if wanted, the figures that suit the run; return the folder."""
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        self._save(folder / RESULT)
        text = self.summary.to_json()
        write_atomically(folder / SUMMARY, lambda path: path.write_text(text, encoding="utf-8"))
        if plots:
            from amb_cosim.results.plots import draw_all

            draw_all(self.signals, folder)
        return folder

    def __repr__(self) -> str:
        return f"<Result of {self.scenario}: {self.outcome}; {len(self.dataset.data_vars)} variables>"

    def _repr_html_(self) -> str:
        from amb_cosim.results.notebook import html_of

        return html_of(self.signals, self.summary, self.outcome)
