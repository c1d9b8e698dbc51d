"""Figures of the studies of the synchronous control."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from amb_cosim.plots.axes import BLUE, GREEN, GREY, ORANGE, PURPLE
from fmi_export.model import Array

DASHED = (0, (4, 2))
YELLOW, SKY = "#E69F00", "#56B4E9"
PLANE_COLOURS = (BLUE, ORANGE, GREEN, PURPLE)


def receptance(data: dict[str, Any]) -> Figure:
    """Magnitude over speed of the sensors in x and y, and phase of those in x, for forces in x at both bearings."""
    figure = Figure(figsize=(8.4, 6.0), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=(3, 2))
    speeds, R = np.array(data["speeds_hz"]), _complex(data["receptance_m_per_N"])
    for column, force in enumerate((0, 2)):
        top, bottom = panels[:, column]
        for plane, colour in enumerate(PLANE_COLOURS):
            along, across = R[:, 2 * plane, force], R[:, 2 * plane + 1, force]
            top.semilogy(speeds, 1e6 * np.abs(along), color=colour)
            top.semilogy(speeds, 1e6 * np.abs(across), color=colour, ls=DASHED, lw=0.7)
            bottom.plot(speeds, _unbroken(np.degrees(np.angle(along))), color=colour)
        top.set_title(f"force at {data['forces'][force]}")
        bottom.set(xlabel="speed (Hz)", xlim=(speeds[0], speeds[-1]), ylim=(-180.0, 180.0))
        bottom.yaxis.set_major_locator(MultipleLocator(90.0))
        for axes in (top, bottom):
            axes.grid(color="0.9", lw=0.5)
    largest = 1e6 * np.abs(R).max()
    panels[0, 0].set(ylabel="displacement over force (um/N)", ylim=(1e-5 * largest, 2.0 * largest))
    panels[1, 0].set_ylabel("phase in x (deg)")
    _sensor_legend(figure, data)
    figure.suptitle(f"{data['rotor']}: synchronous receptance of the levitated rotor, from the model", fontsize=10.5)
    return figure


def _sensor_legend(figure: Figure, data: dict[str, Any]) -> None:
    handles = [
        Line2D([], [], color=colour, label=f"s{2 * k + 1}, s{2 * k + 2} at z = {z:.4g} m")
        for k, (colour, z) in enumerate(zip(PLANE_COLOURS, data["planes_z_m"], strict=True))
    ]
    handles += [
        Line2D([], [], color="0.3", label="in x, along the force"),
        Line2D([], [], color="0.3", ls=DASHED, lw=0.7, label="in y, across"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)


def _unbroken(phase: Array) -> Array:
    """The phase without the lines that would join -180 and 180 degrees."""
    return np.where(np.abs(np.diff(phase, prepend=phase[0])) > 180.0, np.nan, phase)


def _complex(parts: dict[str, Any]) -> NDArray[np.complex128]:
    return np.array(parts["real"]) + 1j * np.array(parts["imaginary"])


def test_force(data: dict[str, Any]) -> Figure:
    """S and A over frequency, periods of a slot, and how long ROLAC halts."""
    figure = Figure(figsize=(8.0, 5.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    thesis, jump = data["at_the_speeds_of_the_thesis"], data["at_the_jump"]["frequencies_hz"]
    frequencies = np.array(data["frequencies_hz"])
    for axes, (key, label) in zip(
        panels.flat,
        {
            "s": "S",
            "amplitude_N": "amplitude A of the force (N)",
            "periods_per_slot": r"periods of a slot, $N_\mathrm{per}$",
            "t_halt_s": r"ROLAC halts for $t_\mathrm{halt}$ (s)",
        }.items(),
        strict=True,
    ):
        values = np.array(data[key])
        if jump and key in ("s", "amplitude_N"):
            after = int(np.searchsorted(frequencies, jump[-1]))
            _jump(axes, frequencies, values, after)
        else:
            axes.plot(frequencies, values, color=BLUE)
        shown = np.array(thesis["frequencies_hz"]) <= frequencies[-1]
        axes.plot(np.array(thesis["frequencies_hz"])[shown], np.array(thesis[key])[shown], "s", color=ORANGE, ms=3.0)
        axes.set(ylabel=label, ylim=(0.0, 1.08 * values.max()), xlim=(frequencies[0], frequencies[-1]))
        axes.grid(color="0.9", lw=0.5)
    for axes in panels[1]:
        axes.set_xlabel("frequency (Hz)")
    handles = [
        Line2D([], [], color=BLUE, label="as the controller computes it"),
        Line2D([], [], color=ORANGE, ls="", marker="s", ms=3.0, label="speeds of the thesis"),
        Line2D([], [], color=BLUE, ls="", marker="o", ms=4.0, mfc="white", label="jump: limit from below"),
        Line2D([], [], color=BLUE, ls="", marker="o", ms=4.0, label="value from there on"),
    ]
    figure.legend(handles=handles[: 4 if jump else 2], loc="outside lower center", ncols=4)
    figure.suptitle("Test force of an identification", fontsize=10.5)
    return figure


def _jump(axes: Axes, frequencies: Array, values: Array, after: int) -> None:
    axes.plot(frequencies[:after], values[:after], color=BLUE)
    axes.plot(frequencies[after:], values[after:], color=BLUE)
    for index, other, fill in ((after - 1, after, "white"), (after, after - 1, BLUE)):
        place = (frequencies[index], values[index])
        axes.plot(*place, "o", color=BLUE, ms=4.0, mfc=fill)
        offset = (6, 4 if values[index] > values[other] else -11)
        axes.annotate(f"{values[index]:.3g}", place, offset, textcoords="offset points", fontsize=8)


def h_matrix(data: dict[str, Any]) -> Figure:
    """Magnitudes in H over speed for forces in x at both bearings; error of interpolation; condition number of R."""
    figure = Figure(figsize=(8.4, 7.2), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True)
    speeds, table = np.array(data["speeds_hz"]), np.array(data["table_hz"])
    exact, linear = (_complex(data[key]) for key in ("h_N_per_m", "h_interpolated_N_per_m"))
    known = np.isin(speeds, table)
    for axes, force in zip(panels[0], (0, 2), strict=True):
        for plane, colour in enumerate(PLANE_COLOURS):
            for axis, line in enumerate(("-", DASHED)):
                element = (slice(None), force, 2 * plane + axis)
                axes.plot(speeds, 1e-6 * np.abs(exact[element]), color=colour, ls=line, lw=0.9 - 0.2 * axis)
                axes.plot(speeds, 1e-6 * np.abs(linear[element]), color="black", ls=":", lw=0.6)
                axes.plot(speeds[known], 1e-6 * np.abs(exact[element])[known], "o", color=colour, ms=2.2)
        axes.set(title=f"force at {data['forces'][force]}", ylim=(0.0, None))
    panels[0, 0].set_ylabel("element of H (N/um)")
    panels[0, 1].sharey(panels[0, 0])
    _errors(panels[1, 0], data, speeds)
    panels[1, 1].plot(speeds, data["condition_number"], color=BLUE)
    panels[1, 1].set(ylabel="condition number of R", ylim=(1.0, None))
    for axes in panels[1]:
        axes.set(xlabel="speed (Hz)", xlim=(speeds[0], speeds[-1]))
    for axes in panels.flat:
        axes.grid(color="0.9", lw=0.5)
        if speeds[-1] > table[-1]:
            axes.axvspan(table[-1], speeds[-1], color="0.95", lw=0.0, zorder=0)
    _sensor_legend(figure, data)
    figure.suptitle(
        f"{data['rotor']}: H over speed; dots: the twelve speeds of the thesis, dotted: linear between them",
        fontsize=10.5,
    )
    return figure


def _errors(axes: Axes, data: dict[str, Any], speeds: Array) -> None:
    for (name, label), colour in zip(
        {"thesis": "twelve speeds", "every_hertz": "every 1 Hz"}.items(), (ORANGE, BLUE), strict=True
    ):
        table = data["tables"][name]
        for key, line, what in (("relative_error", "-", "error of H"), ("left_by_a_step", DASHED, "|I + H R|")):
            values = 100.0 * np.array(table[key])
            axes.semilogy(
                speeds, np.where(values > 1e-9, values, np.nan), color=colour, ls=line, label=f"{label}: {what}"
            )
    axes.set(ylabel="interpolated against exact (%)", ylim=(1e-2, 3e3))
    axes.legend(loc="upper center", ncols=2, columnspacing=1.0, handlelength=1.6)


def recovery(data: dict[str, Any]) -> Figure:
    """Share of runs recovered for each control and unbalance; median and range of the time that they took."""
    figure = Figure(figsize=(7.6, 6.0), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(2, 3))
    controls = data["controls"]
    shares = 100.0 * np.array([[cell["recovered_share"] for cell in cells] for cells in controls.values()])
    top.imshow(shares, cmap="Greens", vmin=0.0, vmax=140.0, aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        top.text(column, row, f"{share:.0f}", ha="center", va="center", fontsize=8)
    top.set_yticks(range(len(controls)), list(controls))
    top.tick_params(length=0)
    top.set_title(f"runs free of contact at cycle {data['end_cycle']:g} (%)")
    styles = zip(controls.items(), (GREY, PURPLE, YELLOW, SKY, ORANGE, BLUE), "xvd^so", strict=True)
    for (control, cells), colour, marker in styles:
        taken = [[run["cycles"] for run in cell["runs"] if run["recovered"]] or [np.nan] for cell in cells]
        middle, low, high = (np.array([f(cycles) for cycles in taken]) for f in (np.median, np.min, np.max))
        style = {"color": colour, "marker": marker, "ms": 4.5, "capsize": 2.0, "elinewidth": 0.7}
        bottom.errorbar(range(len(cells)), middle, (middle - low, high - middle), label=control, **style)
    bottom.set(xlabel="unbalance added on D1 (g m)", ylabel="cycles from step to last contact", ylim=(-1.0, None))
    bottom.set_xticks(range(shares.shape[1]), [f"{1e3 * value:g}" for value in data["added_kg_m"]])
    bottom.set_title("median and range; 0 without contact")
    bottom.grid(color="0.9", lw=0.5)
    bottom.legend(loc="upper left")
    figure.suptitle(
        rf"Recovery at {data['speed_hz']:g} Hz, unbalances times {data['unbalance_factor']:g}, "
        rf"$\alpha$ = {data['alpha_per_s']:g} 1/s, {data['instants']} instants of the step",
        fontsize=10.5,
    )
    return figure
