"""Numbers of ROSS that are stored with the tests."""

from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

REFERENCE = Path(__file__).parents[1] / "reference"


def complex_numbers(pairs):
    return np.array(pairs) @ [1.0, 1.0j]


def nearest(found, expected):
    """Return a different computed eigenvalue for each expected one."""
    upper = found[found.imag >= 0.0]
    _, chosen = linear_sum_assignment(np.abs(expected[:, np.newaxis] - upper))
    return upper[chosen]


def difference(found, expected):
    """Of the nearest, relative to their size."""
    return np.abs(nearest(found, expected) - expected) / np.abs(expected)
