"""Distribution of a sweep's largest contact force at each phase of an event within a turn."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from amb_cosim.presentation.style import BLUE, ORANGE, STYLE, StyledFigure, fitted, write_png, write_title
from amb_files.atomic import plain_file
from amb_sweeps.axes import is_phase
from amb_sweeps.maps import MOST_PANELS, add_legend, failed_sample, in_display_unit, mark_failed
from amb_sweeps.outcomes import BROKEN_OFF
from amb_sweeps.panels import descriptions, numeric_axes, panels, words_of
from amb_sweeps.sampling import SAMPLE
from array_types import Array

if TYPE_CHECKING:
    import xarray as xr

    from amb_sweeps.run import Sweep

METRIC = "averaged_contact_force"
QUANTILES = (0.0, 0.25, 0.5, 0.75, 1.0)
_BEYOND = 1e300  # N, instead of infinity, which cannot be interpolated
FILE = "phase.png"
LEGEND = 1.4  # inches, width of the title of the legend


def draw_phases(swept: Sweep) -> list[str]:
    """Plot the contact force against an event's phase, if this varies, into the sweep's folder; return file names."""
    dataset = swept.dataset
    varied = [str(name) for name in dataset.coords if is_phase(str(name))]
    if not varied or METRIC not in dataset or not dataset[METRIC].notnull().any():
        return []
    write_png(draw_distribution(swept, dataset, varied[0]), plain_file(swept.folder, FILE))
    return [FILE]


@mpl.rc_context(STYLE)
def draw_distribution(swept: Sweep, dataset: xr.Dataset, along: str) -> StyledFigure:
    """Draw the median, quartiles and extremes of the contact force against `along`, an event's cycle, shown in degrees.

    The distribution covers all other numeric variations; each alternative has its own panel. For a sample, each point
    is drawn.
    """
    parts = panels(swept.design, numeric_axes(swept.design), descriptions(dataset))[:MOST_PANELS]
    figure = StyledFigure(figsize=(max(4.6, 3.0 * len(parts) + 0.8), 3.2), layout="constrained")
    axes = figure.subplots(1, len(parts), squeeze=False, sharey=True)[0]
    dataset, label = in_display_unit(dataset, METRIC)
    top = 1.05 * float(dataset[METRIC].max()) or 1.0  # height at which infinite values are drawn
    for ax, panel in zip(axes, parts, strict=True):
        part = dataset.isel(panel.at)
        phase = phase_of(part[along].values)
        if SAMPLE in part.dims:
            ax.plot(phase, part[METRIC].values.ravel(), ".", ms=3.0, color=BLUE)
        else:
            is_run = [bool((part["outcome"].isel({along: k}) != "").any()) for k in range(len(phase))]
            _draw_band(ax, phase[is_run], np.minimum(distribution(part.isel({along: is_run}), along), top))
        mark_failed(ax, part.assign_coords({along: part[along].copy(data=phase)}), [along])
        ax.set_title(fitted(panel.title, 2.8))
        ax.set_xlabel(f"phase of the {along.partition('.')[0].replace('_', ' ')} (deg)")
        ax.set_xticks(np.arange(0.0, phase.max() + 1.0, 90.0))
    axes[0].set_ylim(0.0, top)
    axes[0].set_ylabel(label)
    handles, labels = axes[0].get_legend_handles_labels()
    if handles:
        others = [str(name) for name in numeric_axes(swept.design) if name != along]
        words = " and ".join(words_of(name, descriptions(dataset).get(name, "")) for name in others)
        title = fitted(f"over all values: {words}", LEGEND) if words else None
        figure.legend(handles, labels, loc="outside right center", frameon=False, title=title)
    add_legend(figure, failed_sample(dataset))
    write_title(figure, swept.title)
    return figure


def phase_of(cycle: NDArray[Any]) -> Array:
    """Return cycles as rotor angles (deg), counted from the beginning of the turn that contains the first cycle."""
    return np.asarray(360.0 * (cycle - np.floor(np.min(cycle))), np.float64)


def distribution(part: xr.Dataset, along: str) -> Array:
    """Return the `QUANTILES` of the largest contact force along an axis, shape (quantiles, points).

    Failed runs rank last, so a quantile that falls on a failed run is infinite.
    """

    def rows(values: xr.DataArray) -> NDArray[Any]:
        return np.asarray(values.transpose(along, ...).values.reshape(values.sizes[along], -1))

    table = np.where(rows(part["outcome"].isin(BROKEN_OFF)), _BEYOND, rows(part[METRIC]))
    result = np.nanquantile(np.asarray(table, np.float64), QUANTILES, axis=1)
    return np.where(result > 1e-100 * _BEYOND, np.inf, result)


def _draw_band(ax: Axes, phase: NDArray[Any], bands: Array) -> None:
    lowest, lower, median, upper, highest = bands
    if not np.array_equal(lowest, highest):
        ax.fill_between(phase, lowest, highest, color=BLUE, alpha=0.15, lw=0.0, label="all")
        ax.fill_between(phase, lower, upper, color=BLUE, alpha=0.35, lw=0.0, label="middle half")
    ax.plot(phase, median, ".-", color=ORANGE, label="median")
