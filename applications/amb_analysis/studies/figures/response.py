"""Computed and measured frequency responses."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from amb_analysis.studies.frequency_responses import ComputedResponse, FrequencyResponses
from amb_cosim.presentation.style import BLUE, GREY, ORANGE, StyledFigure, fitted, write_title
from amb_cosim.presentation.units import frequency_label, frequency_unit, speed_unit
from array_types import Array, Complex

MOST = 6  # responses that are drawn
COLUMNS = 3
PANEL = (3.3, 3.9)  # inches, of a response
SPAN = 1e4  # of amplitudes about their median; a resonance without damping has no height
LINEAR_BELOW = 8.0  # highest over lowest frequency, up to which the axis is linear


def draw(result: FrequencyResponses, label: str = "computed") -> Figure:
    """Draw amplitude, phase and coherence of the first responses, with measured values behind the labelled curves."""
    drawn = list(result.responses.items())[:MOST]
    columns = min(COLUMNS, len(drawn))
    rows = -(-len(drawn) // columns)
    width = max(columns * PANEL[0], 5.2)
    figure = StyledFigure(figsize=(width, rows * PANEL[1] + 0.5), layout="constrained")
    with_coherence = any(item.coherence is not None for _, item in drawn)
    heights = (3, 1.5, 1) if with_coherence else (3, 1.5)
    outer = figure.subfigures(rows, columns, squeeze=False)
    for k, (name, item) in enumerate(drawn):
        part = outer[k // columns, k % columns]
        panels = part.subplots(len(heights), 1, sharex=True, height_ratios=heights)
        _draw_response(panels, name, item, label)
    more = f", {len(drawn)} of {len(result.responses)} responses" if len(result.responses) > MOST else ""
    title = f"{result.rotor}: {result.loop}, {speed_unit().text(result.speed)}{more}"
    write_title(figure, title)
    return figure


def _draw_response(panels: Array, name: str, item: ComputedResponse, label: str) -> None:
    top, middle = panels[0], panels[1]
    f = frequency_unit().of_hertz(item.frequencies)
    if item.measured is not None:
        top.semilogy(f, np.abs(item.measured), color=GREY, lw=1.6, label="measured")
        middle.plot(f, _phase(item.measured), ".", color=GREY, ms=2.0)
    draw_amplitude = top.semilogy if item.computed.any() else top.plot
    draw_amplitude(f, np.abs(item.computed), color=BLUE, label=label)
    middle.plot(f, _phase(item.computed), ".", color=BLUE, ms=1.4)
    top.set(ylabel=item.unit, ylim=_limits(np.abs(item.computed if item.measured is None else item.measured)))
    top.set_title(fitted(name, PANEL[0] - 0.8))
    if item.measured is not None:
        top.legend(loc="best")
    middle.set(ylabel="phase (deg)", ylim=(-185.0, 185.0))
    middle.yaxis.set_major_locator(MultipleLocator(90.0))
    if len(panels) > 2:
        if item.coherence is not None:
            panels[2].plot(f, item.coherence, color=ORANGE, lw=0.8)
        panels[2].set(ylabel="coherence", ylim=(0.0, 1.05))
    _set_frequencies(panels, f)


def _limits(amplitudes: Array) -> tuple[float | None, float | None]:
    """Return limits of an amplitude axis: median / `SPAN` and median * `SPAN`, or an end of the curve beyond them."""
    middle, ends = float(np.median(amplitudes)), (float(amplitudes[0]), float(amplitudes[-1]))
    if middle == 0.0:
        return None, None
    low, high = min(middle / SPAN, *ends), max(middle * SPAN, *ends)
    return (low if amplitudes.min() < low else None, high if amplitudes.max() > high else None)


def _set_frequencies(panels: Array, f: Array) -> None:
    last: Axes = panels[-1]
    if f[-1] > LINEAR_BELOW * f[0] and np.ptp(np.diff(np.log(f))) < np.ptp(np.diff(f)) / np.mean(np.diff(f)):
        last.set_xscale("log")
    last.set(xlabel=frequency_label(), xlim=(f[0], f[-1]))
    for panel in panels:
        panel.grid(color="0.9", lw=0.5)


def _phase(values: Complex) -> Array:
    """Return phases (deg); NaN where a value is zero, as for a force across the shaft and the motion along it."""
    return np.where(values == 0.0, np.nan, np.degrees(np.angle(values)))
