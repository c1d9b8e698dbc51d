"""Figures of contact: normal forces, contact states, and the whirl speed on the retainer bearings."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import DASHED, GREY, StyledFigure
from amb_cosim.presentation.units import force_unit, speed_unit
from amb_cosim.results.contact_forces import averaged_force, is_sampled, peaks
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    add_title,
    clearance,
    colour_of,
    label_time_axis,
    mark_events,
    plant_parameter,
    plant_signal,
    site_title,
    time_values,
    title_padding,
)
from amb_cosim.results.series import speed

OUTLIERS = 0.01  # share of whirl speeds at either end of their order that an axis may leave out
MODES = ("free", "sliding", "rolling")


def contact(dataset: Signals) -> Figure:
    """Draw the normal contact force at each retainer bearing and each other site touched, and the contact state."""
    sites, states, bearings = touchable(dataset), places(dataset).contact_states, places(dataset).bearings
    bearings_alone = set(sites) == set(bearings.values())  # a bearing without a retainer has states that never come
    ratios = (*[3.0] * len(sites), 0.4 * (len(states) if bearings_alone else len(sites) + 1))
    figure = StyledFigure(figsize=(7.0, max(4.6 * sum(ratios) / 7.6, 3.2)), layout="constrained")
    *panels, state_panel = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
    forces = {site: [_values(dataset, of(dataset, site)) for of in (peaks, averaged_force)] for site in sites}
    highest = float(np.nanmax([values for result in forces.values() for values in result], initial=0.0))
    unit = force_unit(highest)
    for panel, site in zip(panels, sites, strict=True):
        force, averaged = forces[site]
        panel.plot(time_values(dataset), unit.of(averaged), color="black", lw=0.8)
        panel.plot(time_values(dataset), unit.of(force), color=colour_of(dataset, site))
        panel.set_title(site_title(dataset, site), loc="left", pad=title_padding(dataset, panel is panels[0]))
        panel.set_ylabel(f"$N$ ({unit.label})")
        if not force.any() and not averaged.any():
            _write_no_contact(panel)
        mark_events(panel, dataset, named=panel is panels[0])
    for panel in panels:
        panel.set_ylim(0.0, 1.08 * (highest / unit.size or 1.0))
    handles = [Line2D([], [], color=GREY, label=_meaning(dataset, sites))]
    handles.append(Line2D([], [], color="black", lw=0.8, label="averaged over 1 ms, impacts included"))
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    state_panel.set_title("Contact state" if bearings_alone else "In contact", loc="left")
    if bearings_alone:
        _draw_states(state_panel, dataset, "contact_state", states)
    else:
        _draw_contact_times(state_panel, dataset, sites)
    mark_events(state_panel, dataset, named=False)
    label_time_axis(state_panel, dataset)
    add_title(figure, dataset)
    return figure


def _meaning(dataset: Signals, sites: list[str]) -> str:
    """Return what the coloured curves show."""
    sampled = any(is_sampled(dataset, site) for site in sites)
    return "force at the samples" if sampled else "largest force in each step"


def _values(dataset: Signals, force: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """Return a force; NaN if it was not recorded."""
    return np.full(dataset.sizes["time"], np.nan) if force is None else force


def whirl(dataset: Signals) -> Figure:
    """Draw the whirl speed at each site of `touchable`, with spin speed and rolling speed, and the mode of contact.

    The axis holds what the rotor does; a rolling speed that it is far from is written.
    """
    sites = touchable(dataset)
    figure = StyledFigure(figsize=(7.0, 2.9 * len(sites)), layout="constrained")
    panels = figure.subplots(2 * len(sites), 1, sharex=True, height_ratios=(3, 1) * len(sites))
    times, unit = time_values(dataset), speed_unit()
    Omega = unit.of(speed(dataset))
    for whirl_panel, mode_panel, site in zip(panels[::2], panels[1::2], sites, strict=True):
        rolling = -plant_parameter(dataset, f"{site}.journal_radius") / clearance(dataset, site) * Omega
        closed = plant_signal(dataset, f"{site}.mode") > 0.0
        whirl_panel.plot(times, Omega, color="black", lw=0.8, ls=":", label=r"$+\Omega$")
        whirl_panel.plot(times, rolling, color="black", lw=0.8, ls=DASHED, label=r"rolling, $-(R_s/C_r)\,\Omega$")
        whirling = np.where(closed, unit.of(plant_signal(dataset, f"{site}.whirl_speed")), np.nan)
        whirl_panel.plot(times, whirling, ".-", ms=1.5, color=colour_of(dataset, site), label="in contact")
        whirl_panel.set_title(
            site_title(dataset, site), loc="left", pad=title_padding(dataset, whirl_panel is panels[0])
        )
        low, high = _whirl_limits(Omega, whirling)
        whirl_panel.set(ylabel=f"whirl ({unit.label})", ylim=(low, high))
        if np.median(rolling) < low:
            text = f"rolling: {np.median(rolling):,.0f} {unit.label}, below".replace("-", "\N{MINUS SIGN}")
            whirl_panel.text(0.99, 0.03, text, transform=whirl_panel.transAxes, ha="right", fontsize=8, color="0.3")
        if not closed.any():
            _write_no_contact(whirl_panel)
        _draw_states(mode_panel, dataset, f"{site}.mode", MODES)
        mark_events(whirl_panel, dataset, named=whirl_panel is panels[0])
        mark_events(mode_panel, dataset, named=False)
    handles, labels = panels[0].get_legend_handles_labels()
    handles[-1] = panels[0].plot([], [], color=GREY)[0]
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    label_time_axis(panels[-1], dataset)
    add_title(figure, dataset)
    return figure


def _whirl_limits(Omega: NDArray[np.float64], whirling: NDArray[np.float64]) -> tuple[float, float]:
    """Return limits that hold the spin speed, its opposite, and all whirl speeds but `OUTLIERS` at either end."""
    result = whirling[np.isfinite(whirling)]
    ends = np.quantile(result, (OUTLIERS, 1.0 - OUTLIERS)) if result.size else np.zeros(2)
    largest = float(Omega.max(initial=0.0)) or 1.0
    low, high = min(-largest, float(ends[0])), max(largest, float(ends[1]))
    return low - 0.12 * (high - low), high + 0.12 * (high - low)


def _draw_states(panel: Axes, dataset: Signals, name: str, states: tuple[str, ...]) -> None:
    """Draw a variable with few values over time, with a name for each value."""
    panel.step(time_values(dataset), plant_signal(dataset, name), where="post", color="black", lw=0.8)
    panel.set_ylim(-0.4, len(states) - 0.6)
    panel.set_yticks(range(len(states)), states)


def _draw_contact_times(panel: Axes, dataset: Signals, sites: list[str]) -> None:
    """Draw a bar for each site while the rotor is in contact there; the first site is the highest."""
    times, rows = time_values(dataset), range(len(sites))
    for row, site in zip(reversed(rows), sites, strict=True):
        closed = plant_signal(dataset, f"{site}.mode") > 0.0
        colour = colour_of(dataset, site)
        panel.fill_between(times, row - 0.3, row + 0.3, where=closed, step="pre", color=colour, lw=0.0)
    panel.set_ylim(-0.6, len(sites) - 0.4)
    panel.set_yticks(list(reversed(rows)), [site.upper() for site in sites])


def _write_no_contact(panel: Axes) -> None:
    """Write into an empty panel that there was no contact."""
    panel.text(0.25, 0.5, "no contact", transform=panel.transAxes, ha="center", color="0.3", fontsize=8)
