"""What the figures share: style, colours, and the horizontal axis in cycles, or in seconds where the speed changes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from amb_cosim.series import BEARINGS, cycles, signal, speed, switched_on

# A palette that colour-blind readers can tell apart (Okabe and Ito).
GREY, ORANGE, BLUE, GREEN, PURPLE = "#999999", "#D55E00", "#0072B2", "#009E73", "#CC79A7"
SITE_COLOURS = {"rb1": BLUE, "rb2": ORANGE}

STYLE: dict[Any, Any] = {
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "lines.linewidth": 0.9,
    "legend.frameon": False,
}


def plant(dataset: xr.Dataset, name: str) -> NDArray[np.float64]:
    """Samples of a variable of the plant; NaN if it was not recorded."""
    values = signal(dataset, name)
    if values is None:
        return np.full(dataset.sizes["time"], np.nan)
    return values.astype(np.float64)


def plant_parameter(dataset: xr.Dataset, name: str) -> float:
    """A parameter of the plant, as the run had it."""
    return float(json.loads(dataset.attrs["parameters"])["rotor_contact"][name])


def clearance(dataset: xr.Dataset, site: str) -> float:
    """Radial clearance of a retainer bearing in m."""
    return plant_parameter(dataset, f"{site}.clearance")


def headline(figure: Figure, dataset: xr.Dataset) -> None:
    """Name of the scenario and its speed."""
    speeds = speed(dataset)
    name = Path(dataset.attrs["scenario"]).stem
    changing = "speed_profile" in dataset.attrs
    text = f"{speeds[0]:.4g} to {speeds[-1]:.4g}" if changing else f"{speeds[0]:.4g}"
    figure.suptitle(f"{name}, $\\Omega$ = {text} rad/s", fontsize=10.5)


def titled(site: str) -> str:
    return f"Retainer bearing {site.upper()} at {BEARINGS[site].upper()}"


def abscissa(dataset: xr.Dataset) -> NDArray[np.float64]:
    """Where each sample stands on the horizontal axis."""
    return cycles(dataset) * _unit(dataset)


def _unit(dataset: xr.Dataset) -> float:
    """Length of a cycle on the horizontal axis."""
    return float(dataset.attrs["period_s"]) if "speed_profile" in dataset.attrs else 1.0


def _window(dataset: xr.Dataset) -> tuple[float, float]:
    """What to show: what the scenario asks for, or the whole run."""
    if "plot_cycles" in dataset.attrs:
        begin, end = dataset.attrs["plot_cycles"]
        return float(begin) * _unit(dataset), float(end) * _unit(dataset)
    begin, end = float(abscissa(dataset)[0]), float(abscissa(dataset)[-1])
    # A run ends at the communication point nearest to a whole cycle; that cycle's tick belongs to the axis.
    return begin, float(round(end)) if abs(end - round(end)) < 0.05 and round(end) > begin else end


def label_abscissa(axis: Axes, dataset: xr.Dataset) -> None:
    """Name and limit the horizontal axis."""
    begin, end = _window(dataset)
    axis.set_xlabel("time (s)" if "speed_profile" in dataset.attrs else "synchronous cycles")
    if end > begin:
        axis.set_xlim(begin, end)
    axis.xaxis.set_major_locator(MaxNLocator(10, integer=end - begin > 3.0, steps=[1, 2, 5, 10]))


def _marks(dataset: xr.Dataset) -> dict[str, float]:
    """Where the step comes and goes and ROLAC begins, as far as it is shown."""
    begin, end = _window(dataset)
    happens = {label: dataset.attrs.get(f"{label}_cycle") for label in ("step", "removal")}
    happens["ROLAC"] = switched_on(dataset)
    marks = {label: float(cycle) * _unit(dataset) for label, cycle in happens.items() if cycle is not None}
    return {label: at for label, at in marks.items() if begin <= at <= end}


def title_pad(dataset: xr.Dataset, highest: bool) -> float | None:
    """Distance of an axis's title: the names of marks stand below that of the highest axis."""
    return 14.0 if highest and _marks(dataset) else None


def mark(axis: Axes, dataset: xr.Dataset, named: bool) -> None:
    """Vertical lines where the step comes and goes and ROLAC begins."""
    for label, at in _marks(dataset).items():
        axis.axvline(at, color="0.45", lw=0.8, ls=":")
        if named:
            axis.annotate(
                label,
                (at, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 2),
                textcoords="offset points",
                ha="center",
                va="bottom",
                fontsize=8,
                color="0.3",
            )
