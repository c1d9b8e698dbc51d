"""Bode plots of a controller."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from amb_analysis.studies.controller_description import ControllerDescription, LawPath, degrees
from amb_cosim.presentation.style import DASHED, GREY, StyledFigure, write_title
from amb_cosim.presentation.units import frequency_label, frequency_unit


def draw(result: ControllerDescription) -> Figure:
    """Return Bode plots: sampled laws are solid, continuous laws are dashed, and modes (rad/s) are vertical lines.

    Connections with equal responses share a line.
    """
    figure = StyledFigure(figsize=(8.0, 6.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    unit = frequency_unit()
    frequencies = unit.of(result.omega)
    for number, (names, path) in enumerate(_grouped(result.connections)):
        colour, label = f"C{number}", ", ".join(names[:4]) + (" ..." if len(names) > 4 else "")
        above.loglog(frequencies, np.abs(path.sampled), color=colour, label=label)
        below.semilogx(frequencies, degrees(path.sampled), color=colour)
        if path.continuous is not None:
            above.loglog(frequencies, np.abs(path.continuous), color=colour, linestyle=DASHED)
            below.semilogx(frequencies, degrees(path.continuous), color=colour, linestyle=DASHED)
    for axes in (above, below):
        for mode in result.modes:
            axes.axvline(mode / unit.size, color=GREY, linewidth=0.6)
        axes.grid(alpha=0.3)
    above.set(ylabel="gain (A/m)")
    below.set(xlabel=frequency_label(), ylabel="phase (deg)")
    figure.legend(loc="outside lower center")
    has_continuous = any(path.continuous is not None for path in result.connections)
    lines = "solid: sampled" + (", dashed: continuous" if has_continuous else "")
    modes = ", grey: modes of the rotor" if result.modes else ""
    write_title(
        figure, f"Controller, sampled every {1e6 * result.controller.sample_time:g} \N{MICRO SIGN}s\n{lines}{modes}"
    )
    return figure


def _grouped(laws: Sequence[LawPath]) -> list[tuple[list[str], LawPath]]:
    groups: list[tuple[list[str], LawPath]] = []
    for path in laws:
        name = f"{path.signal} to {path.demand}"
        for names, first in groups:
            if np.allclose(first.sampled, path.sampled, rtol=1e-9, atol=0.0):
                names.append(name)
                break
        else:
            groups.append(([name], path))
    return groups
