"""Figures of a run, drawn from its data set alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from orchestrator.results import BEARINGS, cycles, radius, signal, write_atomically

# A palette that colour-blind readers can tell apart (Okabe and Ito).
BEFORE, LOADED, REMOVED = "#999999", "#D55E00", "#0072B2"
SITE_COLOURS = {"rb1": "#0072B2", "rb2": "#D55E00"}
STATES = ("none", "RB1", "RB2", "both")

_STYLE: dict[Any, Any] = {
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


def draw_all(dataset: xr.Dataset, folder: Path) -> list[Path]:
    """Draw every figure that the data set has the signals for, and return their paths."""
    figures: dict[str, Callable[[xr.Dataset], Figure]] = {
        "orbits": orbits,
        "displacement": displacement,
        "contact": contact,
    }
    paths: list[Path] = []
    if not dataset.sizes["time"] or any(radius(dataset, mb) is None for mb in BEARINGS.values()):
        return paths
    for name, draw in figures.items():
        with mpl.rc_context(_STYLE):
            figure = draw(dataset)
            FigureCanvasAgg(figure)
            path = folder / f"{name}.png"
            write_atomically(path, lambda p, figure=figure: figure.savefig(p, dpi=200))
        paths.append(path)
    return paths


def orbits(dataset: xr.Dataset) -> Figure:
    """Path of the rotor centre at both bearings within the clearance, before, during and after the load."""
    figure = Figure(figsize=(7.0, 3.9), layout="constrained")
    limit = 1.1 * max([1e3 * clearance(dataset, site) for site in BEARINGS] + _largest_coordinates(dataset))
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for axis, (site, mb) in zip(axes, BEARINGS.items(), strict=True):
        x, y = 1e3 * _plant(dataset, f"{mb}.x"), 1e3 * _plant(dataset, f"{mb}.y")
        angle = np.linspace(0.0, 2.0 * np.pi, 361)
        c = 1e3 * clearance(dataset, site)
        axis.plot(
            c * np.cos(angle), c * np.sin(angle), color="black", lw=1.0, ls=(0, (4, 2)), zorder=3, label="clearance"
        )
        for label, colour, within in phases(dataset):
            axis.plot(np.where(within, x, np.nan), np.where(within, y, np.nan), color=colour, lw=0.7, label=label)
        axis.set(title=_titled(site), xlabel="$x$ (mm)", xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal")
        axis.xaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        axis.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
    axes[0].set_ylabel("$y$ (mm)")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    _headline(figure, dataset)
    return figure


def displacement(dataset: xr.Dataset) -> Figure:
    """Radial displacement over clearance against synchronous cycles at both bearings."""
    figure = Figure(figsize=(7.0, 4.2), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True, sharey=True)
    for axis, (site, mb) in zip(axes, BEARINGS.items(), strict=True):
        r = radius(dataset, mb)
        assert r is not None
        axis.axhline(1.0, color="black", lw=1.0, ls=(0, (4, 2)))
        axis.plot(cycles(dataset), r / clearance(dataset, site), color=SITE_COLOURS[site])
        axis.set_title(_titled(site), loc="left", pad=14 if axis is axes[0] else None)
        axis.set(ylabel="radius / clearance", ylim=(0.0, None))
        _mark(axis, dataset, named=axis is axes[0])
    _label_cycles(axes[-1], dataset)
    _headline(figure, dataset)
    return figure


def contact(dataset: xr.Dataset) -> Figure:
    """Normal contact force at both bearings, and the contact state, against synchronous cycles."""
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    force_axes = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 1.6))
    *axes, state_axis = force_axes
    highest = 1e-3
    for axis, site in zip(axes, BEARINGS, strict=True):
        force = 1e-3 * _plant(dataset, f"{site}.f_n")
        highest = max(highest, float(force.max()))
        axis.plot(cycles(dataset), force, color=SITE_COLOURS[site])
        axis.set_title(_titled(site), loc="left", pad=14 if axis is axes[0] else None)
        axis.set_ylabel("$N$ (kN)")
        if not force.any():
            axis.text(0.25, 0.5, "no contact", transform=axis.transAxes, ha="center", color="0.3", fontsize=8)
        _mark(axis, dataset, named=axis is axes[0])
    for axis in axes:
        axis.set_ylim(0.0, 1.08 * highest)
    state_axis.step(cycles(dataset), _plant(dataset, "contact_state"), where="post", color="black", lw=0.8)
    state_axis.set_title("Contact state", loc="left")
    state_axis.set_ylim(-0.4, 3.4)
    state_axis.set_yticks(range(4), STATES)
    _mark(state_axis, dataset, named=False)
    _label_cycles(state_axis, dataset)
    _headline(figure, dataset)
    return figure


def phases(dataset: xr.Dataset) -> list[tuple[str, str, NDArray[np.bool_]]]:
    """Name, colour and samples of the parts of a run: before the step, with it, after its removal."""
    cycle = cycles(dataset)
    step, removal = dataset.attrs.get("step_cycle"), dataset.attrs.get("removal_cycle")
    if step is None:
        return [("run", REMOVED, np.ones(len(cycle), dtype=bool))]
    end = np.inf if removal is None else removal
    parts = [
        ("before the step", BEFORE, cycle <= step),
        ("with the added unbalance", LOADED, (cycle >= step) & (cycle <= end)),
    ]
    if removal is not None:
        parts.append(("after its removal", REMOVED, cycle >= removal))
    return parts


def clearance(dataset: xr.Dataset, site: str) -> float:
    """Radial clearance of a retainer bearing in m, as the run had it."""
    return float(json.loads(dataset.attrs["parameters"])["rotor_contact"][f"{site}.clearance"])


def _plant(dataset: xr.Dataset, name: str) -> NDArray[np.float64]:
    values = signal(dataset, name)
    if values is None:
        return np.full(dataset.sizes["time"], np.nan)
    return values.astype(np.float64)


def _largest_coordinates(dataset: xr.Dataset) -> list[float]:
    return [1e3 * float(np.nanmax(np.abs(_plant(dataset, f"{mb}.{a}")))) for mb in BEARINGS.values() for a in "xy"]


def _titled(site: str) -> str:
    return f"Retainer bearing {site.upper()} at {BEARINGS[site].upper()}"


def _headline(figure: Figure, dataset: xr.Dataset) -> None:
    speed = float(dataset.attrs["speed_rad_s"])
    name = Path(dataset.attrs["scenario"]).stem
    figure.suptitle(f"{name}, $\\Omega$ = {speed:.4g} rad/s", fontsize=10.5)


def _window(dataset: xr.Dataset) -> tuple[float, float]:
    """Cycles to show: what the scenario asks for, or the whole run."""
    if "plot_cycles" in dataset.attrs:
        begin, end = dataset.attrs["plot_cycles"]
        return float(begin), float(end)
    begin, end = float(cycles(dataset)[0]), float(cycles(dataset)[-1])
    # A run ends at the communication point nearest to a whole cycle; that cycle's tick belongs to the axis.
    return begin, float(round(end)) if abs(end - round(end)) < 0.05 and round(end) > begin else end


def _label_cycles(axis: Axes, dataset: xr.Dataset) -> None:
    begin, end = _window(dataset)
    axis.set_xlabel("synchronous cycles")
    if end > begin:
        axis.set_xlim(begin, end)
    axis.xaxis.set_major_locator(MaxNLocator(10, integer=end - begin > 3.0, steps=[1, 2, 5, 10]))


def _mark(axis: Axes, dataset: xr.Dataset, named: bool) -> None:
    """Vertical lines where the step comes and goes."""
    begin, end = _window(dataset)
    for label in ("step", "removal"):
        cycle = dataset.attrs.get(f"{label}_cycle")
        if cycle is None or not begin <= cycle <= end:
            continue
        axis.axvline(cycle, color="0.45", lw=0.8, ls=":")
        if named:
            axis.annotate(
                label,
                (cycle, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 2),
                textcoords="offset points",
                ha="center",
                va="bottom",
                fontsize=8,
                color="0.3",
            )
