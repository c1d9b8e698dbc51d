"""Figure of any variables of a run over time, one panel per unit or set of named values."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import common_words
from amb_cosim.presentation.style import COLOURS, StyledFigure, fitted, write_in_corner, write_title
from amb_cosim.presentation.units import QUANTITIES, ShownUnit, force_unit, length_unit, speed_unit
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    add_title,
    label_time_axis,
    mark_events,
    name_events,
    time_values,
    title_padding,
)
from amb_cosim.results.selection import Selection
from amb_cosim.results.signal_arrays import LARGEST, finite_signals, flags, thinning
from array_types import Array

MOST_NAMED = 8  # curves of a panel that its legend names
MARGIN = 0.3  # of a panel with named values, below the first and above the last
CONTACT_STATE, PLACES = f"{PLANT}.contact_state", "places"  # a variable, and the attribute that names its values
Scale = tuple[str, tuple[tuple[int, str], ...]]  # unit, and values with their names; none if they have no names


def traces(selection: Selection) -> Figure:
    """Draw variables over cycles, or over time if the speed changes, in one panel with named curves for each unit.

    Enumerations have a panel for each set of names, which are its ticks, and Booleans share a panel. Variables of a
    system without a scenario, which has no cycles, are drawn over time.
    """
    dataset, panels_of = finite_signals(selection.dataset)[0], _by_scale(selection)
    figure = StyledFigure(figsize=(7.6, 1.0 + 2.2 * len(panels_of)), layout="constrained")
    panels = figure.subplots(len(panels_of), 1, sharex=True, squeeze=False)[:, 0]
    has_cycles = "scenario" in dataset.attrs
    times = time_values(dataset)[selection.within] if has_cycles else selection.values("time")
    for panel, (scale, names) in zip(panels, panels_of.items(), strict=True):
        curves = _draw_curves(panel, selection, times, scale, names, COLOURS)
        padding = title_padding(dataset, panel is panels[0]) if has_cycles else None
        panel.set_title(fitted(_heading(selection, names), 6.4), loc="left", pad=padding)
        if not np.isfinite(curves).any():
            panel.text(0.5, 0.5, "no finite value", transform=panel.transAxes, ha="center", fontsize=8, color="0.3")
        _name_curves(panel, len(names))
    if (every := thinning(dataset)) > 1:
        write_in_corner(panels[0], f"one sample per {every} steps; fast vibration looks slow")
    if has_cycles:
        label_time_axis(panels[-1], dataset)
        for panel in panels:
            mark_events(panel, dataset)
        add_title(figure, dataset)
    else:
        panels[-1].set_xlabel("time (s)")
        write_title(figure, str(dataset.attrs.get("system", "")))
    if len(times) > 1:
        panels[-1].set_xlim(times[0], times[-1])
    if has_cycles:
        name_events(panels[0], dataset)
    return figure


def traces_on(axes: Axes, selection: Selection) -> Axes:
    """Draw variables of one unit over cycles or time on axes of the user, in the user's style; return the axes.

    Colours are those of the axes' cycle. The title and the legend are left to the user: each curve has a label.

    Raises
    ------
    ValueError
        If the variables have more than one unit or set of named values.
    """
    dataset, panels_of = finite_signals(selection.dataset)[0], _by_scale(selection)
    if len(panels_of) > 1:
        units = ", ".join(unit for unit, _ in panels_of)
        raise ValueError(f"ax can show variables of one unit, and these have {len(panels_of)} ({units}); name others")
    has_cycles = "scenario" in dataset.attrs
    times = time_values(dataset)[selection.within] if has_cycles else selection.values("time")
    ((scale, names),) = panels_of.items()
    _draw_curves(axes, selection, times, scale, names, None)
    if has_cycles:
        label_time_axis(axes, dataset)
    else:
        axes.set_xlabel("time (s)")
    if len(times) > 1:
        axes.set_xlim(times[0], times[-1])
    return axes


def _draw_curves(
    panel: Axes, selection: Selection, times: Array, scale: Scale, names: list[str], colours: Sequence[str] | None
) -> list[Array]:
    """Draw variables with a common scale, label the vertical axis, and return the drawn values in SI units.

    Without colours, those of the panel's cycle are used.
    """
    unit, values = scale
    curves = [_drawn(selection.values(name)) for name in names]
    display_unit = _display_unit(unit, max(float(np.nanmax(np.abs(curve), initial=0.0)) for curve in curves))
    for name, curve, colour in zip(names, curves, cycle(colours or (None,)), strict=False):
        panel.plot(times, display_unit.of(curve), color=colour, label=_short(names, name))
    if values:
        panel.set_yticks([number for number, _ in values], [word for _, word in values])
        panel.set_ylim(values[0][0] - MARGIN, values[-1][0] + MARGIN)
    else:
        panel.set_ylabel("dimensionless" if unit == "1" else display_unit.label)
    return curves


def _drawn(values: Array) -> Array:
    """Return values with gaps (NaN) where they are not finite, or too large for the limits of an axis."""
    return np.where(np.abs(values) <= LARGEST, values, np.nan)


def _by_scale(selection: Selection) -> dict[Scale, list[str]]:
    """Return the names of the variables, grouped by scale, in order."""
    result: dict[Scale, list[str]] = {}
    for name in selection.names:
        result.setdefault((selection.unit(name), _named_values(selection.dataset, name)), []).append(name)
    return result


def _named_values(dataset: Signals, name: str) -> tuple[tuple[int, str], ...]:
    """Return the values of an Enumeration, a Boolean or the contact state, in order and with their names."""
    if named := flags(dataset, name):
        return tuple(sorted(named.items()))
    if dataset[name].values.dtype == np.int8:
        return ((0, "false"), (1, "true"))
    return tuple(enumerate(places(dataset).contact_states)) if name == CONTACT_STATE and PLACES in dataset.attrs else ()


def _display_unit(unit: str, largest: float) -> ShownUnit:
    """Return the display unit for values up to `largest` in an SI unit."""
    quantity = QUANTITIES.get(unit, "")
    if quantity == "speed":
        return speed_unit(unit)
    if unit == "m":
        return length_unit(largest)
    return force_unit(largest) if unit == "N" else ShownUnit(unit, 1.0)


def _short(names: list[str], name: str) -> str:
    """Return a name without its component if all names have the same component."""
    return name.partition(".")[2] if len({other.partition(".")[0] for other in names}) == 1 else name


def _heading(selection: Selection, names: list[str]) -> str:
    """Return a heading: a description, the common first words of several descriptions, or the number of variables."""
    if len(names) == 1:
        description = str(selection.dataset[names[0]].attrs.get("description", ""))
        return f"{names[0]}: {description}" if description else names[0]
    if common := common_words([str(selection.dataset[name].attrs.get("description", "")) for name in names]):
        return common
    components = {name.partition(".")[0] for name in names}
    return f"{len(names)} variables of {', '.join(sorted(components))}"


def _name_curves(panel: Axes, count: int) -> None:
    if 1 < count <= MOST_NAMED:
        panel.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    elif count > MOST_NAMED:
        panel.text(
            0.99, 0.97, f"{count} curves", transform=panel.transAxes, ha="right", va="top", fontsize=8, color="0.3"
        )
