"""Full, condensed and coarse models of the rig."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_assessment.reporting.pictures import figure_of
from bath_thesis.quantities import reduction_panels
from bath_thesis.studies.reduced_models import ModelReduction


def draw(result: ModelReduction) -> Figure:
    """Draw the frequencies (Fig. 3.6), and the unbalance response (Fig. 3.7) with its error."""
    return figure_of(reduction_panels(result))
