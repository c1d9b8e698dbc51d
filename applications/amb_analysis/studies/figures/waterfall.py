"""Spectra of a run as they change over time."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from amb_analysis.studies.run_spectra import Waterfall
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import BLUE, StyledFigure, write_title
from amb_cosim.presentation.units import frequency_label, frequency_unit, length_unit, speed_unit, spin_label

HEIGHT = 0.22  # height of the largest stacked amplitude, over the axis
MARKS, BESIDE = 12, 0.03  # marks at the frequency of rotation; their distance from it over the axis
FLOOR = 1e-4  # smallest amplitude with a colour, over the largest


def draw(result: Waterfall) -> Figure:
    """Draw the stacked spectra, a colour map, and the peak hold for each bearing."""
    figure = StyledFigure(figsize=(11.0, 3.6 * len(result.bearings) + 0.4), layout="constrained")
    rows = figure.subplots(len(result.bearings), 3, squeeze=False, sharex=True)
    cycles = frequency_unit()
    frequencies = cycles.of_hertz(result.frequencies)
    spins = speed_unit().of_hertz(result.spin_frequencies)
    place, label = (spins, spin_label()) if result.changing_speed else (result.times, "time (s)")
    # A speed that rises and falls does not order the windows: then time is the axis.
    if result.changing_speed and not np.all(np.diff(place) >= 0.0):
        place, label = result.times, "time (s)"
    unit = length_unit(max(float(spectra.amplitude.max()) for spectra in result.bearings.values()))
    for (stacked, coloured, held), (name, spectra) in zip(rows, result.bearings.items(), strict=True):
        amplitude = unit.of(spectra.amplitude)
        _stack(stacked, frequencies, place, amplitude, unit.label)
        floor = FLOOR * float(amplitude.max())
        mesh = coloured.pcolormesh(
            frequencies,
            place,
            np.maximum(amplitude, floor),
            norm=LogNorm(floor),
            cmap="viridis",
            rasterized=True,
        )
        figure.colorbar(mesh, ax=coloured, label=f"amplitude ({unit.label})")
        held.semilogy(frequencies, unit.of(spectra.peak_hold), color=BLUE)
        held.set(ylabel=f"largest amplitude ({unit.label})", ylim=(floor, None))
        held.grid(color="0.9", lw=0.5)
        for axes, colour in ((stacked, "0.2"), (coloured, "white")):
            _point_at_rotation(axes, cycles.of_hertz(result.spin_frequencies), place, colour)
            axes.set_ylabel(label)
        stacked.set_title(f"{name_label(name)}: spectra")
        coloured.set_title(f"{name_label(name)}: as a map")
        held.set_title(f"{name_label(name)}: peak hold")
    for axes in rows[-1]:
        axes.set(xlabel=f"{frequency_label()}, forward > 0", xlim=(frequencies[0], frequencies[-1]))
    write_title(
        figure,
        f"{result.scenario}: spectra of x + jy, windows of {result.window:.3g} s\n"
        "triangles mark the spin frequency, forward and backward",
    )
    return figure


def _point_at_rotation(axes: Axes, rotation: np.ndarray, place: np.ndarray, colour: str) -> None:
    """Draw marks that point at the ridges of forward and backward whirl at the frequency of rotation."""
    every = max(len(place) // MARKS, 1)
    low, high = axes.get_xlim()
    for sign, marker in ((1.0, "<"), (-1.0, ">")):
        beside = sign * (rotation[::every] + BESIDE * (high - low))
        axes.plot(beside, place[::every], ls="", marker=marker, ms=3.0, color=colour, mew=0.0, zorder=6)


def _stack(axes: Axes, frequencies: np.ndarray, place: np.ndarray, amplitude: np.ndarray, unit: str) -> None:
    """Draw the stacked spectra, with the last one at the back, and a scale bar."""
    span = float(place[-1] - place[0]) or 1.0
    largest = float(amplitude.max() or 1.0)
    scale = HEIGHT * span / largest
    for k in range(len(place))[::-1]:
        line = place[k] + scale * amplitude[k]
        axes.fill_between(frequencies, place[k], line, color="white", lw=0.0)
        axes.plot(frequencies, line, color=BLUE, lw=0.6)
    axes.set_ylim(float(place[0]), float(place[-1]) + HEIGHT * span)
    axes.set_yticks([tick for tick in axes.get_yticks() if place[0] <= tick <= place[-1]])  # none above the run
    bar = 10.0 ** math.floor(math.log10(largest))
    bar *= 5.0 if 5.0 * bar <= largest else 2.0 if 2.0 * bar <= largest else 1.0
    x, top = 0.965, float(place[-1]) + 0.96 * HEIGHT * span
    at = axes.get_yaxis_transform()
    axes.plot([x, x], [top - scale * bar, top], transform=at, color="black", lw=2.0, solid_capstyle="butt")
    axes.text(x - 0.015, top - 0.5 * scale * bar, f"{bar:g} {unit}", transform=at, ha="right", va="center", fontsize=8)
