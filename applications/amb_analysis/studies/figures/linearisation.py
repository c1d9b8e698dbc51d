"""Properties of an axis of the magnetic bearing."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_analysis.studies.bearing_axis import BearingAxis, LoadCurves
from amb_cosim.presentation.digits import significant
from amb_cosim.presentation.style import BLUE, ORANGE, StyledFigure, write_title
from amb_cosim.presentation.units import force_unit, frequency_label, frequency_text, frequency_unit, length_unit
from array_types import Array


def draw(result: BearingAxis) -> Figure:
    """Draw K_s and K_i over displacement and control current, load capacity, and the largest sinusoidal force."""
    figure = StyledFigure(figsize=(8.4, 7.0), layout="constrained")
    panels = figure.subplots(2, 2)
    _draw_map(panels[0, 0], result, 1e-3 * result.map.k_s, "K_s", "N/mm")
    _draw_map(panels[0, 1], result, result.map.k_i, "K_i", "N/A")
    _draw_load_capacity(panels[1, 0], result.load)
    _draw_bandwidth(panels[1, 1], result)
    write_title(
        figure,
        f"{result.axis} at {result.bias_current:g} A bias and {result.static_current:g} A static current: "
        rf"$K_s$ = {significant(1e-3 * result.k_s)} N/mm, $K_i$ = {significant(result.k_i)} N/A",
    )
    return figure


def _draw_map(axes: Axes, result: BearingAxis, values: Array, symbol: str, unit: str) -> None:
    """Draw a property over displacement and control current, with the limits of the linear range."""
    unit_of_x = length_unit(float(result.map.x.max()))
    x, current = unit_of_x.of(result.map.x), result.map.i_c
    filled = axes.contourf(x, current, values, levels=14, cmap="cividis")
    axes.figure.colorbar(filled, ax=axes, label=f"${symbol}$ ({unit})")
    edge = axes.contour(x, current, result.map.linear_error, levels=[result.tolerance], colors="white", linewidths=1.3)
    axes.clabel(edge, fmt=lambda level: f"{100 * level:g} %", fontsize=8)
    axes.plot(0.0, 0.0, "+", color="white", ms=8)
    axes.set(xlabel=f"displacement $x$ ({unit_of_x.label})", ylabel="control current $I_c$ (A)")
    axes.set_title(f"${symbol}$; white: limit of the linear law")


def _draw_load_capacity(axes: Axes, load: LoadCurves) -> None:
    """Draw the remaining control force over the static load."""
    unit = force_unit(float(load.static_load[-1]))
    loads = unit.of(load.static_load)
    axes.plot(loads, unit.of(load.up), color=BLUE, label="up, against the load")
    axes.plot(loads, unit.of(load.down), color=ORANGE, label="down")
    static_load = load.own.static_load
    axes.axvline(static_load / unit.size, color="0.45", lw=0.8, ls=":")
    axes.text(
        static_load / unit.size,
        0.03,
        f" {unit.text(static_load)}, at this static current",
        transform=axes.get_xaxis_transform(),
        fontsize=8,
    )
    axes.set(
        xlabel=f"static load of the axis ({unit.label})",
        ylabel=f"remaining control force ({unit.label})",
        ylim=(0.0, None),
    )
    axes.set_xlim(0.0, loads[-1])
    axes.set_title("Load capacity")
    axes.legend(loc="center right")


def _draw_bandwidth(axes: Axes, result: BearingAxis) -> None:
    """Draw the largest sinusoidal force over frequency, and the bandwidth at three amplitudes."""
    unit, cycles = force_unit(max(result.bandwidth.force_amplitude)), frequency_unit()
    frequencies, amplitudes = cycles.of_hertz(result.bandwidth.frequencies), unit.of(result.bandwidth.force_amplitude)
    axes.loglog(frequencies, amplitudes, color=BLUE)
    for swing in result.full_swing:
        point = (float(cycles.of_hertz(swing.bandwidth)), swing.force / unit.size)
        axes.plot(*point, "o", color=BLUE, ms=3.5)
        label = f"{significant(swing.i_c)} A to {frequency_text(swing.bandwidth)}"
        axes.annotate(label, point, (-7, -10), textcoords="offset points", ha="right", fontsize=8)
    bandwidth = float(cycles.of_hertz(result.amplifier_bandwidth))
    axes.axvline(bandwidth, color="0.45", lw=0.8, ls=":")
    text = f"{frequency_text(result.amplifier_bandwidth)}, small signals "
    axes.text(bandwidth, 0.03, text, transform=axes.get_xaxis_transform(), ha="right", fontsize=8)
    top = 2.5 * max(amplitudes)
    axes.set(xlabel=frequency_label(), ylabel=f"amplitude of the force ({unit.label})", ylim=(top / 1000.0, top))
    axes.set_xlim(frequencies[0], frequencies[-1])
    axes.set_title("Largest sinusoidal force, at the voltage limit")
