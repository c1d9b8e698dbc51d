"""The figures of a sweep."""

from __future__ import annotations

from amb_files.checks import require_kind
from amb_sweeps.maps import draw_maps
from amb_sweeps.phases import draw_phases
from amb_sweeps.run import Sweep


def draw_sweep(swept: Sweep) -> list[str]:
    """Plot maps of a sweep into its folder and, if the phase of an event varies, the contact force against this phase.

    Return the names of the files.
    """
    require_kind("swept", swept, Sweep, "the result of a sweep")
    return [*draw_maps(swept), *draw_phases(swept)]
