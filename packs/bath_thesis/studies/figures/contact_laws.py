"""Hysteresis loops of the classical contact laws."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_assessment.reporting.pictures import figure_of
from bath_thesis.quantities import law_panels
from bath_thesis.studies.contact_hysteresis import ContactLaws


def draw(result: ContactLaws) -> Figure:
    """Draw force against penetration for each law."""
    return figure_of(law_panels(result))
