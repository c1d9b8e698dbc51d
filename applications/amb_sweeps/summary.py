"""Summary of a sweep: outcomes, largest forces, boundary and failures."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.units import force_unit
from amb_sweeps.landing_answers import landing_lines
from amb_sweeps.outcomes import BROKEN_OFF, COLOURS
from amb_sweeps.panels import descriptions, numeric_axes, panels, value_text
from amb_sweeps.refine import boundary_group, refined_axes
from amb_sweeps.sampling import SAMPLE, SamplePlan
from amb_sweeps.store import STORE, open_sweep

if TYPE_CHECKING:
    import xarray as xr

MOST_REASONS = 5
FORCES = {
    "averaged_contact_force": "largest contact force (1 ms mean with impacts)",
    "peak_contact_force": "largest force between impacts",
}


def summarise_sweep(dataset: xr.Dataset, design: SamplePlan, folder: Path, boundary: str) -> list[str]:
    """Return the answers and outcomes of each alternative, then lines on boundary, sensitivities and failures, if any.

    Parameters
    ----------
    dataset, design, folder, boundary
        Results, points, folder and boundary of a `Sweep`.
    """
    parts = panels(design, numeric_axes(design), descriptions(dataset))
    lines = []
    for panel in parts:
        part = dataset.isel(panel.at)
        before = f"{panel.title}: " if panel.title else ""
        lines += [before + line for line in landing_lines(design, part)]
        lines.append(_alternative_line(panel.title, part))
    return [
        *lines,
        *_late_event_lines(dataset),
        *_branching_lines(dataset),
        *_boundary_lines(folder, design, boundary),
        *_sensitivity_lines(design, dataset),
        *_failure_lines(dataset),
        *_metric_lines(dataset),
    ]


def _alternative_line(title: str, part: xr.Dataset) -> str:
    """Return the number of runs with each outcome, worst outcome first, and the largest forces."""
    outcomes = part["outcome"].values
    counts = {name: int(np.sum(outcomes == name)) for name in COLOURS}
    numbers = [f"{count} {name or 'not run yet'}" for name, count in counts.items() if count]
    forces = "".join(_force(part, metric, words) for metric, words in FORCES.items())
    return f"{title + ': ' if title else ''}{outcomes.size} runs, {', '.join(numbers)}{forces}"


def _force(part: xr.Dataset, metric: str, words: str) -> str:
    """Return the largest value of a force metric, with its site and point, as text for the end of a line."""
    if metric not in part or not part[metric].notnull().any() or not float(part[metric].max()):
        return ""
    values = part[metric].values
    index = np.unravel_index(np.nanargmax(values), values.shape)
    point = part.isel(dict(zip(part[metric].dims, (int(k) for k in index), strict=True)))
    largest = float(values[index])
    sites = [str(name) for name in part if str(name).startswith(f"{metric}.") and float(point[name]) == largest]
    at_site = "".join(f" at {name_label(name.removeprefix(f'{metric}.'))}" for name in sites[:1])
    numbers = [name for name in part.coords if part[name].ndim and np.issubdtype(part[name].dtype, np.number)]
    where = [value_text(str(name), point[name].item(), point[name].attrs.get("units", "")) for name in numbers]
    qualification = ", unknown for aborted runs," if np.isin(part["outcome"].values, BROKEN_OFF).any() else ""
    return f"; {words}{qualification} up to {force_unit(largest).text(largest)}{at_site}, with {', '.join(where)}"


def _late_event_lines(dataset: xr.Dataset) -> list[str]:
    """Return a line on the runs that end before an event of their scenario, if any."""
    count = int(dataset["late_events"].notnull().sum()) if "late_events" in dataset else 0
    if not count:
        return []
    return [f"{count} of {dataset['outcome'].size} runs end before an event, which has no effect there (late_events)"]


def _branching_lines(dataset: xr.Dataset) -> list[str]:
    if "shared" not in dataset or not float(dataset["shared"].fillna(0.0).max()):
        return []
    return [f"{100.0 * float(dataset['shared'].mean()):.3g} % of all steps were shared with earlier points"]


def _boundary_lines(folder: Path, design: SamplePlan, boundary: str) -> list[str]:
    group = boundary_group(boundary)
    if not (folder / STORE / group).is_dir():
        return []
    points = open_sweep(folder, group)
    tolerance, runs = float(points.attrs["tolerance"]), int(points.attrs["runs"])
    bisected = {axis.name for axis in refined_axes(design)}
    equivalent_grid = math.prod(math.ceil(1.0 / tolerance) + 1 if a.name in bisected else len(a) for a in design.axes)
    return [
        f"boundary of {boundary}: {points.sizes['point']} points, to within {100.0 * tolerance:.3g} % of an axis; "
        f"{runs} additional runs, {design.size + runs} in total; an equally fine grid would take {equivalent_grid} runs"
    ]


def _sensitivity_lines(design: SamplePlan, dataset: xr.Dataset) -> list[str]:
    if not design.sampling.startswith("saltelli:") or [a.name for a in design.axes] != [SAMPLE]:
        return []
    from amb_sweeps.sensitivity import sensitivity

    try:
        indices = sensitivity(design, dataset)
    except ValueError as error:
        return [f"no sensitivities: {error}"]
    lines, quantity = [], FORCES[indices.attrs["metric"]]
    for name in indices["parameter"].values:
        row = indices.sel(parameter=name)
        first, total = (f"{float(row[k]):.2f} +- {float(row[f'{k}_conf']):.2f}" for k in ("S1", "ST"))
        lines.append(f"{quantity} over {name}: first-order index {first}, total {total}")
    return lines


def _failure_lines(dataset: xr.Dataset) -> list[str]:
    """Return the reasons for failed runs, most frequent first."""
    failed = np.isin(dataset["outcome"].values, BROKEN_OFF)
    return [f"{count} of the runs: {reason}" for reason, count in _counted(dataset["reason"].values[failed])]


def _metric_lines(dataset: xr.Dataset) -> list[str]:
    """Return the errors of metrics, most frequent first."""
    if "metric_error" not in dataset:
        return []
    errors, of_runs = dataset["metric_error"].values, dataset["outcome"].size
    counted = _counted(errors[errors != ""])
    return [f"{error}; it has no value for {count} of {of_runs} runs, whose outcomes stand" for error, count in counted]


def _counted(texts: NDArray[Any]) -> list[tuple[str, int]]:
    """Return texts and their numbers, most frequent first, at most `MOST_REASONS`."""
    words, counts = np.unique(texts, return_counts=True)
    order = np.argsort(-counts, kind="stable")[:MOST_REASONS]
    return [(str(words[k]), int(counts[k])) for k in order]
