"""Figures of the studies: the module `NAME` draws the result of the study of that name."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from amb_cosim.studies.result import DrawnResult


def figure(result: DrawnResult) -> Figure:
    """Return the figure of a study's result."""
    import matplotlib as mpl

    from amb_cosim.presentation.style import STYLE

    with mpl.rc_context(STYLE):
        drawn: Figure = import_module(f"{__name__}.{result.name}").draw(result)
    return drawn
