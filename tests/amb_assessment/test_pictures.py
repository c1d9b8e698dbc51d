"""Pictures of reports contain all of their plots."""

import numpy as np
import pytest

from amb_assessment.reporting.panels import Curve, Panel
from amb_assessment.reporting.pictures import figure_of


@pytest.mark.parametrize("letters", [3, 15, 40])
def test_legends_stay_within_the_picture(letters):
    x = np.linspace(0.0, 1.0, 5)
    curves = tuple(Curve(f"{k}".ljust(letters, "n"), x, k * x) for k in range(8))
    figure = figure_of([Panel("title", "x (m)", "y (m)", curves)])
    figure.draw_without_rendering()
    legend = figure.axes[0].get_legend().get_window_extent()
    assert figure.bbox.x0 <= legend.x0
    assert legend.x1 <= figure.bbox.x1
    assert figure.bbox.y0 <= legend.y0
