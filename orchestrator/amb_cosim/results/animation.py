"""Animation of a run: the rotor's centre at each bearing within the clearance, with a trail."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.units import force_unit, length_unit, spin_text
from amb_cosim.results.contact_forces import peaks
from amb_cosim.results.orbits import radius
from amb_cosim.results.series import cycles, speed
from amb_files.atomic import write_atomically

if TYPE_CHECKING:
    from matplotlib.animation import AbstractMovieWriter
    from matplotlib.figure import Figure

FORMATS = (".gif", ".mp4")
MOST_FRAMES = 3000
DOTS_PER_INCH = 100


def animate(
    recorded: Signals,
    path: str | Path,
    *,
    begin: float | None = None,
    end: float | None = None,
    frames_per_cycle: float = 20.0,
    frames_per_second: int = 25,
    trail: float = 1.0,
) -> Path:
    """Write an animation of a run's orbits, and return its path.

    Parameters
    ----------
    recorded
        The record of the run: `result.signals` or `result.dataset`.
    path
        File to write, `.gif`, or `.mp4` if the program ffmpeg is installed.
    begin, end
        First and last cycle to show; default: those of the run.
    frames_per_cycle
        Frames per cycle.
    frames_per_second
        Frames per second.
    trail
        Length of the trail (cycles).

    Raises
    ------
    ValueError
        If the file's name or a number is not allowed, ffmpeg is missing, or the run has no orbit between the cycles.
    OSError
        If the file cannot be written.
    """
    path = Path(path)
    writer = _writer(path, frames_per_second)
    moments = frame_cycles(recorded, begin, end, frames_per_cycle)
    if not 0.0 < trail <= 1e6:
        raise ValueError(f"trail = {trail:g} cycles is not allowed; it must be > 0 cycles and <= 1e6 cycles")
    import matplotlib as mpl

    from amb_cosim.presentation.style import STYLE

    with mpl.rc_context(STYLE):
        scene = Scene(recorded, trail)

        def write(temporary: Path) -> None:
            with writer.saving(scene.figure, str(temporary), DOTS_PER_INCH):
                for cycle in moments:
                    scene.show(float(cycle))
                    writer.grab_frame()

        write_atomically(path, write)
    return path


def frame_cycles(
    recorded: Signals, begin: float | None, end: float | None, frames_per_cycle: float
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the cycle of each picture, shape (n,).

    Raises
    ------
    ValueError
        If the run has no samples between the cycles, or there would be more than `MOST_FRAMES` pictures.
    """
    cycle = cycles(recorded)
    if len(cycle) < 2:
        raise ValueError("the run recorded no motion that could be shown")
    low, high = float(cycle[0]), float(cycle[-1])
    first, last = low if begin is None else begin, high if end is None else end
    if not low - 1.0 <= first < last <= high + 1.0:
        raise ValueError(
            f"cycles {first:g} to {last:g} are not allowed; they must ascend and be within {low:g} to {high:g}, the run"
        )
    if not 0.0 < frames_per_cycle <= MOST_FRAMES:
        raise ValueError(f"frames per cycle = {frames_per_cycle:g} is not allowed; it must be > 0 and <= {MOST_FRAMES}")
    count = math.floor((last - first) * frames_per_cycle) + 1
    if count > MOST_FRAMES:
        raise ValueError(
            f"{count} frames are not allowed; {MOST_FRAMES} are: show fewer cycles, or fewer frames per cycle"
        )
    return np.clip(first + np.arange(count) / frames_per_cycle, low, high)


def _writer(path: Path, frames_per_second: int) -> AbstractMovieWriter:
    """Return what writes the format that a file's name ends with."""
    from matplotlib.animation import FFMpegWriter, PillowWriter

    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"{path} is not an animation; its name must end with {' or '.join(FORMATS)}")
    if not 1 <= frames_per_second <= 100:
        raise ValueError(f"frames per second = {frames_per_second} is not allowed; it must be from 1 to 100")
    if path.suffix.lower() == ".gif":
        return PillowWriter(fps=frames_per_second)
    if shutil.which("ffmpeg") is None:
        raise ValueError(
            f"{path} cannot be written: the program ffmpeg, which writes .mp4, is not installed; .gif does not need it"
        )
    return FFMpegWriter(fps=frames_per_second, codec="libx264", extra_args=["-pix_fmt", "yuv420p"])


class Scene:
    """One frame: for each station the clearance, a trail, the rotor's centre, and the contact force.

    Parameters
    ----------
    recorded
        The record of the run.
    trail
        Length of the trail (cycles).
    """

    def __init__(self, recorded: Signals, trail: float) -> None:
        from amb_cosim.presentation.style import BLUE, ORANGE, StyledFigure, draw_retainer, fitted, set_orbit_axes
        from amb_cosim.results.places import places
        from amb_cosim.results.plots.axes import clearance, mark_axes, orbit_labels, stations

        if not all(radius(recorded, bearing) is not None for bearing in places(recorded).bearings):
            raise ValueError("the run did not record the displacement at all bearings")
        displayed = stations(recorded)
        if not displayed:
            raise ValueError("the rotor has no bearing whose orbit could be shown")
        self.cycles, self.trail = cycles(recorded), trail
        self.speeds = speed(recorded)
        self.name = Path(recorded.attrs["scenario"]).stem
        self.figure: Figure = StyledFigure(figsize=(3.6 * len(displayed), 4.2))
        panels = self.figure.subplots(1, len(displayed), squeeze=False)[0]
        self.figure.subplots_adjust(left=0.75 / (3.6 * len(displayed)), right=0.98, top=0.82, bottom=0.12, wspace=0.25)
        self.title = self.figure.suptitle(" ")
        self.drawn: list[tuple[Any, ...]] = []
        for panel, station in zip(panels, displayed, strict=True):
            path = station.seen(recorded)
            force = peaks(recorded, station.site) if station.site else None
            gap = clearance(recorded, station.site) if station.site else 0.0
            limit = max(float(np.nanmax(np.hypot(*path))), gap)
            unit = length_unit(limit)
            (x, y), c = unit.of(path), gap / unit.size
            if station.site:
                draw_retainer(panel, c)
            (line,) = panel.plot([], [], color=BLUE, lw=0.9)
            (dot,) = panel.plot([], [], "o", color=BLUE, ms=6.0)
            text = panel.text(0.5, 0.5, "", transform=panel.transAxes, ha="center", va="center", color=ORANGE)
            right, up = orbit_labels(recorded, unit.label)
            set_orbit_axes(panel, fitted(station.title, 3.3), 1.14 * limit / unit.size, right)
            mark_axes(panel, recorded)
            panel.set_ylabel(up if panel is panels[0] else "")
            self.drawn.append((x, y, np.zeros(len(x)) if force is None else force, line, dot, text, (BLUE, ORANGE)))
        forces = (float(force.max(initial=0.0)) for _, _, force, *_ in self.drawn)
        self.force_unit = force_unit(max(forces, default=0.0))

    def show(self, cycle: float) -> None:
        """Move everything to its position at a cycle."""
        last = int(np.searchsorted(self.cycles, cycle, side="right"))
        first = int(np.searchsorted(self.cycles, cycle - self.trail))
        last = max(last, first + 1)
        for x, y, force, line, dot, text, (free, touching) in self.drawn:
            line.set_data(x[first:last], y[first:last])
            dot.set_data(x[last - 1 : last], y[last - 1 : last])
            dot.set_color(touching if force[last - 1] > 0.0 else free)
            text.set_text(self._force_text(force[last - 1]) if force[last - 1] > 0.0 else "")
        self.title.set_text(f"{self.name}: cycle {cycle:.2f}, {spin_text(self.speeds[last - 1])}")

    def _force_text(self, force: float) -> str:
        """Return a contact force, with the same decimals in all frames."""
        unit = self.force_unit
        return f"{force / unit.size:.{2 if unit.name == 'kN' else 0}f} {unit.name}"
