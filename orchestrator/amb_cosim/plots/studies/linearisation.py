"""Figures of the studies of the magnetic bearings and of the loop that they close."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter

from amb_cosim.plots.axes import BLUE, GREEN, ORANGE, PURPLE

STYLES = ((ORANGE, "o"), (BLUE, "s"), (PURPLE, "^"), (GREEN, "D"))
ZONE_SHADES = {"A": "1.0", "B": "0.95", "C": "0.89", "D": "0.82"}


def coupling(data: dict[str, Any]) -> Figure:
    """Error over communication step for each case and scheme, with slopes of the orders observed."""
    figure = Figure(figsize=(8.4, 6.8), layout="constrained")
    for axes, comparison in zip(figure.subplots(2, 2, sharey=True).flat, data["comparisons"], strict=True):
        _errors(axes, comparison)
    figure.supxlabel("communication step of plant and actuator (us)", fontsize=9)
    figure.supylabel("largest error of the orbits / largest displacement", fontsize=9)
    figure.suptitle(
        f"Co-simulation against the whole system, {1e3 * data['duration_s']:g} ms from rest (observed order)",
        fontsize=10.5,
    )
    return figure


def _errors(axes: Axes, comparison: dict[str, Any]) -> None:
    steps = 1e6 * np.array(comparison["steps_s"])
    schemes = comparison["schemes"]
    for (name, scheme), (colour, marker) in zip(schemes.items(), STYLES, strict=False):
        order = "exact" if scheme["order"] is None else f"{scheme['order']:.2f}"
        axes.loglog(steps, scheme["errors"], color=colour, marker=marker, ms=4, label=f"{name} ({order})")
    rounded = {name: round(scheme["order"]) for name, scheme in schemes.items() if scheme["order"] is not None}
    for order in set(rounded.values()):
        largest = max(schemes[name]["errors"][-1] for name in rounded if rounded[name] == order)
        slope = 2.5 * largest * (steps / steps[-1]) ** order
        axes.loglog(steps, slope, color="black", lw=0.8, ls=":")
        axes.annotate(f"{order}", (steps[0], slope[0]), (4, 0), textcoords="offset points", va="center")
    axes.set_title(comparison["title"])
    axes.set_xticks(steps, [f"{step:g}" for step in steps])
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.minorticks_off()
    axes.set_ylim(1e-10, 10.0)
    axes.grid(color="0.9", lw=0.5)
    axes.legend(loc="lower right" if 2 in rounded.values() else "center right")


def sensitivity(data: dict[str, Any]) -> Figure:
    """|S| of each axis, computed and measured, over the zones of ISO 14839-3."""
    figure = Figure(figsize=(8.0, 6.2), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for axes, (name, axis) in zip(panels.flat, data["axes"].items(), strict=True):
        _zones(axes, data)
        _curve(axes, data, name, axis)
    for k in (0, 1):
        panels[k, 0].set_ylabel("sensitivity |S|")
        panels[1, k].set_xlabel("frequency (Hz)")
    delay = ", one sample of delay" if data["delay_samples"] else ""
    handles = [
        Line2D([], [], color=BLUE, label="computed from the sampled linear loop"),
        Line2D([], [], color=ORANGE, ls="", marker="o", ms=3, label="measured in the co-simulation"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    figure.suptitle(
        f"Sensitivity at {data['speed_rad_s']:g} rad/s, sampled every {1e6 * data['sample_time_s']:g} us, "
        f"{data['amplifier']} amplifiers{delay}",
        fontsize=10.5,
    )
    return figure


def _zones(axes: Axes, data: dict[str, Any]) -> None:
    limits = [0.0, *data["zone_limits"].values(), 1e6]
    for low, high, (name, shade) in zip(limits[:-1], limits[1:], ZONE_SHADES.items(), strict=True):
        axes.axhspan(low, high, color=shade, lw=0.0)
        if name != "D":
            axes.axhline(high, color="0.45", lw=0.7, ls=(0, (4, 2)))


def _curve(axes: Axes, data: dict[str, Any], name: str, axis: dict[str, Any]) -> None:
    frequencies = np.array(data["frequencies_hz"])
    lines, values = np.array(axis["measured_frequencies_hz"]), np.array(axis["measured"])
    shown = np.unique(np.searchsorted(lines, np.geomspace(lines[0], lines[-1], 150)).clip(0, len(lines) - 1))
    axes.semilogx(lines[shown], values[shown], "o", color=ORANGE, ms=2.6)
    axes.semilogx(frequencies, axis["computed"], color=BLUE, lw=0.8)
    top = max(6.0, 1.15 * max(a["peak"] for a in data["axes"].values()))
    axes.set(xlim=(frequencies[0], frequencies[-1]), ylim=(0.0, top))
    where = f"{axis['peak']:.2f} at {axis['peak_frequency_hz']:.1f} Hz, zone {axis['zone']}"
    axes.set_title(f"{name[:3].upper()}, {name[-1]} axis: {where}")
    for letter, level in {"A": 2.7, "B": 3.5, "C": 4.5, "D": 5.5}.items():
        axes.text(0.99, level, letter, transform=axes.get_yaxis_transform(), ha="right", va="center", color="0.3")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def linearisation(data: dict[str, Any]) -> Figure:
    """K_s and K_i over displacement and control current; load capacity; the largest sine of the force."""
    figure = Figure(figsize=(8.4, 7.0), layout="constrained")
    panels = figure.subplots(2, 2)
    for axes, key, unit, scale in ((panels[0, 0], "k_s", "N/mm", 1e-3), (panels[0, 1], "k_i", "N/A", 1.0)):
        _map(axes, data, key, unit, scale)
    _load_capacity(panels[1, 0], data)
    _bandwidth(panels[1, 1], data)
    figure.suptitle(
        f"One axis at {data['bias_current_A']:g} A bias and {data['static_current_A']:g} A static current: "
        rf"$K_s$ = {1e-3 * data['k_s_N_per_m']:.1f} N/mm, $K_i$ = {data['k_i_N_per_A']:.1f} N/A",
        fontsize=10.5,
    )
    return figure


def _map(axes: Axes, data: dict[str, Any], key: str, unit: str, scale: float) -> None:
    x, current = 1e3 * np.array(data["map"]["x_m"]), np.array(data["map"]["i_c_A"])
    values = scale * np.array(data["map"][key])
    filled = axes.contourf(x, current, values, levels=14, cmap="cividis")
    axes.figure.colorbar(filled, ax=axes, label=f"${key[0].upper()}_{key[-1]}$ ({unit})")
    error = np.array(data["map"]["linear_error"])
    edge = axes.contour(x, current, error, levels=[data["tolerance"]], colors="white", linewidths=1.3)
    axes.clabel(edge, fmt=lambda level: f"{100 * level:g} %", fontsize=8)
    axes.plot(0.0, 0.0, "+", color="white", ms=8)
    axes.set(xlabel="displacement $x$ (mm)", ylabel="control current $I_c$ (A)")
    axes.set_title(f"${key[0].upper()}_{key[-1]}$; white: edge of where the linear law holds")


def _load_capacity(axes: Axes, data: dict[str, Any]) -> None:
    load = data["load"]
    axes.plot(load["static_load_N"], load["up_N"], color=BLUE, label="up, against the load")
    axes.plot(load["static_load_N"], load["down_N"], color=ORANGE, label="down")
    own = load["own"]["static_load_N"]
    axes.axvline(own, color="0.45", lw=0.8, ls=":")
    axes.text(own, 0.03, f" {own:.0f} N, at this static current", transform=axes.get_xaxis_transform(), fontsize=8)
    axes.set(xlabel="static load of the axis (N)", ylabel="control force left (N)", ylim=(0.0, None))
    axes.set_xlim(0.0, load["static_load_N"][-1])
    axes.set_title("Load capacity")
    axes.legend(loc="center right")


def _bandwidth(axes: Axes, data: dict[str, Any]) -> None:
    frequencies = data["bandwidth"]["frequencies_hz"]
    axes.loglog(frequencies, data["bandwidth"]["force_amplitude_N"], color=BLUE)
    for swing in data["full_swing"]:
        place = (swing["bandwidth_hz"], swing["force_N"])
        axes.plot(*place, "o", color=BLUE, ms=3.5)
        label = f"{swing['i_c_A']:.2f} A to {place[0]:.0f} Hz"
        axes.annotate(label, place, (-7, -10), textcoords="offset points", ha="right", fontsize=8)
    bandwidth = data["amplifier_bandwidth_hz"]
    axes.axvline(bandwidth, color="0.45", lw=0.8, ls=":")
    text = f"{bandwidth:g} Hz, small signals "
    axes.text(bandwidth, 0.03, text, transform=axes.get_xaxis_transform(), ha="right", fontsize=8)
    top = 2.5 * max(data["bandwidth"]["force_amplitude_N"])
    axes.set(xlabel="frequency (Hz)", ylabel="amplitude of the force (N)", ylim=(top / 1000.0, top))
    axes.set_xlim(frequencies[0], frequencies[-1])
    axes.set_title("Largest sine of the force, at the voltage limit")
