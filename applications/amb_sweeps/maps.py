"""Maps of a sweep: metrics over its axes, one panel per alternative, with the boundary between outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm, Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import MaxNLocator

from amb_cosim.presentation.style import BLUE, ORANGE, SKY_BLUE, STYLE, StyledFigure, fitted, write_png, write_title
from amb_cosim.presentation.units import force_unit, length_unit, speed_unit
from amb_files.atomic import plain_file
from amb_sweeps.axes import is_moment, is_speed
from amb_sweeps.outcomes import BROKEN_OFF, COLOURS
from amb_sweeps.panels import descriptions, numeric_axes, panels, shown_unit, words_of
from amb_sweeps.refine import boundary_group
from amb_sweeps.sampling import SAMPLE
from amb_sweeps.store import STORE, open_sweep
from fmi_export.building.units import to_unit

if TYPE_CHECKING:
    import xarray as xr

    from amb_sweeps.run import Sweep

SPREAD = 100.0  # ratio of largest to smallest positive value above which colours are logarithmic
DRAWN = ("contact_share", "averaged_contact_force", "peak_contact_force", "orbit_largest", "rolling")
LABELS = {
    "contact_share": "fraction of time in contact, from disturbance to relief",
    "averaged_contact_force": "largest contact force, 1 ms mean",
    "peak_contact_force": "largest force between impacts",
    "orbit_largest": "largest radius in bearings and retainers",
    "rolling": "rolling (1) or not (0)",
    "outcome": "outcome",
}
BOUNDARY = {"recovered": "recovered or prevented"}  # in words
EITHER = {"rolling": {"does not roll": SKY_BLUE, "rolls": ORANGE}}  # colours of 0 and 1 of a metric with two values
UNITS = {  # function of the display unit, and unit of the store (SI)
    "averaged_contact_force": (force_unit, 1.0),
    "peak_contact_force": (force_unit, 1.0),
    "orbit_largest": (length_unit, 1e-3),
}
MOST_PANELS, MOST_TICKS = 8, 6
FAILED: dict[str, Any] = {
    "marker": "x",
    "color": "k",
    "ms": 4.0,
    "mew": 0.8,
    "ls": "",
}  # mark of failed runs
OUTLINE = [Stroke(linewidth=2.0, foreground="k"), Normal()]  # of a white line, visible on white


def draw_maps(swept: Sweep) -> list[str]:
    """Plot `outcome` and the metrics of a sweep into its folder, one figure each; return the names of the files.

    The first two numeric axes are the axes of a map; the values of all other axes are shown in up to `MOST_PANELS`
    panels. The points of a sample are shown in the plane of its first two ranges. Crosses mark failed runs.
    """
    dataset = swept.dataset
    names = [
        name for name in ("outcome", *DRAWN) if name == "outcome" or (name in dataset and dataset[name].notnull().any())
    ]
    files = []
    for name in names:
        figure = draw_map(swept, dataset, name)
        files.append(f"{name}.png")
        write_png(figure, plain_file(swept.folder, files[-1]))
    return files


@mpl.rc_context(STYLE)
def draw_map(swept: Sweep, dataset: xr.Dataset, name: str) -> StyledFigure:
    """Draw a variable of a sweep."""
    across = _across(swept)
    dataset, label = in_display_unit(with_speeds_shown(dataset), name)
    parts = panels(swept.design, {*across, SAMPLE}, descriptions(dataset))[:MOST_PANELS]
    width = 3.4 * len(parts) + 1.0
    figure = StyledFigure(figsize=(max(4.6, width), 3.6), layout="constrained")
    axes: Sequence[Axes] = figure.subplots(1, len(parts), squeeze=False, sharey=True)[0]
    scale = _scale(dataset, name)
    drawn: Any = None
    boundary: Line2D | None = None
    for ax, panel in zip(axes, parts, strict=True):
        part = dataset.isel(panel.at)
        mapped = _draw_panel(ax, part, across, name, scale)
        drawn = mapped if mapped is not None else drawn
        if name != "outcome":
            mark_failed(ax, part, across)
        boundary = _draw_boundary(ax, swept, part, across) or boundary
        ax.set_title(fitted(panel.title, 3.2))
        ax.set_xlabel(_axis_label(dataset, across[0]))
        if dataset[across[0]].dtype.kind in "if":
            ax.xaxis.set_major_locator(MaxNLocator(MOST_TICKS, steps=[1, 2, 2.5, 5, 10]))
    axes[0].set_ylabel(_axis_label(dataset, across[1]) if len(across) > 1 else fitted(label, 2.8))
    if name == "outcome":
        occurring = [outcome for outcome in COLOURS if (dataset["outcome"] == outcome).any()]
        handles = [Patch(color=COLOURS[outcome], label=outcome or "not run") for outcome in occurring]
        figure.legend(handles=handles, loc="outside right center", frameon=False)
    elif name in EITHER and drawn is not None:
        handles = [Patch(color=colour, label=words) for words, colour in EITHER[name].items()]
        figure.legend(handles=handles, loc="outside right center", frameon=False)
    elif drawn is not None:
        figure.colorbar(drawn, ax=list(axes), label=fitted(label, 2.8))
    add_legend(figure, [*([boundary] if boundary else []), *(failed_sample(dataset) if name != "outcome" else [])])
    write_title(figure, swept.title)
    return figure


def with_speeds_shown(dataset: xr.Dataset, sweep: xr.Dataset | None = None) -> xr.Dataset:
    """Return a data set with spin speeds in the chosen unit of speeds; missing units are taken from `sweep`."""
    unit, shown = speed_unit(), {}
    for name, speeds in dataset.variables.items():
        if not is_speed(str(name)):
            continue
        attributes = speeds.attrs if sweep is None else sweep[name].attrs
        if stored := attributes.get("units"):
            factor = to_unit(f"1 {stored}", unit.name, str(name))
            shown[name] = (speeds.dims, factor * speeds.values, attributes | {"units": unit.label})
    return dataset.assign(shown)


def in_display_unit(dataset: xr.Dataset, name: str) -> tuple[xr.Dataset, str]:
    """Return a sweep with a metric in its display unit, and the label of the metric."""
    if name not in UNITS:
        return dataset, LABELS[name]
    unit_for, stored_unit = UNITS[name]
    unit = unit_for(stored_unit * float(dataset[name].max()))
    return dataset.assign({name: dataset[name] * (stored_unit / unit.size)}), f"{LABELS[name]} ({unit.label})"


def _across(swept: Sweep) -> list[str]:
    """Return the coordinates of a map's axes, of which there are at most two."""
    numeric = numeric_axes(swept.design)
    if SAMPLE in numeric:
        return [column.name for axis in swept.design.axes if axis.name == SAMPLE for column in axis.columns][:2]
    return numeric[:2] or [swept.design.axes[0].name]


def _scale(dataset: xr.Dataset, name: str) -> Normalize:
    """Return the colour scale; it is logarithmic, and blank at zero, if values span decades."""
    if name == "outcome":
        return Normalize(-0.5, len(COLOURS) - 0.5)
    if name in ("contact_share", "rolling"):
        return Normalize(0.0, 1.0)
    values = dataset[name].values
    largest, positive = float(np.nanmax(values)) or 1.0, values[values > 0.0]
    if positive.size and largest > SPREAD * positive.min():
        return LogNorm(positive.min(), largest)
    return Normalize(0.0, largest)


def _draw_panel(ax: Axes, dataset: xr.Dataset, across: list[str], name: str, scale: Normalize) -> Any:
    """Draw a map, points of a sample, or a line; return the artist for the colour bar."""
    values = dataset[name]
    if name == "outcome":
        numbers = np.array([list(COLOURS).index(str(v)) for v in values.values.ravel()], np.float64)
        values = values.copy(data=numbers.reshape(values.shape))
        colours: Any = ListedColormap(list(COLOURS.values()))
    else:
        colours = ListedColormap(list(EITHER[name].values())) if name in EITHER else "viridis"
    kind = {"norm": scale, "cmap": colours}
    x = dataset[across[0]]
    if len(across) == 1:
        if name == "outcome":
            ax.scatter(x, np.zeros(x.size), c=values, **kind)
            ax.set_yticks([])
        else:
            ax.plot(x, values, ".-", color=BLUE)
            if name == "rolling":
                ax.set(ylim=(-0.05, 1.05), yticks=[0, 1])
        return None
    y = dataset[across[1]]
    if SAMPLE in values.dims:
        return ax.scatter(x, y, c=values, s=8.0, **kind)
    mesh = ax.pcolormesh(x, y, values.transpose(across[1], across[0]), shading="nearest", **kind)
    mesh.set_edgecolor("face")
    return mesh


def mark_failed(ax: Axes, dataset: xr.Dataset, across: Sequence[str]) -> None:
    """Draw a cross at each failed point of a map; in a line plot, draw it above the highest value."""
    failed = dataset["outcome"].isin(BROKEN_OFF)
    if not failed.any():
        return  # the layout would reserve space for a line without points
    places = [dataset[name].broadcast_like(failed).transpose(*failed.dims).values[failed.values] for name in across]
    if len(places) == 1:
        ax.plot(places[0], np.ones_like(places[0]), transform=ax.get_xaxis_transform(), clip_on=False, **FAILED)
    else:
        ax.plot(*places, **FAILED)


def failed_sample(dataset: xr.Dataset) -> list[Line2D]:
    """Return the legend entry for the cross of failed runs, if there are any."""
    count = int(dataset["outcome"].isin(BROKEN_OFF).sum())
    return [Line2D([], [], label=f"failed: {count} of {dataset['outcome'].size}", **FAILED)] if count else []


def add_legend(figure: StyledFigure, handles: list[Line2D]) -> None:
    """Add a legend of marks below a figure."""
    if handles:
        figure.legend(handles=handles, loc="outside lower right", frameon=False, ncols=len(handles))


def _draw_boundary(ax: Axes, swept: Sweep, dataset: xr.Dataset, across: list[str]) -> Line2D | None:
    """Draw a map's boundary (refined points, or a line half-way between grid points) and return its legend entry."""
    if len(across) < 2 or SAMPLE in dataset.dims or swept.boundary not in dataset:
        return None
    label = f"boundary ({BOUNDARY.get(swept.boundary, swept.boundary)})"
    group = boundary_group(swept.boundary)
    if (swept.folder / STORE / group).is_dir():
        points = with_speeds_shown(open_sweep(swept.folder, group), swept.dataset)
        here = np.ones(points.sizes["point"], bool)
        for name in dataset.coords:
            if dataset[name].ndim == 0 and name in points:
                here &= points[name].values == dataset[name].values
        x, y = points[across[0]][here], points[across[1]][here]
        (line,) = ax.plot(x, y, "w.", ms=4.0, mec="k", mew=0.4, label=f"{label}, refined")
        return line
    values = dataset[swept.boundary].transpose(across[1], across[0]).values
    if min(values.shape) > 1 and len(np.unique(values[~np.isnan(values)])) > 1:
        drawn = ax.contour(dataset[across[0]], dataset[across[1]], values, [0.5], colors="w", linewidths=1.2)
        drawn.set_path_effects(OUTLINE)
        return Line2D([], [], color="w", lw=1.2, path_effects=OUTLINE, label=f"{label}, between grid points")
    return None


def _axis_label(dataset: xr.Dataset, name: str) -> str:
    """Return the label of a coordinate: the description or the name of its variable, with the unit."""
    unit, described = (dataset[name].attrs.get(key, "") for key in ("units", "description"))
    words = words_of(name, described) if described or is_moment(name) else name
    return fitted(f"{words} ({shown_unit(unit)})" if unit and unit != "1" else words, 3.6)
