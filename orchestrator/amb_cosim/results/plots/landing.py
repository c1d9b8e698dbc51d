"""A landing in slow motion: orbits in their retainers, the deflected shaft, and the forces that the rotor receives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, FuncAnimation, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Annulus
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import GREY, RETAINER, RING, STYLE, StyledFigure, fitted, set_orbit_axes, write_title
from amb_cosim.presentation.units import ShownUnit, force_unit, length_unit, spin_text
from amb_cosim.results.contact_forces import averaged_force
from amb_cosim.results.orbits import centre, turned_upright
from amb_cosim.results.places import places
from amb_cosim.results.plots import has_motion
from amb_cosim.results.plots.axes import Station, clearance, colour_of, orbit_labels, stations
from amb_cosim.results.plots.enlarged import first_impacts
from amb_cosim.results.power import amplifiers_off
from amb_cosim.results.selection import select
from amb_cosim.results.signal_arrays import finite_signals, speed
from amb_cosim.results.thinned import judged
from amb_cosim.results.touchdown import touchdown
from amb_files.atomic import write_atomically
from array_types import Array, Bools

FRAMES, RATE, DOTS = 100, 15, 80  # at most, frames per second, dots per inch: files of about 1 MB
TRAIL = 20  # frames of the orbit that stay visible
LONGEST_ARROW = 0.7  # of the limit of the axes, for the largest force
FORCE_COLOUR = "crimson"


@dataclass(frozen=True)
class _Journal:
    """A journal in its retainer, to the right and upwards (m): seen from the place of the retainer at rest."""

    station: Station
    gap: float
    ring: Array
    rotor: Array
    force: Array  # N, on the rotor, shape (2, n)


def write_landing(dataset: Signals, path: Path, begin: Raw | None = None, until: Raw | None = None) -> None:
    """Write a landing in slow motion as `.gif`, or as `.mp4` where ffmpeg is installed.

    Without limits, the first impacts are shown, as `first_impacts` selects them. Each frame is a sample of the record:
    nothing is interpolated. The ring of a retainer moves with its mount. The arrows are the normal forces on the rotor,

        F = -N r/|r|,    N: mean over 1 ms with impacts,    r: rotor relative to its retainer

    The length of an arrow grows with sqrt(N), because the first impacts exceed the weight of the rotor a hundred times.

    Parameters
    ----------
    dataset
        The record of the run, with its attributes.
    path
        The file; it is written atomically.
    begin, until
        Beginning and end: a time (s), a text with its unit, or `cycle 5`.

    Raises
    ------
    ValueError
        If the run has no touchdown across the shaft, the range has fewer than two samples, or ffmpeg is missing.
    """
    if path.suffix.lower() == ".mp4" and not FFMpegWriter.isAvailable():
        raise ValueError(f"{path.name} cannot be written without ffmpeg: install ffmpeg, or write a .gif")
    with mpl.rc_context(STYLE):
        animation = landing(dataset, begin, until)[1]
        write_atomically(path, partial(_save, animation))


def _save(animation: FuncAnimation, path: Path) -> None:
    writer: AbstractMovieWriter = (FFMpegWriter if path.suffix.lower() == ".mp4" else PillowWriter)(fps=RATE)
    animation.save(str(path), writer=writer, dpi=DOTS)


def landing(dataset: Signals, begin: Raw | None = None, until: Raw | None = None) -> tuple[Figure, FuncAnimation]:
    """Return the figure of a landing and its animation; see `write_landing`."""
    if "scenario" not in dataset.attrs:
        raise ValueError("landing cannot be drawn: this is the result of a system without a scenario")
    dataset = judged(finite_signals(dataset)[0])
    if not has_motion(dataset):
        raise ValueError("landing cannot be drawn: the run recorded no sample of the rotor's motion at its bearings")
    fall, first = touchdown(dataset), first_impacts(dataset)
    drawn = [station for station in stations(dataset) if station.site]
    if fall is None or first is None or not drawn:
        raise ValueError("landing cannot be drawn: the rotor does not land in a retainer; draw orbits or turns instead")
    sample = _samples(dataset, first if begin is None and until is None else None, begin, until)
    journals = [_journal(dataset, station, sample) for station in drawn]
    times = dataset["time"].values[sample]
    span = float(times[-1] - times[0])
    slower = (len(sample) - 1) / RATE / span
    figure = StyledFigure(figsize=(max(2.1 * len(drawn), 5.0), 5.0), layout="constrained")
    rows = figure.subplot_mosaic(
        [["shaft"] * len(drawn), [station.site for station in drawn]], height_ratios=(1.0, 1.25)
    )
    limit = 1.12 * max(float(np.nanmax(np.abs([*j.rotor, *(np.abs(j.ring) + j.gap)]))) for j in journals)
    unit = length_unit(limit)
    largest = max(float(np.nanmax(np.hypot(*journal.force), initial=0.0)) for journal in journals)
    moving = [_OrbitPanel(rows[j.station.site], dataset, j, unit, limit, largest) for j in journals]
    rows[drawn[0].site].set_ylabel(orbit_labels(dataset, unit.label)[1])
    shaft = _ShaftPanel(rows["shaft"], dataset, journals, unit, limit)
    ends = speed(dataset)[sample[[0, -1]]]
    write_title(figure, f"{Path(dataset.attrs['scenario']).stem}, {spin_text(*ends)}")
    lost = any(off[np.searchsorted(dataset["time"].values[:-1], fall.release)] for off in amplifiers_off(dataset))
    since = "the loss of power" if lost else "the first contact"
    slow = f"shown {slower:.0f} times slower" if slower >= 1.0 else f"shown {1.0 / slower:.0f} times faster"

    def show(frame: int) -> list[object]:
        for panel in moving:
            panel.show(frame)
        shaft.show(frame)
        after = 1e3 * (times[frame] - fall.release)
        rows["shaft"].set_title(f"{after:.1f} ms after {since}, {slow}", loc="left")
        return []

    show(0)
    for _ in range(2):  # the second finds room for the titles that the first wrapped
        figure.draw_without_rendering()
    figure.set_layout_engine("none")
    return figure, FuncAnimation(figure, show, frames=len(sample), blit=False)  # type: ignore[arg-type]


def _samples(
    dataset: Signals, limits: tuple[float, float] | None, begin: Raw | None, until: Raw | None
) -> NDArray[np.int64]:
    """Return at most `FRAMES` samples, evenly spaced, of a range or between limits (s)."""
    within: Bools
    if limits is None:
        within = select(dataset, (), begin, until).within
    else:
        within = (dataset["time"].values >= limits[0]) & (dataset["time"].values <= limits[1])
    chosen = np.flatnonzero(within)
    if len(chosen) < 2:
        raise ValueError(f"landing cannot be drawn: the range has {len(chosen)} sample; it must have at least 2")
    return chosen[np.unique(np.linspace(0, len(chosen) - 1, min(len(chosen), FRAMES)).round().astype(int))]


def _journal(dataset: Signals, station: Station, sample: NDArray[np.int64]) -> _Journal:
    relative = station.seen(dataset)[:, sample]
    ring = turned_upright(dataset, centre(dataset, station.site))
    ring = (ring - ring[:, :1])[:, sample]
    force = averaged_force(dataset, station.site)
    normal = np.zeros(len(sample)) if force is None else np.nan_to_num(force)[sample]
    radius = np.hypot(*relative)
    direction = np.divide(relative, radius, out=np.zeros_like(relative), where=radius > 0.0)
    return _Journal(station, clearance(dataset, station.site), ring, relative + ring, -normal * direction)


class _OrbitPanel:
    """The orbit at a station: its trail, the journal, the ring and the force, which `show` moves."""

    def __init__(
        self, panel: Axes, dataset: Signals, journal: _Journal, unit: ShownUnit, limit: float, largest: float
    ) -> None:
        self._journal, self._unit, self._arrow = journal, unit, LONGEST_ARROW * limit / np.sqrt(largest or 1.0)
        site = journal.station.site
        set_orbit_axes(
            panel, fitted(journal.station.title, 2.0), limit / unit.size, orbit_labels(dataset, unit.label)[0]
        )
        outer = (1.0 + RING) * journal.gap / unit.size
        self._ring = Annulus((0.0, 0.0), outer, RING * journal.gap / unit.size, **RETAINER)
        panel.add_patch(self._ring)
        panel.plot(0.0, 0.0, "+", color=GREY, ms=5.0, mew=0.6)
        colour = colour_of(dataset, site)
        (self._trail,) = panel.plot([], [], color=colour, lw=1.0)
        (self._centre,) = panel.plot([], [], "o", color=colour, ms=5.0)
        options: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1.0, "width": 0.02, "zorder": 3.0}
        self._force = panel.quiver([0.0], [0.0], [0.0], [0.0], color=FORCE_COLOUR, **options)
        self._text = panel.text(0.5, 0.6, "", color=FORCE_COLOUR, ha="center", va="center", fontsize=8.0)
        self._text.set_transform(panel.transAxes)
        self._of = force_unit(largest)

    def show(self, frame: int) -> None:
        """Move all parts to a frame."""
        journal, unit = self._journal, self._unit
        trail, at = unit.of(journal.rotor[:, max(frame - TRAIL, 0) : frame + 1]), unit.of(journal.rotor[:, frame])
        force = journal.force[:, frame]
        size = float(np.hypot(*force))
        self._ring.set_center(tuple(unit.of(journal.ring[:, frame])))
        self._trail.set_data(*trail)
        self._centre.set_data(at[:1], at[1:])
        self._force.set_offsets([at])
        self._force.set_UVC(*([part] for part in unit.of(self._arrow * force / np.sqrt(size or 1.0))))
        self._text.set_text(self._of.text(size, 3) if size > 0.0 else "")


class _ShaftPanel:
    """The shaft from the side: heights of the rotor at its stations, between the edges of their clearances."""

    def __init__(self, panel: Axes, dataset: Signals, journals: list[_Journal], unit: ShownUnit, limit: float) -> None:
        z = places(dataset).z
        self._unit = unit
        known = all(j.station.site in z for j in journals)
        self._z = np.array([z[j.station.site] if known else float(k) for k, j in enumerate(journals)])
        order = np.argsort(self._z)
        self._z, self._journals = self._z[order], [journals[k] for k in order]
        width = 0.03 * (float(np.ptp(self._z)) or 1.0)
        self._edges = []
        for at, journal in zip(self._z, self._journals, strict=True):
            colour = colour_of(dataset, journal.station.site)
            self._edges.append(
                [panel.plot([at - width, at + width], [0.0, 0.0], color="0.45", lw=4.0)[0] for _ in "ab"]
            )
            panel.plot(at, 0.0, "+", color=GREY, ms=5.0, mew=0.6)
            place: dict[str, Any] = {
                "xycoords": ("data", "axes fraction"),
                "ha": "center",
                "va": "top",
                "fontsize": 8.0,
            }
            panel.annotate(name_label(journal.station.site), (at, 0.98), color=colour, **place)
        (self._line,) = panel.plot([], [], color="black", lw=1.5, marker="o", ms=4.0)
        reach = 1.45 * limit / unit.size
        panel.set(ylim=(-reach, reach), ylabel=orbit_labels(dataset, unit.label)[1])
        if known:
            panel.set_xlabel("position along the shaft (m)")
        else:
            panel.set_xticks([])

    def show(self, frame: int) -> None:
        """Move all parts to a frame."""
        self._line.set_data(self._z, [self._unit.of(j.rotor[1, frame]) for j in self._journals])
        for pair, journal in zip(self._edges, self._journals, strict=True):
            for edge, side in zip(pair, (-1.0, 1.0), strict=True):
                height = self._unit.of(journal.ring[1, frame] + side * (1.0 + RING) * journal.gap)
                edge.set_ydata([height, height])
