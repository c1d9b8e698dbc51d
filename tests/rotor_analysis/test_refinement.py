"""Maxima of curves are those of the curves, not of their samples: sharp, close, hidden, smooth and of either sign."""

import numpy as np
import pytest
from analysis_cases import MASS, jeffcott, rigid, spring, tensor

from rotor_analysis.refinement import about_resonances, refined
from rotor_analysis.resonances import resonances
from rotor_analysis.response import dynamic_stiffness


@pytest.mark.parametrize("zeta", [1e-1, 1e-3, 1e-6])
@pytest.mark.parametrize("points", [12, 101, 3000])
def test_a_peak_has_its_closed_form_from_any_samples(zeta, points):
    """u r^2/|1 - r^2 + 2 i zeta r|, whose largest value is 1/(2 zeta sqrt(1 - zeta^2))."""

    def response(r):
        return r**2 / (1.0 - r**2 + 2j * zeta * r)

    r, values = refined(response, np.linspace(0.013, 31.0, points), np.abs)
    assert np.abs(values).max() == pytest.approx(0.5 / (zeta * np.sqrt(1.0 - zeta**2)), rel=1e-3)
    assert len(r) < points + 400


def test_largest_of_many_resonances_is_located_near_known_modes():
    random = np.random.default_rng(3)
    for _ in range(50):
        at, width = random.uniform(5.0, 95.0, 5), 10.0 ** random.uniform(-4.0, 0.5, 5)
        residue = random.normal(size=5) + 1j * random.normal(size=5)

        def response(x, at=at, width=width, residue=residue):
            return (residue / (x[:, None] - at - 1j * width)).sum(axis=1)

        grid = np.linspace(0.0, 100.0, 41)
        _, values = refined(response, about_resonances(grid, list(zip(at, width, strict=True))), np.abs)
        dense = (at + width * np.tan(np.linspace(-1.5, 1.5, 3001))[:, None]).ravel()
        largest = np.abs(response(dense[(dense > 0.0) & (dense < 100.0)])).max()
        assert np.abs(values).max() >= largest * (1.0 - 2e-3)


@pytest.mark.parametrize("shift", [0.0, -5.0, 5.0])
def test_a_smooth_curve_of_any_sign_has_its_maximum(shift):
    grid, dense = np.linspace(0.0, 6.0, 7), np.linspace(0.0, 6.0, 100_001)

    def curve(x):
        return shift - np.cos(x) + 0.1 * np.sin(3.0 * x)

    _, values = refined(curve, grid, lambda heights: heights)
    assert values.max() == pytest.approx(curve(dense).max(), abs=2e-3 * (curve(dense).max() - curve(grid).min()))


NARROW = {
    "bell": lambda x: np.exp(-(x**2)),
    "flanks of 1/x^2": lambda x: 1.0 / (1.0 + x**2),
    "two tops with a dip": lambda x: np.exp(-((x - 1.5) ** 2)) + np.exp(-((x + 1.5) ** 2)),
}


@pytest.mark.parametrize("resonant", [False, True])
@pytest.mark.parametrize("base", [0.0, -2.0, 5.0])
@pytest.mark.parametrize("shape", NARROW)
def test_a_narrow_top_does_not_depend_on_where_the_samples_lie(shape, base, resonant):
    """Flanks symmetric about a sample do not make it the maximum, and a dip between two maxima is none."""
    highest = NARROW[shape](np.linspace(-3.0, 3.0, 100_001)).max()
    for width in (1.0, 0.5, 0.3, 0.2):  # of samples at a distance of 1
        for at in np.linspace(4.5, 5.5, 21):
            x, values = refined(
                lambda x, at=at, width=width: base + NARROW[shape]((x - at) / width),
                np.linspace(0.0, 10.0, 11),
                lambda of: of,
                resonant=resonant,
            )
            assert values.max() == pytest.approx(base + highest, rel=2e-3), (width, at)
            assert len(x) < 160


@pytest.mark.parametrize("resonant", [False, True])
@pytest.mark.parametrize("place", [0.02, 0.2, 0.45])
def test_a_top_between_the_first_two_or_the_last_two_samples_counts(place, resonant):
    for width in (0.5, 0.1, 0.03):
        for at in (place, 10.0 - place):
            _, values = refined(
                lambda x, at=at, width=width: 1.0 / np.hypot(1.0, (x - at) / width),
                np.linspace(0.0, 10.0, 11),
                lambda of: of,
                resonant=resonant,
            )
            assert values.max() == pytest.approx(1.0, rel=1e-3), (width, at)


@pytest.mark.parametrize("curve", [np.cos, lambda x: np.exp(-x), lambda x: 1e-9 * np.sin(1e5 * x) - 22.0])
def test_smooth_curves_and_rounding_need_few_samples(curve):
    x, _ = refined(curve, np.linspace(0.0, 10.0, 41), lambda of: of, resonant=False)
    assert len(x) <= 44


def test_refinement_keeps_the_first_samples_and_adds_between_them():
    grid = np.linspace(1.0, 2.0, 5)
    x, values = refined(lambda x: 1.0 / (x - 1.4 - 0.001j), grid, np.abs)
    assert set(grid) <= set(x)
    assert (np.diff(x) > 0.0).all()
    assert len(x) == len(values) > 20


def test_critical_speeds_have_the_half_width_of_their_damping():
    """k - m Omega^2 + i c Omega: sigma = c/(2 m), along x and along y."""
    c = 0.4
    (x, y) = resonances(lambda Omega: dynamic_stiffness(jeffcott(damping=c).model, Omega), np.linspace(1.0, 900.0, 9))
    for at, width in (x, y):
        assert at == pytest.approx(np.sqrt(spring() / MASS), rel=1e-6)
        assert width == pytest.approx(c / (2.0 * MASS), rel=1e-3)


def test_a_hardly_excited_critical_speed_is_known():
    """Stiffness of x and y differ by 2e-5; between two speeds of the grid both critical speeds are found."""
    k = 5e5
    support = rigid(((k, 0.0), (0.0, k * (1.0 + 2e-5))), tensor(0.1))
    found = resonances(lambda Omega: dynamic_stiffness(support.model, Omega), np.linspace(1.0, 3000.0, 20))
    ends = np.sqrt(2.0 * k / MASS), np.sqrt(2.0 * k * (1.0 + 2e-5) / MASS)
    np.testing.assert_allclose([at for at, _ in found[:2]], ends, rtol=1e-7)
