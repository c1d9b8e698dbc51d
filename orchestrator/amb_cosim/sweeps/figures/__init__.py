"""The figures of a sweep."""

from __future__ import annotations

from amb_cosim.sweeps.maps import draw_maps
from amb_cosim.sweeps.phases import draw_phases
from amb_cosim.sweeps.run import Sweep


def draw_sweep(swept: Sweep) -> list[str]:
    """Draw maps of a sweep, and its peak force over the phase of an event where that was varied, into its folder.

    Return the names of the files.
    """
    return [*draw_maps(swept), *draw_phases(swept)]
