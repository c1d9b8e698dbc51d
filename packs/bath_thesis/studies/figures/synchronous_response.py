"""Modelled and measured norm of the synchronous response."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_assessment.reporting.pictures import figure_of
from bath_thesis.quantities import norm_panels
from bath_thesis.studies.measured_response import SynchronousResponse


def draw(result: SynchronousResponse) -> Figure:
    """Draw S for forces in x against frequency, with measured values as dots."""
    return figure_of(norm_panels(result))
