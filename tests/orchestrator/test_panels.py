"""Plots as data for pages: what JSON can hold."""

import json

import numpy as np

from amb_assessment.reporting.panels import Panel, curve, panel_of


def test_a_curve_with_gaps_is_data_of_json():
    gaps, empty = curve("gaps", [0.0, 1.0, 2.0], [np.nan, 3.0, -2.0]), curve("nothing", [0.0], [np.nan])
    panel = Panel("Radius", "t (s)", "r (m)", (gaps, empty))
    data = json.loads(json.dumps(panel.as_data(), allow_nan=False))
    assert data["least"] == -2.0
    np.testing.assert_array_equal(panel_of(data).curves[0].y, gaps.y)
