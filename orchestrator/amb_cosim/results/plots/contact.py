"""Figures of contact: normal forces, times in contact, and the whirl speed on the retainer bearings."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, NullLocator, ScalarFormatter
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import DASHED, OF_SAMPLES, StyledFigure, samples
from amb_cosim.presentation.units import speed_unit
from amb_cosim.results.contact_forces import is_sampled, received_impulse
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    FIRST_TEXT,
    add_title,
    clearance,
    colour_of,
    fall_interval,
    label_time_axis,
    mark_events,
    name_events,
    plant_signal,
    site_title,
    speed_is_drawn,
    time_values,
    title_padding,
)
from amb_cosim.results.plots.enlarged import large_forces
from amb_cosim.results.plots.forces import (
    ENLARGED_REACH,
    PALE,
    REACH,
    THICK,
    THIN,
    SiteForce,
    draw_forces,
    mark_forces,
    site_force,
)
from amb_cosim.results.signal_arrays import at_every_step, parameters, signal, speed
from amb_cosim.results.touchdown import touchdown
from array_types import Array, Bools

OUTLIERS = 0.01  # fraction of whirl speeds at either end that an axis may exclude
MANY_SPEEDS = 10.0  # whirl over spin speed, from which an axis is logarithmic
MODES = ("free", "sliding", "rolling")


def contact(dataset: Signals) -> Figure:
    """Draw the normal contact force at each touched site, each on its own scale, and the times in contact.

    The first impacts of a fall, or large forces of short duration, are enlarged beside the forces, with the values of
    every step.
    """
    forces, steps = touched_sites(dataset), at_every_step(dataset)
    ratios = (*[3.0] * len(forces), 0.4 * (len(touchable(dataset)) + 1))
    zoom = _zoom(dataset, forces, time_values(steps))
    size = (7.0 if zoom is None else 10.0, max(4.6 * sum(ratios) / 7.6, 3.2))
    figure = StyledFigure(figsize=size, layout="constrained")
    n_columns = 1 if zoom is None else 2
    columns = figure.subplots(len(ratios), n_columns, sharex="col", height_ratios=ratios, squeeze=False).T
    shown = [(time_values(dataset), forces)]
    _draw_column(columns[0], dataset, dataset, forces)
    if zoom is not None:
        forces = forces if steps is dataset else touched_sites(steps)
        shown += [(time_values(steps), forces)]
        _draw_column(columns[1], dataset, steps, forces, _around(time_values(steps), zoom))
        for panel in columns[1]:
            panel.set_title("", loc="left")
        title = "enlarged" if touchdown(dataset) is None else FIRST_TEXT
        columns[1][0].set_title(title, loc="left", pad=title_padding(dataset, highest=True))
        columns[1][-1].set_xlim(zoom)
        columns[1][-1].xaxis.set_major_locator(MaxNLocator(6))
    for column, (times, of_column), reach in zip(columns, shown, (REACH, ENLARGED_REACH), strict=False):
        name_events(column[0], dataset)
        for panel, (site, force) in zip(column, of_column.items(), strict=False):
            mark_forces(panel, [(times, force, colour_of(dataset, site))], reach)
    add_force_legend(figure, [colour_of(dataset, site) for site in forces], [dataset], list(forces))
    add_title(figure, dataset)
    return figure


def touched_sites(dataset: Signals) -> dict[str, SiteForce]:
    """Return the force at each site of `touchable` that the rotor touched."""
    forces = {site: site_force(dataset, site) for site in touchable(dataset)}
    return {site: force for site, force in forces.items() if force is not None}


def add_force_legend(figure: Figure, colours: list[str], runs: list[Signals], sites: list[str]) -> None:
    """Add a legend for the curves of `draw_forces` below a figure."""
    sampled = any(is_sampled(run, site) for run in runs for site in sites)
    pale = samples(colours, lw=THIN, alpha=PALE)
    entries: dict[str, Any] = {
        "averaged over 1 ms, with impact impulses": samples(colours, lw=THICK),
        f"{'force at the samples' if sampled else 'largest in each step'}, without them": pale,
        "largest mean": Line2D([], [], ls="", marker="o", ms=4.5, mfc="white", mec="0.3"),
    }
    figure.legend(list(entries.values()), list(entries), handler_map=OF_SAMPLES, loc="outside lower center", ncols=3)


def _around(times: Array, interval: tuple[float, float]) -> slice:
    """Return the samples within an interval, and one sample on either side of it."""
    first, stop = np.searchsorted(times, interval)
    return slice(max(int(first) - 1, 0), int(stop) + 1)


def _zoom(dataset: Signals, forces: dict[str, SiteForce], times: Array) -> tuple[float, float] | None:
    """Return the limits of the enlarged part on the time axis: the first impacts of a fall, or large forces."""
    if touchdown(dataset) is not None:
        return fall_interval(dataset, times)
    return large_forces(
        time_values(dataset), [values for force in forces.values() for values in (force.peak, force.mean)]
    )


def _draw_column(
    column: NDArray[np.object_],
    dataset: Signals,
    steps: Signals,
    forces: dict[str, SiteForce],
    within: slice = slice(None),
) -> None:
    """Draw the force at each site and, in the lowest panel, times in contact, for the samples `within` of `steps`."""
    *panels, state_panel = column
    times = time_values(steps)[within]
    for panel, (site, force) in zip(panels, forces.items(), strict=True):
        draw_forces(panel, [(times, force.within(within), colour_of(dataset, site))])
        panel.set_title(site_title(dataset, site), loc="left", pad=title_padding(dataset, panel is panels[0]))
        mark_events(panel, dataset)
    state_panel.set_title("In contact", loc="left")
    touching = {site: _in_contact(steps, site)[within] for site in touchable(dataset)}
    _draw_contact_times(state_panel, times, touching, [colour_of(dataset, site) for site in touching])
    mark_events(state_panel, dataset)
    label_time_axis(state_panel, dataset)


def whirl(dataset: Signals) -> Figure:
    """Draw the whirl speed at each touched site except faces, with spin and rolling speed, and the mode of contact.

    The axis covers the whirl of the rotor. The rolling speed, or its range if the spin changes, is also written. If the
    whirl is more than `MANY_SPEEDS` times as fast as the spin, the axis is logarithmic beyond twice the spin speed.
    """
    sites = [site for site in touched_sites(dataset) if site in places(dataset).sites]
    figure = StyledFigure(figsize=(7.0, 2.9 * len(sites)), layout="constrained")
    panels = figure.subplots(2 * len(sites), 1, sharex=True, height_ratios=(3, 1) * len(sites))
    times, unit = time_values(dataset), speed_unit()
    Omega = unit.of(speed(dataset))
    for whirl_panel, mode_panel, site in zip(panels[::2], panels[1::2], sites, strict=True):
        rolling, is_fixed = _rolling_whirl(dataset, site)
        touching = plant_signal(dataset, f"{site}.mode") > 0.0
        whirl_panel.plot(times, Omega, color="black", lw=0.8, ls=":", label="spin speed")
        whirl_panel.plot(times, unit.of(rolling), color="black", lw=0.8, ls=DASHED, label="whirl of rolling")
        whirling = np.where(touching, unit.of(plant_signal(dataset, f"{site}.whirl_speed")), np.nan)
        whirl_panel.plot(times, whirling, ".-", ms=1.5, color=colour_of(dataset, site), label="in contact")
        whirl_panel.set_title(
            site_title(dataset, site), loc="left", pad=title_padding(dataset, whirl_panel is panels[0])
        )
        low, high = _whirl_limits(Omega, whirling)
        _scale_whirl(whirl_panel, low, high, float(np.abs(Omega).max()))
        whirl_panel.set_ylabel(f"whirl ({unit.label})")
        if is_fixed:
            _write_rolling(whirl_panel, unit.of(rolling), unit.label, sweeps=speed_is_drawn(dataset))
        mode_panel.step(times, plant_signal(dataset, f"{site}.mode"), where="post", color="black", lw=0.8)
        mode_panel.set_ylim(-0.4, len(MODES) - 0.6)
        mode_panel.set_yticks(range(len(MODES)), MODES)
        mark_events(whirl_panel, dataset)
        mark_events(mode_panel, dataset)
    handles, labels = panels[0].get_legend_handles_labels()
    handles[-1] = samples(colour_of(dataset, site) for site in sites)
    figure.legend(handles, labels, handler_map=OF_SAMPLES, loc="outside lower center", ncols=len(labels))
    label_time_axis(panels[-1], dataset)
    name_events(panels[0], dataset)
    add_title(figure, dataset)
    return figure


def _rolling_whirl(dataset: Signals, site: str) -> tuple[Array, bool]:
    """Return the whirl speed (rad/s) at which a journal rolls, and whether its retainer has no turning race.

    omega = -(Omega R_s - omega_r (R_s + c))/c                                                     (1)
    """
    radius, c = float(parameters(dataset)[f"{site}.journal_radius"]), clearance(dataset, site)
    race = signal(dataset, f"{site}.race_speed")
    has_race = race is not None and float(parameters(dataset).get(f"{site}.race_inertia", 0.0)) > 0.0
    turning = race if race is not None and has_race else np.zeros(dataset.sizes["time"])
    return -(speed(dataset) * radius - turning * (radius + c)) / c, not has_race


def _write_rolling(panel: Axes, rolling: Array, unit: str, *, sweeps: bool) -> None:
    """Write the whirl speed of rolling at its line or, if it `sweeps` with the spin, its range beside its slow end.

    If it is below the limits of the axis, it is written in the lower right corner, which it could not reach.
    """
    ends = sorted({float(rolling.min()), float(rolling.max())} if sweeps else {float(np.median(rolling))})
    is_below = ends[-1] < panel.get_ylim()[0]
    speeds = " to ".join(f"{speed:z,.0f}" for speed in ends)
    text = f"rolling: {speeds} {unit}{', below' if is_below else ''}".replace("-", "\N{MINUS SIGN}")
    on_the_right = is_below or (sweeps and abs(rolling[-1]) <= abs(rolling[0]))
    x, side = (0.99, "right") if on_the_right else (0.01, "left")
    in_corner = is_below or sweeps
    to_axes = panel.transAxes if in_corner else panel.get_yaxis_transform()
    panel.text(
        x, 0.03 if in_corner else ends[0], text, transform=to_axes, ha=side, va="bottom", fontsize=8, color="0.3"
    )


def _whirl_limits(Omega: Array, whirling: Array) -> tuple[float, float]:
    """Return limits that contain the spin speed, its negative, and whirl speeds but a share `OUTLIERS` at each end."""
    finite = whirling[np.isfinite(whirling)]
    ends = np.quantile(finite, (OUTLIERS, 1.0 - OUTLIERS)) if finite.size else np.zeros(2)
    largest = float(Omega.max(initial=0.0)) or 1.0
    low, high = min(-largest, float(ends[0])), max(largest, float(ends[1]))
    return low - 0.12 * (high - low), high + 0.12 * (high - low)


def _scale_whirl(panel: Axes, low: float, high: float, spin: float) -> None:
    """Set the limits of a whirl axis; make it logarithmic beyond twice the spin speed if the whirl is much faster."""
    fastest = max(-low, high)
    if 0.0 < MANY_SPEEDS * spin < fastest:
        panel.set_yscale("symlog", linthresh=2.0 * spin)
        decades = 10.0 ** np.arange(np.floor(np.log10(spin)), np.log10(fastest))
        sizes = [step * decade for decade in decades for step in (1.0, 3.0) if step * decade > spin]
        panel.set_yticks([0.0, *sizes, *(-size for size in sizes)])
        panel.yaxis.set_major_formatter(ScalarFormatter())
        panel.yaxis.set_minor_locator(NullLocator())
        low, high = 1.6 * low, 1.6 * high
    panel.set_ylim(low, high)


def _draw_contact_times(panel: Axes, times: Array, touching: dict[str, Bools], colours: list[str]) -> None:
    """Draw a bar for each site over the times in contact; the bar of the first site is at the top."""
    rows = range(len(touching))
    for row, of_site, colour in zip(reversed(rows), touching.values(), colours, strict=True):
        if of_site.any():
            panel.fill_between(times, row - 0.3, row + 0.3, where=of_site, step="pre", color=colour, lw=0.3)
        else:
            place: dict[str, Any] = {"transform": panel.get_yaxis_transform(), "ha": "left", "va": "center"}
            panel.text(0.01, row, "no contact", fontsize=7, color="0.3", **place)
    panel.set_ylim(-0.6, len(touching) - 0.4)
    panel.set_yticks(list(reversed(rows)), [name_label(site) for site in touching])


def _in_contact(dataset: Signals, site: str) -> Bools:
    """Return whether the rotor is in contact at each sample, or received an impulse in the step before it."""
    touching = np.asarray(plant_signal(dataset, f"{site}.mode") > 0.0)
    received = received_impulse(dataset, site)
    if received is not None:
        touching[1:] |= np.diff(received) > 0.0
    return touching
