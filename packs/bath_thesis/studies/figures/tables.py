"""Errors of the natural frequencies by mesh, mass matrix and condensation."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_assessment.reporting.pictures import figure_of
from bath_thesis.quantities import frequency_panels
from bath_thesis.studies.frequency_tables import MeshAndCondensation


def draw(result: MeshAndCondensation) -> Figure:
    """Draw the errors of each mesh relative to the finest mesh, and of the condensed model relative to the full one."""
    return figure_of(frequency_panels(result))
