"""What the figures of a run share: titles, and the time axis in cycles, or in seconds where the speed changes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from amb_cosim.cosim.basics.choices import ROLES
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.style import BLUE, GREEN, ORANGE, PURPLE, SKY_BLUE, TITLE_SIZE, YELLOW
from amb_cosim.presentation.units import spin_text
from amb_cosim.results.contact_history import touchable
from amb_cosim.results.orbits import path
from amb_cosim.results.places import places
from amb_cosim.results.series import cycles, event_name, parameters, signal, speed, speed_changes, switched_on

CONSTANT = 0.002  # relative change of a spin speed that is none to be drawn
COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY_BLUE, YELLOW)


def plant_signal(dataset: Signals, name: str) -> NDArray[np.float64]:
    """Return the samples of a variable of the plant; NaN if it was not recorded."""
    values = signal(dataset, name)
    if values is None:
        return np.full(dataset.sizes["time"], np.nan)
    return values.astype(np.float64)


def plant_parameter(dataset: Signals, name: str) -> float:
    """Return the value that a parameter of the plant had in the run."""
    return float(parameters(dataset)[name])


def clearance(dataset: Signals, site: str) -> float:
    """Return the radial clearance of a retainer bearing (m)."""
    return plant_parameter(dataset, f"{site}.clearance")


def add_title(figure: Figure, dataset: Signals) -> None:
    """Write the name of the scenario and its spin speed above the figure."""
    speeds = speed(dataset)
    name = Path(dataset.attrs["scenario"]).stem
    ends = (speeds[0], speeds[-1]) if speed_is_drawn(dataset) else (speeds[0],)
    figure.suptitle(f"{name}, {spin_text(*ends)}", fontsize=TITLE_SIZE)


def speed_is_drawn(dataset: Signals) -> bool:
    """Return whether the spin speed changes by more than `CONSTANT` of its largest value."""
    speeds = speed(dataset)
    return speed_changes(dataset) and bool(np.ptp(speeds) > CONSTANT * np.abs(speeds).max(initial=0.0))


@dataclass(frozen=True)
class Station:
    """A place on the rotor whose motion is drawn: a bearing, or a contact site, which is its `site` too."""

    title: str
    place: str
    site: str

    def path(self, dataset: Signals) -> NDArray[np.float64]:
        """Return x and y (m) at each sample, see `orbits.path`, shape (2, n); NaN if they were not recorded."""
        result = path(dataset, self.place)
        return np.full((2, dataset.sizes["time"]), np.nan) if result is None else result


def stations(dataset: Signals) -> list[Station]:
    """Return the retainer of each bearing, or the bearing without one, and the other contact sites of `touchable`."""
    result = places(dataset)
    bearings = [Station(bearing_title(dataset, b), site or b, site) for b, site in result.bearings.items()]
    others = (site for site in touchable(dataset) if site not in result.retainers and path(dataset, site) is not None)
    return [*bearings, *(Station(site_title(dataset, site), site, site) for site in others)]


def site_title(dataset: Signals, site: str) -> str:
    """Return the name of a contact site and, of a retainer bearing, of the magnetic bearing that it protects."""
    bearing = places(dataset).retainers.get(site)
    return f"Retainer bearing {site.upper()} at {bearing.upper()}" if bearing else f"Contact site {site.upper()}"


def bearing_title(dataset: Signals, bearing: str) -> str:
    """Return the name of a magnetic bearing, with that of its retainer bearing where it has one."""
    site = places(dataset).bearings[bearing]
    return site_title(dataset, site) if site else f"Bearing {bearing.upper()}"


def colour_of(dataset: Signals, site: str) -> str:
    """Return the colour of a contact site in all figures."""
    return COLOURS[places(dataset).sites.index(site) % len(COLOURS)]


def time_values(dataset: Signals) -> NDArray[np.float64]:
    """Return the place of each sample on the time axis: its cycle, or its time (s) where the speed changes."""
    return cycles(dataset) * _cycle_length(dataset)


def _cycle_length(dataset: Signals) -> float:
    """Return the length of a cycle on the time axis."""
    return float(dataset.attrs["period_s"]) if speed_changes(dataset) else 1.0


def _time_limits(dataset: Signals) -> tuple[float, float]:
    """Return the limits of the time axis: those that the scenario asks for, or those of the run."""
    if "plot_cycles" in dataset.attrs:
        begin, end = dataset.attrs["plot_cycles"]
        return float(begin) * _cycle_length(dataset), float(end) * _cycle_length(dataset)
    begin, end = float(time_values(dataset)[0]), float(time_values(dataset)[-1])
    # A run ends at the communication point nearest to a whole cycle; the axis reaches to the tick of that cycle.
    return begin, float(round(end)) if abs(end - round(end)) < 0.05 and round(end) > begin else end


def label_time_axis(axes: Axes, dataset: Signals) -> None:
    """Set label, limits and ticks of the time axis."""
    begin, end = _time_limits(dataset)
    axes.set_xlabel("time (s)" if speed_changes(dataset) else "synchronous cycles")
    if end > begin:
        axes.set_xlim(begin, end)
    axes.xaxis.set_major_locator(MaxNLocator(10, integer=end - begin > 3.0, steps=[1, 2, 5, 10]))


def _event_times(dataset: Signals) -> dict[str, float]:
    """Return the place on the time axis of disturbance, relief and the start of ROLAC, within the axis' limits."""
    begin, end = _time_limits(dataset)
    event_cycles = {event_name(dataset, role): dataset.attrs.get(f"{role}_cycle") for role in ROLES}
    event_cycles["ROLAC"] = switched_on(dataset)
    times = {name: float(cycle) * _cycle_length(dataset) for name, cycle in event_cycles.items() if cycle is not None}
    return {name: time for name, time in times.items() if begin <= time <= end}


def title_padding(dataset: Signals, highest: bool) -> float | None:
    """Return the distance (points) of a title from its axes: the names of events are written below the highest one."""
    return 14.0 if highest and _event_times(dataset) else None


def mark_events(axes: Axes, dataset: Signals, named: bool) -> None:
    """Draw vertical lines at disturbance, relief and the start of ROLAC, with their names if `named`."""
    for name, time in _event_times(dataset).items():
        axes.axvline(time, color="0.45", lw=0.8, ls=":")
        if named:
            axes.annotate(
                name,
                (time, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 2),
                textcoords="offset points",
                ha="center",
                va="bottom",
                fontsize=8,
                color="0.3",
            )
