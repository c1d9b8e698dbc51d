"""Complex arithmetic of the kernels: right, and the same bits compiled and in plain Python."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rolac_controller import complex_numbers
from rolac_controller.complex_numbers import phasor, quotient, scaled, squared_magnitude

part = st.floats(1e-6, 1e6) | st.floats(-1e6, -1e-6)
number = st.builds(complex, part, part)


def plain(name):
    """A kernel as ordinary Python that calls no compiled code."""
    kernels = {n: getattr(k, "py_func", k) for n, k in vars(complex_numbers).items() if callable(k)}
    function = kernels[name]
    return type(function)(function.__code__, vars(complex_numbers) | kernels, name)


@given(number, number)
def test_quotient_is_that_of_complex_division_with_the_same_bits_in_plain_python(a, b):
    assert quotient(a, b) == pytest.approx(a / b, rel=1e-15)
    assert quotient(a, b) == plain("quotient")(np.complex128(a), np.complex128(b))


@given(number, part)
def test_scaled_number_has_the_bits_of_the_product_with_a_real(a, factor):
    assert scaled(a, factor) == a * factor == np.complex128(a) * factor


@given(number)
def test_squared_magnitude_is_a_number_times_its_conjugate(a):
    assert squared_magnitude(a) == (a * a.conjugate()).real


@given(st.floats(-1e6, 1e6))
def test_phasor_turns_on_the_unit_circle(angle):
    assert abs(phasor(angle)) == pytest.approx(1.0, rel=1e-15)
    assert phasor(angle) == complex(math.cos(angle), math.sin(angle))
