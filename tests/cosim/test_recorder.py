"""What is kept of a run."""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.record.recorder import Recorder


def test_recorder_decimates_and_skips_settling():
    recorder = Recorder([2, 0], first=0, every=3)
    for n in range(-5, 8):
        recorder(n, np.array([n, 0.0, 10.0 * n]))
    assert recorder.points.tolist() == [0, 3, 6]
    assert recorder.table.tolist() == [[0, 0], [30, 3], [60, 6]]
    assert recorder.reached == 7


def test_recorder_grows_with_the_run():
    recorder = Recorder([0], first=0)
    for n in range(5000):
        recorder(n, np.array([float(n)]))
    assert recorder.table[:, 0].tolist() == list(range(5000))
