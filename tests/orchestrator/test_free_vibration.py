"""The vibration that is not periodic with the rotation, against the sinusoids of which a motion is made."""

import numpy as np
import pytest

from amb_cosim.results.free_vibration import free_vibration


@pytest.mark.parametrize(("turns", "samples"), [(10.0, 800), (12.3, 777), (40.0, 401)])
@pytest.mark.parametrize("order", [0.47, 1.5, 2.55, 7.4])
def test_free_vibration_has_the_rms_of_its_sinusoid_in_both_halves(turns, samples, order):
    """a/sqrt(2) between harmonics, of 0.2 and 0.1; the orbit and its third harmonic are forced."""
    theta = 2.0 * np.pi * turns * np.arange(samples) / samples
    forced = 7.0 + np.stack([3.0 * np.cos(theta), 3.0 * np.sin(theta) + 0.5 * np.cos(3.0 * theta)], axis=1)
    still = free_vibration(forced, turns)
    assert still.after < 0.02
    assert still.total == pytest.approx(np.sqrt(9.0 + 0.125), rel=0.02)
    amplitude = np.where(np.arange(samples) < samples // 2, 0.2, 0.1)
    own = free_vibration(forced + np.stack([amplitude * np.sin(order * theta), 0.0 * theta], axis=1), turns)
    assert own.before == pytest.approx(0.2 / np.sqrt(2.0), rel=0.1)
    assert own.after == pytest.approx(0.1 / np.sqrt(2.0), rel=0.1)


def test_every_vibration_of_a_rotor_at_rest_is_its_own():
    time = np.arange(500) / 500.0
    own = free_vibration(0.3 * np.sin(2.0 * np.pi * 9.2 * time)[:, None] + 1.0, 0.0)
    assert [own.before, own.after, own.total] == pytest.approx([0.3 / np.sqrt(2.0)] * 3, rel=0.02)


def test_few_turns_have_lines_of_harmonics_alone():
    assert free_vibration(np.random.default_rng(1).normal(size=(400, 2)), 4.0) is None
