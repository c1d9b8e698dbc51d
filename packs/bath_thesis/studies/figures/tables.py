"""Errors of the natural frequencies by mesh, mass matrix and condensation."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from amb_cosim.presentation.style import BLUE, DASHED, GREEN, ORANGE, PURPLE, TITLE_SIZE, StyledFigure
from bath_thesis.studies.frequency_tables import ByMassAndSpeed, CondensationErrors, MeshAndCondensation


def draw(result: MeshAndCondensation) -> Figure:
    """Draw frequencies of each mesh against the finest one, and of the condensed model against the full one."""
    condensation = result.condensation
    figure = StyledFigure(figsize=(7.6 if condensation is not None else 4.2, 4.8), layout="constrained")
    panels = figure.subplots(1, 2 if condensation is not None else 1, squeeze=False)[0]
    _draw_mesh_errors(panels[0], result.frequencies.by_mesh)
    if condensation is not None:
        _draw_condensation_errors(panels[1], condensation)
    figure.suptitle(f"{result.rotor}: errors of the damped natural frequencies", fontsize=TITLE_SIZE)
    return figure


def _draw_mesh_errors(axes: Axes, meshes: dict[str, ByMassAndSpeed]) -> None:
    """Draw the difference of each mesh and mass matrix to the finest mesh with the consistent matrix."""
    speed = "90"  # rad/s
    exact = np.array(next(iter(meshes.values()))["consistent"][speed])
    colours = (BLUE, GREEN, ORANGE, PURPLE)
    for (mesh, masses), colour in zip(meshes.items(), colours, strict=False):
        for mass, marker in (("consistent", "o"), ("diagonal", "s")):
            row = np.array(masses[mass][speed])
            displayed = min(len(row), len(exact))
            error = 100.0 * np.abs(row[:displayed] / exact[:displayed] - 1.0)
            if error.any():
                label = f"{mesh.removesuffix('_node')} nodes, {mass}"
                axes.semilogy(
                    np.arange(1, displayed + 1),
                    np.maximum(error, 1e-6),
                    color=colour,
                    marker=marker,
                    ms=3.5,
                    label=label,
                )
    axes.set(xlabel="mode", ylabel="difference to the finest, consistent mesh (%)", title=f"meshes, {speed} rad/s")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(loc="upper center", bbox_to_anchor=(0.45, -0.16), ncols=2, columnspacing=1.0, handlelength=1.5)


def _draw_condensation_errors(axes: Axes, condensation: CondensationErrors) -> None:
    """Draw the error of each frequency over the spin speed."""
    for k, error in enumerate(condensation.frequency_error):
        axes.plot(condensation.speeds, error, color=f"C{k // 2}", ls=("-", DASHED)[k % 2], label=str(k + 1))
    planes = ", ".join(map(str, condensation.planes))
    axes.set(xlabel="spin speed (rad/s)", ylabel="condensed over full - 1 (%)", title=f"condensed to nodes {planes}")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=4, title="mode")
