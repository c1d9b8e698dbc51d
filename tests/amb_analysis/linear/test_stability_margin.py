"""Zones of the sensitivity and disk margins of all loops, from responses in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest

from amb_analysis.studies import stability_margin
from amb_analysis.studies.stability_margin import zone


def test_zones_begin_at_their_limits():
    assert [zone(peak) for peak in (1.0, 2.999, 3.0, 3.999, 4.0, 4.999, 5.0, 40.0)] == list("AABBCCDD")


def test_least_disk_margin_is_that_between_the_frequencies(monkeypatch):
    """alpha = 1/|S - 1/2| of a loop alone: 0.5 at 333 Hz, with frequencies that are 13 Hz apart there."""

    def closed(model, hertz):
        S = 0.5 + 2.0 / (1.0 + 1j * (hertz - 333.0) / 10.0)
        return np.stack([np.stack([S, S]), np.stack([S, S])])

    monkeypatch.setattr(stability_margin, "response", closed)
    frequencies = np.geomspace(1.0, 2000.0, 200)
    gang, margins = stability_margin._all_loops(SimpleNamespace(demands=("i",), closed=None), frequencies)
    assert len(gang.S) == len(frequencies)
    for margin in margins.values():
        assert len(margin.alpha) == len(frequencies)
        assert (margin.least, margin.frequency) == (pytest.approx(0.5, rel=1e-3), pytest.approx(333.0, abs=1.0))
