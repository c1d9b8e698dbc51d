"""The pole that decides on the stability of a sampled loop, in closed form."""

import math

import numpy as np
import pytest
from scipy.linalg import block_diag, expm

from amb_analysis.linear.stability import stability_of
from amb_cosim.results.loop_stability import LARGEST
from tests.support.messages import assert_names

T = 50e-6  # s
FREE = np.array([[0.0, 1.0], [0.0, 0.0]])  # a mass that nothing holds


def oscillator(sigma: float, omega: float) -> np.ndarray:
    """Continuous, with the poles sigma +- j omega."""
    return np.array([[0.0, 1.0], [-(sigma**2 + omega**2), 2.0 * sigma]])


def sampled(*parts: np.ndarray, seed: int = 1) -> np.ndarray:
    """Return uncoupled sampled parts, in mixed coordinates with units that differ by up to 1e6."""
    A = expm(block_diag(*parts) * T)
    mixed = np.linalg.qr(np.random.default_rng(seed).standard_normal(A.shape))[0]
    units = np.geomspace(1e-3, 1e3, len(A))
    return (mixed @ A @ mixed.T) * units[:, None] / units


def test_a_mass_on_a_negative_spring_drifts_at_its_rate():
    """m x'' = k x grows with sqrt(k/m)."""
    found = stability_of(sampled(np.array([[0.0, 1.0], [58.0**2, 0.0]]), oscillator(-20.0, 3000.0)), T)
    assert not found.is_stable
    assert found.is_drift
    assert found.growth_rate == pytest.approx(58.0, rel=1e-6)
    assert found.radius == pytest.approx(math.exp(58.0 * T), rel=1e-9)
    assert found.decrement == -LARGEST
    assert_names(found.motion, "drift", "58 1/s")


def test_a_vibration_has_its_frequency_rate_and_decrement():
    found = stability_of(sampled(oscillator(3.0, 5000.0), oscillator(-20.0, 300.0)), T)
    assert (found.growth_rate, found.frequency) == pytest.approx((3.0, 5000.0), rel=1e-6)
    assert found.decrement == pytest.approx(-2.0 * math.pi * 3.0 / 5000.0)
    assert_names(found.motion, "795.77 Hz", "3 1/s")


def test_a_real_pole_near_minus_one_alternates_at_half_the_sample_rate():
    found = stability_of(np.diag([-1.01, 0.9]), T)
    assert not found.is_stable
    assert found.frequency == pytest.approx(math.pi / T)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("free", "count"), [((FREE, FREE), 4), ((np.zeros((1, 1)),), 1)], ids=["masses", "integrator"])
def test_a_free_mass_or_integrator_neither_grows_nor_decays(free, count, seed):
    """Rounding splits a double pole by the root of the precision, 1e-8 and more, and one half leaves the circle."""
    found = stability_of(sampled(*free, oscillator(-20.0, 3000.0), seed=seed), T)
    assert (found.on_circle, found.is_stable) == (count, True)
    assert found.growth_rate == pytest.approx(-20.0, rel=1e-6)
    assert f"{count} pole" in found.note


@pytest.mark.parametrize("rate", [1e-3, 1e-2, 1.0])
def test_slow_growth_is_distinguished_from_rounding(rate):
    found = stability_of(sampled(np.array([[rate]]), oscillator(-20.0, 3000.0)), T)
    assert (found.on_circle, found.is_stable) == (0, False)
    assert found.growth_rate == pytest.approx(rate, rel=1e-2)
