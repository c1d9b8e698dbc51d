"""Confidence intervals with the stated coverage, and parameters without influence on the data."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom

from amb_analysis.measured.least_squares import FreeParameter, fit
from tests.support.messages import raises_naming

F = np.linspace(20.0, 60.0, 40)
TRUE = np.array([3.0, 40.0, 0.02])  # mass (kg), frequency (Hz), damping ratio
FREE = (FreeParameter("mass", 1.0, 6.0), FreeParameter("frequency", 35.0, 45.0), FreeParameter("damping", 0.005, 0.1))
START = (2.0, 38.0, 0.05)


def oscillator(p):
    m, f, zeta = p
    s, omega = 2j * np.pi * F, 2 * np.pi * f
    return 1.0 / (m * (s**2 + 2 * zeta * omega * s + omega**2))


def residuals_of(measured):
    def residuals(p):
        error = np.log(oscillator(p) / measured)
        return np.concatenate([error.real, error.imag])

    return residuals


def test_confidence_intervals_contain_the_truth_in_95_percent():
    rng = np.random.default_rng(7)
    held = np.zeros(3)
    for _ in range(100):
        noise = 0.03 * (rng.standard_normal(len(F)) + 1j * rng.standard_normal(len(F)))
        result = fit(residuals_of(oscillator(TRUE) * np.exp(noise)), FREE, START)
        held += [p.lower <= true <= p.upper for p, true in zip(result.parameters.values(), TRUE, strict=True)]
    least = binom.ppf(1e-3, 100, 0.95)
    assert (held >= least).all()
    assert held.min() >= 88
    assert held.sum() < 300  # intervals that always hold it are too wide


def test_exact_data_give_exact_parameters():
    result = fit(residuals_of(oscillator(TRUE)), FREE, START)
    np.testing.assert_allclose([p.value for p in result.parameters.values()], TRUE, rtol=1e-7)
    assert result.rms_after < 1e-7 < result.rms_before


def test_a_parameter_without_influence_is_refused():
    residuals = residuals_of(oscillator(TRUE))
    with raises_naming(ValueError, "colour", "residuals"):
        fit(lambda p: residuals(p[:3]), (*FREE, FreeParameter("colour", 0.0, 1.0)), (*START, 0.5))


def test_parameters_that_act_as_a_product_are_refused_by_both_names():
    rng = np.random.default_rng(1)
    residuals = residuals_of(oscillator(TRUE) * np.exp(0.01 * rng.standard_normal(len(F))))
    free = (FreeParameter("a", 1.0, 2.0), FreeParameter("b", 1.0, 4.0))
    with raises_naming(ValueError, "a", "95 %", "separated", "b"):
        fit(lambda p: residuals([p[0] * p[1], 40.0, 0.02]), free, (1.5, 2.2))


def test_a_value_beyond_its_bounds_is_found_at_the_bound():
    free = (FreeParameter("mass", 3.5, 6.0), *FREE[1:])
    result = fit(residuals_of(oscillator(TRUE)), free, (4.0, *START[1:]))
    assert result.parameters["mass"].at_bound
    assert not result.parameters["frequency"].at_bound


@pytest.mark.parametrize(
    ("free", "start", "facts"),
    [
        ((FreeParameter("mass", 1.0, 6.0),), (7.0,), ("mass", "7", "1 to 6")),
        (tuple(FreeParameter(f"p{k}", 0.0, 1.0) for k in range(80)), (0.5,) * 80, ("80 residuals",)),
    ],
)
def test_errors_name_the_invalid_argument(free, start, facts):
    with raises_naming(ValueError, *facts):
        fit(lambda p: np.concatenate([F, F]) * p[0], free, start)


def test_bounds_must_ascend():
    with raises_naming(ValueError, "mass", "2 to 1"):
        FreeParameter("mass", 2.0, 1.0)
