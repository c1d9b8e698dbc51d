"""The signal chain and the faults of sensors in front of a linear law."""

import numpy as np
import pytest
from linear_bench import Bench, T

from amb_cosim import linear_controller

Y = np.array([1e-4, -2e-4, 3e-4])
NAMES = ["a.x", "a.y", "b"]


def bench(**values):
    """The readings themselves as demands."""
    return Bench(linear_controller(np.eye(3), NAMES, ["u", "v", "w"], T), signals=Y, **values)


@pytest.mark.parametrize(
    ("fault", "value", "expected"),
    [("dead", 1.0, [0.0, 0.0]), ("stuck", 1.0, [0.0, 0.0]), ("offset", 2e-5, [1.0, 2e-5])],
)
@pytest.mark.parametrize("sensor", range(3))
def test_a_sensor_fault_affects_its_signal_alone(sensor, fault, value, expected):
    """A dead sensor reads 0, a stuck one its last value, and one with an offset adds it."""
    sensors = bench()
    sensors.step(Y)
    result = sensors.step(3.0 * Y, **{f"{NAMES[sensor].replace('.', '__')}__fault_{fault}": value})
    factor, added = expected
    retained = Y[sensor] if fault == "stuck" else 0.0
    np.testing.assert_allclose(result[sensor], factor * 3.0 * Y[sensor] + added + retained, rtol=1e-12, atol=1e-18)
    np.testing.assert_array_equal(np.delete(result, sensor), np.delete(3.0 * Y, sensor))


def test_scale_multiplies_a_signal():
    np.testing.assert_allclose(bench(b__scale=1.5).step(Y) / Y, [1.0, 1.0, 1.5], rtol=1e-14)


def test_adc_flags_a_signal_beyond_its_range():
    sensors = bench(chain__preset=2, chain__adc=1)
    sensors.step(Y)
    assert sensors.instance["adc_limited"] == 0.0
    result = sensors.step([2e-3, 0.0, 0.0])
    assert sensors.instance["adc_limited"] == 1.0
    assert result[0] == pytest.approx(1.25e-3, rel=1e-4)
