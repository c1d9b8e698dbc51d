"""Test force of an identification."""

from __future__ import annotations

from matplotlib.figure import Figure

from amb_assessment.reporting.pictures import figure_of
from bath_thesis.quantities import force_panels
from bath_thesis.studies.identification_force import IdentificationForce


def draw(result: IdentificationForce) -> Figure:
    """Draw S, force amplitude, revolutions in a slot, duration of an identification, and the journals' response."""
    return figure_of(force_panels(result))
