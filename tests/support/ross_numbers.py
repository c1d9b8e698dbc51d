"""Numbers of ROSS: those stored with the tests and, where it is installed, those that it computes now."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

REFERENCE = Path(__file__).parents[1] / "reference"
STORED_OR_LIVE = ["stored", pytest.param("live", marks=pytest.mark.slow)]


def renewed(script, target):
    """Let a script of the reference write its output anew, in a process of its own; return where it is."""
    if find_spec("ross") is None:
        pytest.skip("ROSS is not installed")
    command = [sys.executable, str(REFERENCE / script), "--output", str(target)]
    process = subprocess.run(command, cwd=target.parent, capture_output=True, text=True, timeout=600, check=False)
    assert process.returncode == 0, process.stderr[-4000:]
    return target


def complex_numbers(pairs):
    return np.array(pairs) @ [1.0, 1.0j]


def nearest(found, expected):
    """Of the eigenvalues found, a different one for each of those expected."""
    upper = found[found.imag >= 0.0]
    _, chosen = linear_sum_assignment(np.abs(expected[:, np.newaxis] - upper))
    return upper[chosen]


def difference(found, expected):
    """Of the nearest, relative to their size."""
    return np.abs(nearest(found, expected) - expected) / np.abs(expected)
