"""ADC and DAC: steps, rounding, range."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from signal_chain.converters import converter_of, quantised


def test_sixteen_bits_over_ten_volts_either_way_are_steps_of_0_305_mv():
    assert converter_of(16.0, 10.0).step == pytest.approx(20.0 / 65536.0, rel=1e-15)
    assert converter_of(14.0, 10.0).step == pytest.approx(1.2207e-3, rel=1e-4)


@given(st.floats(-10.0, 9.9), st.integers(8, 24))
def test_values_are_rounded_to_the_nearest_level(volts, bits):
    converter = converter_of(float(bits), 10.0)
    level = quantised(volts, converter)
    assert abs(level - volts) <= converter.step * (0.5 + 1e-9)
    assert level / converter.step == round(level / converter.step)


@pytest.mark.parametrize("volts", [10.0, 11.0, 1e300])
def test_range_ends_a_bit_below_its_top(volts):
    converter = converter_of(16.0, 10.0)
    assert quantised(volts, converter) == 10.0 - 20.0 / 65536.0
    assert quantised(-volts, converter) == -10.0


def test_error_of_a_vibration_has_the_deviation_of_a_uniform_one():
    x = 3.0 * np.cos(np.arange(100_000) * 0.7391)
    converter = converter_of(12.0, 10.0)
    error = np.array([quantised(v, converter) for v in x]) - x
    assert error.std() == pytest.approx(converter.step / np.sqrt(12.0), rel=0.01)
    assert abs(error.mean()) < 0.01 * converter.step
