"""Currents that measure the loop: lines, phases, and the wait for the transient."""

import numpy as np
import pytest
from rig import AXES

from amb_analysis.studies.injection import (
    multi_sines,
    schroeder_phases,
    settling_samples,
    share_of_new,
    waiting_samples,
)
from amb_cosim.controllers.laws import Law
from tests.support.messages import raises_naming


def test_injected_lines_interleave_and_fill_the_range():
    signals, lines = multi_sines(len(AXES), 16000, 250e-6)
    assert sorted(lines.ravel()) == list(range(4, 8000))
    spectra = np.abs(np.fft.rfft(signals, axis=1))
    for local, spectrum in zip(lines, spectra, strict=True):
        assert np.ptp(spectrum[local]) < 1e-9 * spectrum[local].max()
        assert np.delete(spectrum, local).max() < 1e-9 * spectrum[local].max()
    np.testing.assert_allclose(np.abs(signals).max(axis=1), 1.0)


def test_schroeder_phases_of_equal_powers_are_quadratic():
    i = np.arange(1, 9)
    np.testing.assert_allclose(schroeder_phases(np.full(8, 0.125)), -np.pi * i * (i - 1) / 8)


def test_measurement_waits_until_the_transient_is_gone():
    assert 0.999 ** settling_samples(0.999, 250e-6) == pytest.approx(1e-6, rel=1e-3)
    with raises_naming(ValueError, "0.999990", "60 s"):
        settling_samples(0.99999, 250e-6)


@pytest.mark.parametrize(("seen", "seconds"), [(0.0, 0.0), (1e-9, 0.0), (0.1, 14.0)])
def test_a_slow_drift_is_waited_for_if_the_lines_see_it(seen, seconds):
    """A vibration of 50 Hz that decays in 0.14 s by 1e-6, and a drift by exp(-t/s), which the outputs see or do not."""
    T = 250e-6
    s = -100.0 + 2j * np.pi * 50.0
    vibration, drift = np.exp(s * T), np.exp(-1.0 * T)
    A = np.zeros((3, 3))
    A[:2, :2] = [[vibration.real, vibration.imag], [-vibration.imag, vibration.real]]
    A[2, 2] = drift
    law = Law(A, np.array([[1.0], [0.0], [1.0 - drift]]), np.array([[1.0, 0.0, seen]]), np.zeros((1, 1)))
    waited = waiting_samples(law, T) * T
    if seconds:
        assert 1.0 < waited < seconds
    else:
        assert waited == pytest.approx(np.log(1e6) / 100.0, rel=1e-2)


def test_injected_current_is_as_late_as_the_demand():
    """Over a sample from the change on, the means of the steps have the mean of the late current."""
    assert share_of_new(0.0, 4) == {0: 1.0}
    for late in (0.25, 0.3, 0.5, 0.9):
        shares = share_of_new(late, 4)
        new = [max((share for j, share in shares.items() if j <= step), default=0.0) for step in range(8)]
        assert sum(new[:4]) / 4 + (new[4] - 1.0) / 4 == pytest.approx(1.0 - late)
