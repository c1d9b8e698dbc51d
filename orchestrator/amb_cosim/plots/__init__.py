"""Figures of a run, drawn from its data set alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path

import matplotlib as mpl
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from amb_cosim.contact_history import rolling_from
from amb_cosim.energies import energies
from amb_cosim.orbits import radius
from amb_cosim.plots.axes import STYLE
from amb_cosim.plots.contact import contact, whirl
from amb_cosim.plots.energy import energy
from amb_cosim.plots.motion import displacement, orbits
from amb_cosim.series import BEARINGS
from amb_files.atomic import write_atomically

FIGURES: dict[str, Callable[[xr.Dataset], Figure]] = {
    "orbits": orbits,
    "displacement": displacement,
    "contact": contact,
    "whirl": whirl,
    "energy": energy,
}


def draw_all(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw the figures of a run that the data set has the signals for, and return their paths."""
    paths: list[Path] = []
    if not dataset.sizes["time"] or any(radius(dataset, mb) is None for mb in BEARINGS.values()):
        return paths
    for name in chosen(dataset):
        with mpl.rc_context(STYLE):
            figure = FIGURES[name](dataset)
            FigureCanvasAgg(figure)
            path = folder / f"{name}.png"
            write_atomically(path, partial(figure.savefig, dpi=200))
        paths.append(path)
    return paths


def chosen(dataset: xr.Dataset) -> list[str]:
    """Names of the figures that the scenario asks for, or that suit the run.

    Orbits overlap while the speed changes, and whirl is worth a look where a site rolls.
    """
    if "plot_figures" in dataset.attrs:
        asked = json.loads(dataset.attrs["plot_figures"])
        return [name for name in asked if name != "energy" or energies(dataset) is not None]
    names = ["displacement", "contact"] if "speed_profile" in dataset.attrs else ["orbits", "displacement", "contact"]
    return names + ["whirl"] * (rolling_from(dataset) is not None)


class Plots:
    """Figures of one run."""

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = dataset
