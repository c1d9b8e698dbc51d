"""Figures of the studies."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator
from scipy.interpolate import CubicHermiteSpline

from amb_cosim.plots.axes import BLUE, GREEN, ORANGE, PURPLE
from rotor_analysis.campbell import Campbell
from rotor_analysis.condensation import CondensationError
from rotor_analysis.modes import Mode
from rotor_analysis.rotor import Rotor

WHIRL = {"backward": (ORANGE, (0, (4, 2))), "forward": (BLUE, "-"), "mixed": (PURPLE, ":")}
DASHED = (0, (4, 2))


def campbell(name: str, diagram: Campbell) -> Figure:
    """Damped frequencies with the synchronous line and critical speeds above, damping ratios below."""
    figure = Figure(figsize=(7.0, 6.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    speeds = diagram.speeds
    for track, frequencies, ratios in zip(diagram.tracks, diagram.frequencies, diagram.damping_ratios, strict=True):
        for whirl, (colour, line) in WHIRL.items():
            such = np.array([mode is not None and mode.whirl == whirl for mode in track])
            for axes, values in ((top, frequencies), (bottom, ratios)):
                axes.plot(speeds, np.where(such, values, np.nan), color=colour, ls=line)
    highest = float(np.nanmax(diagram.frequencies, initial=1.0))
    top.plot(speeds, speeds, color="black", lw=0.8, ls=":")
    for critical in diagram.critical_speeds:
        colour, _ = WHIRL[critical.whirl]
        top.plot(critical.Omega, critical.Omega, "o", ms=3.5, color=colour)
        if critical.whirl != "backward":
            place = (critical.Omega, critical.Omega)
            top.annotate(f"{critical.Omega:.1f} ", place, (-3, 4), textcoords="offset points", ha="right", color=colour)
    top.set(ylabel="damped frequency (rad/s)", ylim=(0.0, 1.08 * highest), xlim=(speeds[0], speeds[-1]))
    lowest = min(0.0, 1.1 * float(np.nanmin(diagram.damping_ratios, initial=0.0)))
    bottom.set(ylabel=r"damping ratio $\zeta$", xlabel=r"spin speed $\Omega$ (rad/s)", ylim=(lowest, None))
    if lowest < 0.0:
        bottom.axhspan(lowest, 0.0, color="0.93")
        bottom.text(speeds[-1], lowest, "unstable ", ha="right", va="bottom", fontsize=8, color="0.3")
    present = {mode.whirl for track in diagram.tracks for mode in track if mode}
    handles = [Line2D([], [], color=WHIRL[w][0], ls=WHIRL[w][1], label=f"{w} whirl") for w in WHIRL if w in present]
    handles += [
        Line2D([], [], color="black", lw=0.8, ls=":", label=r"synchronous, $\omega = \Omega$"),
        Line2D([], [], color="0.3", ls="", marker="o", ms=3.5, label="critical speed"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
    figure.suptitle(f"{name}: damped natural frequencies and damping ratios", fontsize=10.5)
    return figure


def mode_shapes(rotor: Rotor, Omega: float, found: list[Mode]) -> Figure:
    """Mode shapes in space: the deflected axis, and the orbits of the ends, bodies and bearings.

    An orbit begins at its dot, on the axis as drawn, and stops short of a full turn: that shows its direction.
    """
    columns = min(len(found), 4) or 1
    rows = -(-len(found) // columns) or 1
    height = 2.4 * rows + 0.9
    figure = Figure(figsize=(max(3.1 * columns, 6.2), height))
    figure.subplots_adjust(0.0, 0.55 / height, 0.97, 1.0 - 0.5 / height, wspace=0.0, hspace=0.12)
    for k, mode in enumerate(found):
        axes = figure.add_subplot(rows, columns, k + 1, projection="3d", computed_zorder=False)
        _draw_mode(axes, rotor, mode)
        ratio = round(mode.damping_ratio, 3) + 0.0  # not -0.000
        axes.set_title(f"{k + 1}: {mode.whirl}\n{mode.frequency:.1f} rad/s, $\\zeta$ = {ratio:.3f}", y=0.86)
    handles = [
        Line2D([], [], color="0.6", lw=0.8, ls=DASHED, label="axis at rest"),
        Line2D([], [], color="black", marker="o", ms=4, ls="", label="body"),
        Line2D([], [], color="black", marker="^", ms=5, mfc="white", ls="", label="bearing"),
        Line2D([], [], color="0.3", lw=1.4, label="deflected axis"),
    ]
    handles += [
        Line2D([], [], color=colour, label=f"{whirl} orbit")
        for whirl, (colour, _) in WHIRL.items()
        if any(m.whirl == whirl for m in found)
    ]
    figure.legend(handles=handles, loc="lower center", ncols=len(handles) if columns > 2 else 3)
    figure.suptitle(rf"{rotor.name}: modes at $\Omega$ = {Omega:.4g} rad/s", fontsize=10.5)
    return figure


def _draw_mode(axes: Any, rotor: Rotor, mode: Mode) -> None:
    z = np.array(rotor.shaft.nodes)
    colour, _ = WHIRL[mode.whirl]
    fine = np.linspace(z[0], z[-1], 200)
    x, y, slope_x, slope_y = mode.shape.reshape(-1, 4).T
    line_x, line_y = (CubicHermiteSpline(z, value, slope)(fine) for value, slope in ((x, slope_x), (y, slope_y)))
    largest = max(np.max(np.abs(line_x)), np.max(np.abs(line_y)))
    x, y, line_x, line_y = x / largest, y / largest, line_x / largest, line_y / largest
    axes.plot(z[[0, -1]], [0, 0], [0, 0], color="0.6", lw=0.8, ls=DASHED)
    turn = np.exp(1j * np.linspace(0.0, 0.88 * 2.0 * np.pi, 80))
    for node in sorted({1, len(z), *rotor.bearing_nodes, *(body.node for body in rotor.bodies)}):
        k = node - 1
        axes.plot(np.full(len(turn), z[k]), (x[k] * turn).real, (y[k] * turn).real, color=colour, lw=0.9)
        axes.plot(z[k], x[k].real, y[k].real, "o", color=colour, ms=2.5)
    axes.plot(fine, line_x.real, line_y.real, color="0.3", lw=1.4)
    for parts, style in (
        (rotor.bodies, {"marker": "o", "ms": 3}),
        (rotor.bearings, {"marker": "^", "ms": 5, "mfc": "white"}),
    ):
        at = [z[part.node - 1] for part in parts]
        axes.plot(at, np.zeros(len(at)), np.zeros(len(at)), ls="", color="black", **style)
    axes.set(xlim=(z[0], z[-1]), ylim=(-1, 1), zlim=(-1, 1), xlabel="$z$ (m)")
    axes.set_yticks([], [])
    axes.set_zticks([], [])
    axes.set_ylabel("$x$", labelpad=-12)
    axes.set_zlabel("$y$", labelpad=-12)
    axes.tick_params(axis="x", labelsize=7, pad=-2)
    axes.set_box_aspect((2.4, 1, 1), zoom=1.25)
    axes.view_init(elev=18, azim=-62)
    axes.grid(visible=False)
    for artist in axes.lines:
        artist.set_clip_on(False)


def errors(data: dict[str, Any], condensation: CondensationError | None) -> Figure:
    """Frequencies of each mesh against the finest one, and of the condensed model against the full over speed."""
    figure = Figure(figsize=(7.6 if condensation is not None else 4.2, 4.8), layout="constrained")
    panels = figure.subplots(1, 2 if condensation is not None else 1, squeeze=False)[0]
    _mesh_errors(panels[0], data["table_3_1"])
    if condensation is not None:
        _condensation_errors(panels[1], condensation)
    figure.suptitle(f"{data['rotor']}: errors of the damped natural frequencies", fontsize=10.5)
    return figure


def _mesh_errors(axes: Axes, meshes: dict[str, Any]) -> None:
    speed = "90"
    exact = np.array(next(iter(meshes.values()))["consistent"][speed])
    colours = (BLUE, GREEN, ORANGE, PURPLE)
    for (mesh, masses), colour in zip(meshes.items(), colours, strict=False):
        for mass, marker in (("consistent", "o"), ("diagonal", "s")):
            row = np.array(masses[mass][speed])
            shown = min(len(row), len(exact))
            error = 100.0 * np.abs(row[:shown] / exact[:shown] - 1.0)
            if error.any():
                label = f"{mesh.removesuffix('_node')} nodes, {mass}"
                axes.semilogy(
                    np.arange(1, shown + 1), np.maximum(error, 1e-6), color=colour, marker=marker, ms=3.5, label=label
                )
    axes.set(xlabel="mode", ylabel="difference to the finest, consistent mesh (%)", title=f"meshes, {speed} rad/s")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="upper center", bbox_to_anchor=(0.45, -0.16), ncols=2, columnspacing=1.0, handlelength=1.5)


def _condensation_errors(axes: Axes, condensation: CondensationError) -> None:
    for k, error in enumerate(condensation.frequency.T):
        axes.plot(condensation.speeds, error, color=f"C{k // 2}", ls=("-", DASHED)[k % 2], label=str(k + 1))
    planes = ", ".join(map(str, condensation.planes))
    axes.set(xlabel="spin speed (rad/s)", ylabel="condensed over full - 1 (%)", title=f"condensed to nodes {planes}")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=4, title="mode")


def unbalance_response(name: str, data: dict[str, Any], clearance: float) -> Figure:
    """Amplitude over clearance and phase against speed."""
    figure = Figure(figsize=(7.0, 5.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    speeds = np.array(data["speeds_rad_s"])
    for (label, place), colour in zip(data["places"].items(), (BLUE, ORANGE, GREEN, PURPLE), strict=False):
        top.plot(speeds, 1e3 * np.array(place["amplitude_m"]), color=colour, label=label)
        bottom.plot(speeds, np.degrees(place["phase_rad"]), color=colour)
    top.axhline(1e3 * clearance, color="black", lw=0.9, ls=DASHED, label=f"clearance {1e3 * clearance:.3g} mm")
    top.set(ylabel="amplitude (mm)", ylim=(0.0, None), xlim=(0.0, speeds[-1]))
    bottom.set(ylabel="phase (deg)", xlabel=r"spin speed $\Omega$ (rad/s)")
    bottom.yaxis.set_major_locator(MultipleLocator(90.0))
    bottom.grid(axis="y", color="0.9", lw=0.6)
    figure.legend(loc="outside lower center", ncols=3)
    figure.suptitle(
        f"{name}: steady response to {1e3 * data['unbalance_kg_m']:.4g} g m at node {data['node']}", fontsize=10.5
    )
    return figure
