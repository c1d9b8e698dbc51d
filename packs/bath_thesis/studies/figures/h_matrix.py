"""Exact and interpolated H, the inverse of the receptance."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_assessment.reporting.pictures import figure_of
from bath_thesis.quantities import h_panels
from bath_thesis.studies.h_interpolation import InverseReceptance


def draw(result: InverseReceptance) -> Figure:
    """Draw norms of H, errors of interpolation, condition number of R and, for the rig, printed and computed H."""
    return figure_of(h_panels(result))
