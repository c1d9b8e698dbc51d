"""Figure of the magnets: control currents and forces of each axis, with their limits."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import BLUE, DASHED, GREEN, ORANGE, StyledFigure, write_in_corner
from amb_cosim.presentation.units import force_unit
from amb_cosim.results.component_names import ACTUATOR
from amb_cosim.results.magnet_limits import (
    Limits,
    amplifier_off,
    current_limits,
    demanded_current,
    force_limits,
    is_magnetic,
    magnet_force,
)
from amb_cosim.results.places import places
from amb_cosim.results.plots.axes import (
    add_title,
    label_time_axis,
    mark_events,
    name_events,
    time_values,
    title_padding,
)
from amb_cosim.results.signal_arrays import parameters
from array_types import Array

AXES = {"x": BLUE, "y": ORANGE, "z": GREEN}
LIMIT = "limit (force: rotor centred)"
UNPOWERED = "0.9"
ROUNDING = 1e-9  # A, or the unit of forces; a smaller range has no scale of its own
NEAR = 0.4  # fraction of a limit above which it is drawn; otherwise it is written


def magnets(dataset: Signals) -> Figure:
    """Draw the control current and the force of each axis of each magnetic bearing, with their limits.

    While the amplifier of an axis is off, the figure shows no current, whatever the controller demands.
    Times at which no amplifier of a bearing has power are shaded.
    """
    at = places(dataset)
    axes = {bearing: at.directions(bearing) for bearing in at.magnets if is_magnetic(dataset, bearing)}
    figure = StyledFigure(figsize=(9.0, 1.9 * len(axes) + 0.9), layout="constrained")
    panels = figure.subplots(len(axes), 2, sharex=True, squeeze=False)
    forces = [magnet_force(dataset, f"{bearing}.{axis}") for bearing, of in axes.items() for axis in of]
    unit = force_unit(max((float(np.nanmax(np.abs(f), initial=0.0)) for f in forces if f is not None), default=0.0))
    force = "force" if parameters(dataset, ACTUATOR).get("total_force") else "force beyond the static load"
    for row, bearing in zip(panels, axes, strict=True):
        for panel, what, of, limits, size, label in (
            (row[0], "demanded control current", demanded_current, current_limits, 1.0, "A"),
            (row[1], force, magnet_force, force_limits, unit.size, unit.label),
        ):
            values = {axis: of(dataset, f"{bearing}.{axis}") for axis in axes[bearing]}
            for axis, series in values.items():
                if series is not None:
                    panel.plot(time_values(dataset), series / size, color=AXES[axis], lw=0.7)
            bounds = [limits(dataset, f"{bearing}.{axis}") for axis in axes[bearing]]
            _draw_limits(panel, [b for b in bounds if b is not None], values.values(), size, label)
            panel.set_ylabel(f"{'force' if of is magnet_force else 'current'} ({label})")
            if of is demanded_current:
                _shade(panel, dataset, bearing, axes[bearing])
            title = f"{name_label(bearing)}: {what}"
            panel.set_title(title, loc="left", pad=title_padding(dataset, bearing == next(iter(axes))))
            mark_events(panel, dataset)
    for panel in panels[-1]:
        label_time_axis(panel, dataset)
    for panel in panels[0]:
        name_events(panel, dataset)
    drawn = dict.fromkeys("".join(axes.values()))
    handles: list[Artist] = [Line2D([], [], color=AXES[axis], label=axis) for axis in drawn]
    handles.append(Line2D([], [], color="black", ls=DASHED, label=LIMIT))
    if any(amplifier_off(dataset, f"{bearing}.{axis}").any() for bearing, of in axes.items() for axis in of):
        handles.append(Patch(color=UNPOWERED, label="amplifiers off"))
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    figure.align_ylabels(panels)
    add_title(figure, dataset)
    return figure


def _shade(panel: Axes, dataset: Signals, bearing: str, axes: str) -> None:
    """Shade the times at which no amplifier of a bearing has power."""
    off = np.all([amplifier_off(dataset, f"{bearing}.{axis}") for axis in axes], axis=0)
    to_axes = panel.get_xaxis_transform()
    panel.fill_between(time_values(dataset), 0.0, 1.0, where=off, transform=to_axes, color=UNPOWERED, lw=0.0, zorder=-2)


def _draw_limits(panel: Axes, bounds: list[Limits], values: Iterable[Array | None], size: float, unit: str) -> None:
    """Draw the limits that values approach, and write distant limits as text."""
    drawn = np.ravel([series / size for series in values if series is not None])
    low, high = float(np.nanmin(drawn, initial=0.0)), float(np.nanmax(drawn, initial=0.0))
    far: dict[str, None] = {}  # limits of several axes that are written alike, once
    for limit in sorted({bound / size for pair in bounds for bound in pair}):
        if (high >= NEAR * limit) if limit > 0.0 else (low <= NEAR * limit):
            panel.axhline(limit, color="black", lw=0.9, ls=DASHED)
            low, high = min(low, limit), max(high, limit)
        else:
            far[f"{limit:.4g}".replace("-", "\N{MINUS SIGN}")] = None
    margin = 0.08 * (high - low) if high - low > ROUNDING else 1.0
    panel.set_ylim(low - margin, high + margin * (2.5 if far else 1.0))
    if far:
        write_in_corner(panel, f"limit{'s' * (len(far) > 1)} {', '.join(far)} {unit}")
