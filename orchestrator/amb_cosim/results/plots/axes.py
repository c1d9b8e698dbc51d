"""Parts that the figures of a run share: titles, and the time axis in cycles, or in seconds if the speed changes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from amb_cosim.cosim.choices import ROLES
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import BLUE, GREEN, ORANGE, PURPLE, SKY_BLUE, YELLOW, write_title
from amb_cosim.presentation.units import speed_unit, spin_text, with_speeds_in
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.orbits import directions, path, turned_upright, upright
from amb_cosim.results.places import places
from amb_cosim.results.plots.enlarged import FIRST, first_impacts
from amb_cosim.results.signal_arrays import cycles, event_name, parameters, signal, speed, speed_changes, switched_on
from array_types import Array

EVENT_SIZE = 8.0  # points, of the names of events
CONSTANT = 0.002  # relative change of a spin speed too small to draw
WHOLE = 0.9  # of the run; a part that is longer is not enlarged
FEW = 20  # samples; a part with fewer is not enlarged, since straight lines would join them
FIRST_TEXT = f"first impacts, {1e3 * FIRST:g} ms"
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY_BLUE, YELLOW)


def plant_signal(dataset: Signals, name: str) -> Array:
    """Return the samples of a variable of the plant; NaN if it was not recorded."""
    values = signal(dataset, name)
    if values is None:
        return np.full(dataset.sizes["time"], np.nan)
    return values.astype(np.float64)


def clearance(dataset: Signals, site: str) -> float:
    """Return the radial clearance of a retainer bearing (m)."""
    return float(parameters(dataset)[f"{site}.clearance"])


def add_title(figure: Figure, dataset: Signals) -> None:
    """Write the scenario's name, spin speed and description above the figure, with all speeds in the same unit."""
    speeds = speed(dataset)
    name = Path(dataset.attrs["scenario"]).stem
    ends = (speeds[0], speeds[-1]) if speed_is_drawn(dataset) else (speeds[0],)
    description = with_speeds_in(dataset.attrs.get("description", ""), speed_unit())
    write_title(figure, f"{name}, {spin_text(*ends)}\n{description}")


def orbit_labels(dataset: Signals, unit: str) -> tuple[str, str]:
    """Return the axis labels of an orbit: horizontal and vertical if `upright` turns it, and x and y otherwise."""
    right, up = (f"${name}$" if len(name) == 1 else name for name in directions(dataset))
    return f"{right} ({unit})", f"{up} ({unit})"


def mark_axes(panel: Axes, dataset: Signals) -> None:
    """Mark the directions x and y of the magnets at the edge of an orbit that was turned upright."""
    if upright(dataset) == 1.0:
        return
    limit = panel.get_xlim()[1]
    for name, direction in (("x", 1.0), ("y", 1.0j)):
        axis = upright(dataset) * direction
        end = (
            limit * min(0.93 / max(abs(axis.real), abs(axis.imag)), 1.07) * axis
        )  # outside the ring where there is room
        panel.plot([0.0, end.real], [0.0, end.imag], color="0.75", lw=0.5, zorder=0.4)
        panel.text(end.real, end.imag, f"${name}$", fontsize=7, color="0.45", ha="center", va="center")


def speed_is_drawn(dataset: Signals) -> bool:
    """Return whether the spin speed changes by more than `CONSTANT` of its largest value."""
    speeds = speed(dataset)
    return speed_changes(dataset) and bool(np.ptp(speeds) > CONSTANT * np.abs(speeds).max(initial=0.0))


@dataclass(frozen=True)
class Station:
    """A place on the rotor whose motion is plotted: a bearing or a contact site; `site` is its contact site, if any."""

    title: str
    place: str
    site: str

    def path(self, dataset: Signals) -> Array:
        """Return x and y (m) at each sample, as `orbits.path` does, shape (2, n); NaN if they were not recorded."""
        result = path(dataset, self.place)
        return np.full((2, dataset.sizes["time"]), np.nan) if result is None else result

    def seen(self, dataset: Signals) -> Array:
        """Return `path` (m) with the components to the right and upwards, as a picture shows it, shape (2, n)."""
        return turned_upright(dataset, self.path(dataset))


def stations(dataset: Signals) -> list[Station]:
    """Return a station for each bearing, at its retainer if any, and for each other contact site of `touchable`."""
    rotor = places(dataset)
    bearings = [Station(bearing_title(dataset, b), site or b, site) for b, site in rotor.bearings.items()]
    others = (site for site in touchable(dataset) if site not in rotor.retainers and path(dataset, site) is not None)
    return [*bearings, *(Station(site_title(dataset, site), site, site) for site in others)]


def site_title(dataset: Signals, site: str) -> str:
    """Return the kind of a contact site (unless its name states it), its name, and its position if it is known."""
    result = places(dataset)
    kind = "Retainer" if site in result.retainers or site in result.second else "Contact site"
    kind = "Face" if site in result.faces else kind
    z = result.z.get(site)
    named = name_label(site) if site.startswith(kind.lower()) else f"{kind} {name_label(site)}"
    return named if z is None else f"{named} " + f"at $z$ = {z:.4g} m".replace(" ", "\N{NO-BREAK SPACE}")


def bearing_title(dataset: Signals, bearing: str) -> str:
    """Return the title of a bearing's retainer, or the name of a bearing that has none."""
    site = places(dataset).bearings[bearing]
    return site_title(dataset, site) if site else f"Bearing {name_label(bearing)}"


def colour_of(dataset: Signals, site: str) -> str:
    """Return the colour of a contact site in all figures."""
    return COLOURS[places(dataset).contacts.index(site) % len(COLOURS)]


def time_values(dataset: Signals) -> Array:
    """Return the position of each sample on the time axis: its cycle, or its time (s) if the speed changes."""
    return cycles(dataset) * _cycle_length(dataset)


def at_time(dataset: Signals, time: float) -> float:
    """Return the position of a time (s) on the time axis."""
    return time / float(dataset.attrs["period_s"]) * _cycle_length(dataset)


def fall_interval(dataset: Signals, times: Array | None = None) -> tuple[float, float] | None:
    """Return the limits of the time axis between which the first impacts of a fall are enlarged.

    The result is None for a run without a fall, or if this part is nearly the whole run or has too few samples for a
    curve. `times` are the positions of the samples of the curves, by default those of the data set.
    """
    first, times = first_impacts(dataset), time_values(dataset) if times is None else times
    if first is None:
        return None
    begin, end = (at_time(dataset, time) for time in first)
    few = np.count_nonzero((begin <= times) & (times <= end)) < FEW
    return (begin, end) if not few and end - begin < WHOLE * (times[-1] - times[0]) else None


def enlarge(panel: Axes, interval: tuple[float, float]) -> None:
    """Limit a panel to a part of its time axis, and to the range of its curves in this part."""
    lines = [np.asarray(line.get_data(), np.float64) for line in panel.lines]
    lines = [line for line in lines if line.shape[1] > 2]  # neither an event nor a limit
    values = np.concatenate([y[(interval[0] <= x) & (x <= interval[1])] for x, y in lines] or [np.zeros(0)])
    panel.set_xlim(interval)
    panel.xaxis.set_major_locator(MaxNLocator(6))
    if np.isfinite(values).any():
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        margin = 0.08 * (high - low) or 0.08 * abs(high) or 1.0
        panel.set_ylim(low - margin, high + margin)


def _cycle_length(dataset: Signals) -> float:
    """Return the length of a cycle on the time axis."""
    return float(dataset.attrs["period_s"]) if speed_changes(dataset) else 1.0


def _time_limits(dataset: Signals) -> tuple[float, float]:
    """Return the limits of the time axis: those that the scenario sets, or else the limits of the run."""
    if "plot_cycles" in dataset.attrs:
        begin, end = dataset.attrs["plot_cycles"]
        return float(begin) * _cycle_length(dataset), float(end) * _cycle_length(dataset)
    begin, end = float(time_values(dataset)[0]), float(time_values(dataset)[-1])
    # A run ends at the communication point nearest to a whole cycle; the axis reaches to the tick of that cycle.
    return begin, float(round(end)) if abs(end - round(end)) < 0.05 and round(end) > begin else end


def label_time_axis(axes: Axes, dataset: Signals) -> None:
    """Set the label, the limits and the ticks of the time axis."""
    begin, end = _time_limits(dataset)
    axes.set_xlabel("time (s)" if speed_changes(dataset) else "synchronous cycles")
    if end > begin:
        axes.set_xlim(begin, end)
    axes.xaxis.set_major_locator(MaxNLocator(10, integer=end - begin > 3.0, steps=[1, 2, 5, 10]))


def event_times(dataset: Signals) -> dict[str, float]:
    """Return the positions of disturbance, relief and start of ROLAC that are within the limits of the time axis."""
    begin, end = _time_limits(dataset)
    event_cycles = {event_name(dataset, role): dataset.attrs.get(f"{role}_cycle") for role in ROLES}
    event_cycles["ROLAC"] = switched_on(dataset)
    times = {name: float(cycle) * _cycle_length(dataset) for name, cycle in event_cycles.items() if cycle is not None}
    return {name: time for name, time in times.items() if begin <= time <= end}


def title_padding(dataset: Signals, highest: bool) -> float | None:
    """Return the distance (points) of a title from its axes; the highest title leaves room for the names of events."""
    return 14.0 if highest and event_times(dataset) else None


def mark_events(axes: Axes, dataset: Signals) -> None:
    """Draw vertical lines at the disturbance, the relief and the start of ROLAC."""
    draw_events(axes, event_times(dataset).values())


def name_events(axes: Axes, dataset: Signals) -> None:
    """Write the names of the events of `mark_events` above the axes; the limits of the axes must have been set."""
    write_events(axes, event_times(dataset).items())


def draw_events(axes: Axes, times: Iterable[float]) -> None:
    """Draw a vertical line at each event."""
    for time in times:
        axes.axvline(time, color="0.45", lw=0.8, ls=":")


def write_events(axes: Axes, events: Iterable[tuple[str, float]]) -> None:
    """Write the names of events within the axis limits above their positions; names that would overlap share a label.

    A shared label is centred above its events.
    """
    begin, end = axes.get_xlim()
    letter = 0.6 * EVENT_SIZE / 72.0 * axes.figure.dpi / axes.get_window_extent().width * (end - begin)
    labels: list[tuple[str, float, float]] = []  # text, first and last place
    for name, time in sorted(events, key=lambda item: item[1]):
        if not begin <= time <= end:
            continue
        text, first, last = labels[-1] if labels else ("", -np.inf, -np.inf)
        if time - 0.5 * (first + last) >= 0.5 * letter * (len(text) + len(name) + 2):
            labels.append((name, time, time))
        else:
            labels[-1] = (text if name in text.split(", ") else f"{text}, {name}", first, time)
    style: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": EVENT_SIZE, "color": "0.3"}
    for text, first, last in labels:
        place = (0.5 * (first + last), 0.999)
        axes.annotate(text, place, (0, 2), xycoords=("data", "axes fraction"), textcoords="offset points", **style)
