"""Figures of contact: normal forces, times in contact, and the whirl speed on the retainer bearings."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import DASHED, OF_SAMPLES, StyledFigure, samples
from amb_cosim.presentation.units import force_unit, speed_unit
from amb_cosim.results.contact_forces import averaged_force, is_sampled, peaks, received_impulse
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.plots.axes import (
    add_title,
    clearance,
    colour_of,
    label_time_axis,
    mark_events,
    plant_signal,
    site_title,
    time_values,
    title_padding,
)
from amb_cosim.results.series import parameters, speed
from array_types import Array, Bools

OUTLIERS = 0.01  # fraction of whirl speeds at either end that an axis may exclude
LARGE = 0.1  # of the largest force
SMALL_PART = 0.15  # of the time, in which large forces are enlarged
MANY = 40  # contacts, from which the first tenth of the time after the first is enlarged
MODES = ("free", "sliding", "rolling")


def contact(dataset: Signals) -> Figure:
    """Draw the normal contact force at each retainer bearing and each other site touched, and when it is in contact."""
    sites = touchable(dataset)
    ratios = (*[3.0] * len(sites), 0.4 * (len(sites) + 1))
    forces = {site: [_values(dataset, of(dataset, site)) for of in (peaks, averaged_force)] for site in sites}
    highest = float(np.nanmax([force for of_site in forces.values() for force in of_site], initial=0.0))
    zoom = _zoom(time_values(dataset), [force for of_site in forces.values() for force in of_site])
    size = (7.0 if zoom is None else 10.0, max(4.6 * sum(ratios) / 7.6, 3.2))
    figure = StyledFigure(figsize=size, layout="constrained")
    n_columns = 1 if zoom is None else 2
    columns = figure.subplots(len(ratios), n_columns, sharex="col", height_ratios=ratios, squeeze=False).T
    for column in columns:
        _draw_column(column, dataset, sites, forces, highest)
    if zoom is not None:
        for panel in columns[1]:
            panel.set_title("", loc="left")
        columns[1][0].set_title("the same, enlarged", loc="left", pad=title_padding(dataset, highest=True))
        columns[1][-1].set_xlim(zoom)
        columns[1][-1].xaxis.set_major_locator(MaxNLocator(6))
    handles: list[Any] = [samples(colour_of(dataset, site) for site in sites), Line2D([], [], color="black", lw=0.8)]
    sampled = any(is_sampled(dataset, site) for site in sites)
    meaning = "force at the samples" if sampled else "largest force in each step"
    labels = [meaning, "averaged over 1 ms, impacts included"]
    figure.legend(handles, labels, handler_map=OF_SAMPLES, loc="outside lower center", ncols=2)
    add_title(figure, dataset)
    return figure


def _zoom(times: Array, forces: list[Array]) -> tuple[float, float] | None:
    """Return limits of a time axis around the large forces where they are but a small part of the run.

    Forces above `LARGE` of the largest are large. If they last longer, the first of `MANY` or more contacts are shown.
    """
    force = np.nanmax(np.abs(np.nan_to_num(forces)), axis=0) if forces else np.zeros(len(times))
    large = times[force > LARGE * force.max(initial=0.0)]
    first, last = (float(large[0]), float(large[-1])) if len(large) > 1 else (0.0, 0.0)
    if len(large) < 2 or last - first > SMALL_PART * (times[-1] - times[0]):
        if np.count_nonzero((force[1:] > 0.0) & (force[:-1] == 0.0)) < MANY:
            return None
        last = first + 0.04 * float(times[-1] - first)
    width = max(last - first, 20.0 * float(times[1] - times[0]))
    return max(first - 0.5 * width, float(times[0])), min(last + 1.5 * width, float(times[-1]))


def _draw_column(
    column: NDArray[np.object_],
    dataset: Signals,
    sites: list[str],
    forces: dict[str, list[Array]],
    highest: float,
) -> None:
    """Draw the force at each site and, in the lowest panel, the contact."""
    unit = force_unit(highest)
    *panels, state_panel = column
    for panel, site in zip(panels, sites, strict=True):
        force, averaged = forces[site]
        panel.plot(time_values(dataset), unit.of(force), color=colour_of(dataset, site), lw=1.6)
        panel.plot(time_values(dataset), unit.of(averaged), color="black", lw=0.6)
        panel.set_title(site_title(dataset, site), loc="left", pad=title_padding(dataset, panel is panels[0]))
        panel.set_ylabel(f"$N$ ({unit.label})")
        if not force.any() and not averaged.any():
            _write_no_contact(panel)
        mark_events(panel, dataset, named=panel is panels[0])
    for panel in panels:
        panel.set_ylim(0.0, 1.08 * (highest / unit.size or 1.0))
    state_panel.set_title("In contact", loc="left")
    _draw_contact_times(state_panel, dataset, sites)
    mark_events(state_panel, dataset, named=False)
    label_time_axis(state_panel, dataset)


def _values(dataset: Signals, force: Array | None) -> Array:
    """Return a force; NaN if it was not recorded."""
    return np.full(dataset.sizes["time"], np.nan) if force is None else force


def whirl(dataset: Signals) -> Figure:
    """Draw the whirl speed at each site of `touchable`, with spin speed and rolling speed, and the mode of contact.

    The axis covers the whirl of the rotor; a distant rolling speed is written instead of drawn.
    """
    sites = touchable(dataset)
    figure = StyledFigure(figsize=(7.0, 2.9 * len(sites)), layout="constrained")
    panels = figure.subplots(2 * len(sites), 1, sharex=True, height_ratios=(3, 1) * len(sites))
    times, unit = time_values(dataset), speed_unit()
    Omega = unit.of(speed(dataset))
    for whirl_panel, mode_panel, site in zip(panels[::2], panels[1::2], sites, strict=True):
        rolling = -float(parameters(dataset)[f"{site}.journal_radius"]) / clearance(dataset, site) * Omega
        touching = plant_signal(dataset, f"{site}.mode") > 0.0
        whirl_panel.plot(times, Omega, color="black", lw=0.8, ls=":", label=r"$+\Omega$")
        whirl_panel.plot(times, rolling, color="black", lw=0.8, ls=DASHED, label=r"rolling, $-(R_s/C_r)\,\Omega$")
        whirling = np.where(touching, unit.of(plant_signal(dataset, f"{site}.whirl_speed")), np.nan)
        whirl_panel.plot(times, whirling, ".-", ms=1.5, color=colour_of(dataset, site), label="in contact")
        whirl_panel.set_title(
            site_title(dataset, site), loc="left", pad=title_padding(dataset, whirl_panel is panels[0])
        )
        low, high = _whirl_limits(Omega, whirling)
        whirl_panel.set(ylabel=f"whirl ({unit.label})", ylim=(low, high))
        if np.median(rolling) < low:
            text = f"rolling: {np.median(rolling):,.0f} {unit.label}, below".replace("-", "\N{MINUS SIGN}")
            whirl_panel.text(0.99, 0.03, text, transform=whirl_panel.transAxes, ha="right", fontsize=8, color="0.3")
        if not touching.any():
            _write_no_contact(whirl_panel)
        mode_panel.step(times, plant_signal(dataset, f"{site}.mode"), where="post", color="black", lw=0.8)
        mode_panel.set_ylim(-0.4, len(MODES) - 0.6)
        mode_panel.set_yticks(range(len(MODES)), MODES)
        mark_events(whirl_panel, dataset, named=whirl_panel is panels[0])
        mark_events(mode_panel, dataset, named=False)
    handles, labels = panels[0].get_legend_handles_labels()
    handles[-1] = samples(colour_of(dataset, site) for site in sites)
    figure.legend(handles, labels, handler_map=OF_SAMPLES, loc="outside lower center", ncols=len(labels))
    label_time_axis(panels[-1], dataset)
    add_title(figure, dataset)
    return figure


def _whirl_limits(Omega: Array, whirling: Array) -> tuple[float, float]:
    """Return limits that include the spin speed, its negative, and all whirl speeds except `OUTLIERS` at either end."""
    finite = whirling[np.isfinite(whirling)]
    ends = np.quantile(finite, (OUTLIERS, 1.0 - OUTLIERS)) if finite.size else np.zeros(2)
    largest = float(Omega.max(initial=0.0)) or 1.0
    low, high = min(-largest, float(ends[0])), max(largest, float(ends[1]))
    return low - 0.12 * (high - low), high + 0.12 * (high - low)


def _draw_contact_times(panel: Axes, dataset: Signals, sites: list[str]) -> None:
    """Draw a bar for each site while the rotor is in contact; the first site is the highest."""
    times, rows = time_values(dataset), range(len(sites))
    for row, site in zip(reversed(rows), sites, strict=True):
        touching, colour = _in_contact(dataset, site), colour_of(dataset, site)
        panel.fill_between(times, row - 0.3, row + 0.3, where=touching, step="pre", color=colour, lw=0.3)
    panel.set_ylim(-0.6, len(sites) - 0.4)
    panel.set_yticks(list(reversed(rows)), [site.upper() for site in sites])


def _in_contact(dataset: Signals, site: str) -> Bools:
    """Return whether the rotor is in contact at each sample, or received an impulse in the step before it."""
    touching = np.asarray(plant_signal(dataset, f"{site}.mode") > 0.0)
    received = received_impulse(dataset, site)
    if received is not None:
        touching[1:] |= np.diff(received) > 0.0
    return touching


def _write_no_contact(panel: Axes) -> None:
    """Write into an empty panel that there was no contact."""
    panel.text(0.25, 0.5, "no contact", transform=panel.transAxes, ha="center", color="0.3", fontsize=8)
