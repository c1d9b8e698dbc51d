"""The figures of a sweep."""

from __future__ import annotations

from amb_sweeps.maps import draw_maps
from amb_sweeps.phases import draw_phases
from amb_sweeps.run import Sweep


def draw_sweep(swept: Sweep) -> list[str]:
    """Plot maps of a sweep into its folder and, if the phase of an event varies, the peak force against this phase.

    Return the names of the files.
    """
    return [*draw_maps(swept), *draw_phases(swept)]
