"""What becomes of a rotor after its power is lost."""

import numpy as np
import pytest

from amb_cosim.acceptance.parts.recovery import time_to_standstill

TIMES = np.linspace(0.0, 1.0, 201)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_friction_of_constant_force_stops_the_spin_when_its_momentum_is_used(sense):
    """J Omega' = -M: t = J Omega/M, of either sense of rotation; what was at the beginning does not count."""
    speeds = 400.0 - 8.0 * TIMES
    speeds[:20] += 5.0
    assert time_to_standstill(TIMES, sense * speeds) == pytest.approx(50.0)


@pytest.mark.parametrize("gain", [0.0, 3.0])
def test_a_spin_that_loses_no_speed_never_stands_still(gain):
    assert time_to_standstill(TIMES, 400.0 + gain * TIMES) == np.inf
