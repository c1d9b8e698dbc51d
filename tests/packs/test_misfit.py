"""How far a value is from a statement, as a number."""

from __future__ import annotations

import math

import pytest

from bath_thesis.misfit import misfit
from source_check.statements import Statement

MOST = math.log(10.0)
STATED = {"key": "fig4_9.force", "where": "Fig. 4.9", "what": "force", "source": "run", "quantity": "peak_force"}


@pytest.mark.parametrize(
    ("fields", "ours", "expected"),
    [
        ({"value": 1.0}, 2.0, math.log(2.0)),
        ({"value": 1.0}, 0.5, math.log(2.0)),
        ({"value": 1.0}, 1e6, MOST),
        ({"value": 1.0}, None, MOST),
        ({"value": 1.0}, 0.0, MOST),
        ({"value": 1.0, "absolute": 1.0}, 3.0, math.log(2.0)),
        ({"value": 0.0, "absolute": 0.01}, 0.0, 0.0),
        ({"value": 0.0, "absolute": 0.01}, 0.01, math.log(2.0)),
        ({"value": 0.0}, 0.5, MOST),
        ({"value": -3000.0}, 3000.0, MOST),
        ({"value": -3000.0}, -6000.0, math.log(2.0)),
        ({"value": 1.0, "relation": "below"}, 0.5, 0.0),
        ({"value": 1.0, "relation": "below"}, 0.0, 0.0),
        ({"value": 1.0, "relation": "below"}, 2.0, math.log(2.0)),
        ({"value": 1.0, "relation": "below"}, None, MOST),
        ({"value": 1.0, "relation": "above"}, 2.0, 0.0),
        ({"value": 1.0, "relation": "above"}, 0.5, math.log(2.0)),
        ({"value": (1.0, 4.0)}, [2.0, 4.0], math.log(2.0) / 2.0),
        ({"value": (1.0, 4.0)}, [1.0], MOST),
        ({"value": "RB1"}, "RB1", 0.0),
        ({"value": "RB1"}, "RB2", 1.0),
        ({"value": "RB1"}, None, 1.0),
        ({"value": True}, False, 1.0),
        ({"value": True}, True, 0.0),
    ],
)
def test_misfit_counts_factors_and_outcomes(fields, ours, expected):
    assert misfit(Statement(**STATED, **fields), ours) == pytest.approx(expected)
