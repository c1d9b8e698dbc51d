"""What happens in contact: forces and states, and how fast the rotor whirls along its retainers."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_cosim.plots.axes import (
    GREY,
    SITE_COLOURS,
    abscissa,
    clearance,
    headline,
    label_abscissa,
    mark,
    plant,
    plant_parameter,
    title_pad,
    titled,
)
from amb_cosim.series import BEARINGS, speed

STATES = ("none", "RB1", "RB2", "both")
MODES = ("free", "sliding", "rolling")


def contact(dataset: xr.Dataset) -> Figure:
    """Normal contact force at both bearings, and the contact state."""
    figure = Figure(figsize=(7.0, 4.6), layout="constrained")
    force_axes = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 1.6))
    *axes, state_axis = force_axes
    highest = 1e-3
    for axis, site in zip(axes, BEARINGS, strict=True):
        force = 1e-3 * plant(dataset, f"{site}.f_n")
        highest = max(highest, float(force.max()))
        axis.plot(abscissa(dataset), force, color=SITE_COLOURS[site])
        axis.set_title(titled(site), loc="left", pad=title_pad(dataset, axis is axes[0]))
        axis.set_ylabel("$N$ (kN)")
        if not force.any():
            _say_no_contact(axis)
        mark(axis, dataset, named=axis is axes[0])
    for axis in axes:
        axis.set_ylim(0.0, 1.08 * highest)
    state_axis.set_title("Contact state", loc="left")
    _draw_states(state_axis, dataset, "contact_state", STATES)
    mark(state_axis, dataset, named=False)
    label_abscissa(state_axis, dataset)
    headline(figure, dataset)
    return figure


def whirl(dataset: xr.Dataset) -> Figure:
    """Whirl speed at both bearings, between that of the spin and that of rolling, and the mode of contact."""
    figure = Figure(figsize=(7.0, 5.8), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True, height_ratios=(3, 1, 3, 1))
    at, Omega = abscissa(dataset), speed(dataset)
    for above, mode_axis, site in zip(axes[::2], axes[1::2], BEARINGS, strict=True):
        rolling = -plant_parameter(dataset, f"{site}.journal_radius") / clearance(dataset, site) * Omega
        closed = plant(dataset, f"{site}.mode") > 0.0
        above.plot(at, Omega, color="black", lw=0.8, ls=":", label=r"$+\Omega$")
        above.plot(at, rolling, color="black", lw=0.8, ls=(0, (4, 2)), label=r"rolling, $-(R_s/C_r)\,\Omega$")
        whirling = np.where(closed, plant(dataset, f"{site}.whirl_speed"), np.nan)
        above.plot(at, whirling, ".-", ms=1.5, color=SITE_COLOURS[site], label="in contact")
        above.set_title(titled(site), loc="left", pad=title_pad(dataset, above is axes[0]))
        above.set(ylabel="whirl (rad/s)", ylim=(1.12 * rolling.min(), -0.12 * rolling.min()))
        if not closed.any():
            _say_no_contact(above)
        _draw_states(mode_axis, dataset, f"{site}.mode", MODES)
        mark(above, dataset, named=above is axes[0])
        mark(mode_axis, dataset, named=False)
    handles, labels = axes[0].get_legend_handles_labels()
    handles[-1] = axes[0].plot([], [], color=GREY)[0]
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    label_abscissa(axes[-1], dataset)
    headline(figure, dataset)
    return figure


def _draw_states(axis: Axes, dataset: xr.Dataset, name: str, states: tuple[str, ...]) -> None:
    axis.step(abscissa(dataset), plant(dataset, name), where="post", color="black", lw=0.8)
    axis.set_ylim(-0.4, len(states) - 0.6)
    axis.set_yticks(range(len(states)), states)


def _say_no_contact(axis: Axes) -> None:
    axis.text(0.25, 0.5, "no contact", transform=axis.transAxes, ha="center", color="0.3", fontsize=8)
