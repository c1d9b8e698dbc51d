"""The lag of solid iron: its asymptotes, and its corner from the iron against solutions of the field."""

import math

import numpy as np
import pytest
from axial_diffusion import gap_flux
from scipy.constants import mu_0
from scipy.integrate import quad
from scipy.linalg import solve_banded

from tests.support.messages import raises_naming
from thrust_bearings.disc import ThrustDisc
from thrust_bearings.eddy_currents import SolidIron, corner_frequency, half_order_lag, pole_face

OMEGA_E = 2.0 * math.pi * 120.0
DISC = ThrustDisc(0.025, 0.055, 12e-4, 0.5e-3, 80.0, 4.0, 10.0, 1.3)


def test_phase_tends_to_minus_45_degrees_and_magnitude_to_a_root():
    s = 1j * OMEGA_E * np.array([1e6, 1e8])
    G = half_order_lag(s, OMEGA_E)
    np.testing.assert_allclose(np.degrees(np.angle(G)), -45.0, atol=0.05)
    assert abs(G[0] / G[1]) == pytest.approx(10.0, rel=1e-3)
    assert half_order_lag(np.array(0j), OMEGA_E) == 1.0


def test_phase_at_the_corner_is_minus_22_and_a_half_degrees():
    """1 + exp(i pi/4) has half the angle of its second term, and the magnitude 2 cos(pi/8)."""
    G = complex(half_order_lag(np.array(1j * OMEGA_E), OMEGA_E))
    assert math.degrees(math.atan2(G.imag, G.real)) == pytest.approx(-22.5, abs=1e-10)
    assert abs(G) == pytest.approx(0.5 / math.cos(math.pi / 8.0), rel=1e-12)


@pytest.mark.parametrize("fed_from", [0, 1])
def test_share_of_the_flux_along_a_pole_face_is_integrated_exactly(fed_from):
    ring = (0.03, 0.041)
    edge, end = ring[fed_from], ring[1 - fed_from]
    share = quad(lambda r: ((r**2 - end**2) / (edge**2 - end**2)) ** 2 / r, *ring)[0]
    assert pole_face(ring, edge) == pytest.approx(share, rel=1e-9)
    assert pole_face((0.0, 0.02), 0.02) == pytest.approx(0.25, rel=1e-12)  # of a full disc: int r^3 dr/r_b^4


def test_corner_follows_gap_conductivity_and_permeability():
    """omega_e = (R_0/c)^2, c with the root of sigma/mu: a wider gap or a poorer conductor lags less."""
    iron = SolidIron(4e6, 500.0, 0.02)
    corner = corner_frequency(DISC, iron)
    assert corner_frequency(DISC, SolidIron(1e6, 500.0, 0.02)) == pytest.approx(4.0 * corner, rel=1e-12)
    assert corner_frequency(DISC, SolidIron(4e6, 1000.0, 0.02)) == pytest.approx(2.0 * corner, rel=1e-12)
    wide = ThrustDisc(0.025, 0.055, 12e-4, 1e-3, 80.0, 4.0, 10.0, 1.3)
    assert corner_frequency(wide, iron) == pytest.approx(4.0 * corner, rel=1e-12)
    assert corner_frequency(DISC, SolidIron(4e6, 500.0, 0.03)) < corner


def test_iron_of_a_half_space_has_the_reluctance_of_its_skin():
    """Finite differences of H'' = s sigma mu H: H/flux per width is sqrt(s sigma/mu), which (2) has."""
    sigma, mu, s = 4e6, 500.0 * mu_0, 2j * math.pi * 50.0
    x = np.linspace(0.0, 20.0 / math.sqrt(abs(s) * sigma * mu), 4001)
    step = x[1]
    n = len(x) - 2
    bands = np.zeros((3, n), dtype=complex)
    bands[0, 1:], bands[2, :-1] = 1.0, 1.0
    bands[1] = -2.0 - s * sigma * mu * step**2
    right = np.zeros(n, dtype=complex)
    right[0] = -1.0
    H = np.concatenate([[1.0], solve_banded((1, 1), bands, right), [0.0]])
    flux = mu * np.trapezoid(H, x)
    assert 1.0 / flux == pytest.approx(np.sqrt(s * sigma / mu), rel=1e-4)


@pytest.mark.parametrize(
    ("permeability", "conductivity", "gap", "depth", "within"),
    [
        (500.0, 4e6, 0.5e-3, 0.015, 0.14),
        (1000.0, 2e6, 0.8e-3, 0.02, 0.1),
        (2000.0, 5e6, 0.4e-3, 0.012, 0.11),
        (200.0, 6e6, 0.4e-3, 0.01, 0.31),
    ],
)
def test_lag_of_a_bearing_is_near_that_of_the_field_solution(permeability, conductivity, gap, depth, within):
    """The flux of the poles, by finite volumes, over the static one; a lag without leakage or faces is further off."""
    iron = SolidIron(conductivity, permeability, depth)
    disc = ThrustDisc(0.025, 0.055, 12e-4, gap, 80.0, 1.0, 10.0, 1.3)
    s = 2j * math.pi * np.array([3.0, 30.0, 200.0, 1000.0])
    static = gap_flux(disc, iron, 0j, 1e-4, 1.3)
    field = np.array([gap_flux(disc, iron, at, 1e-4, 1.3) for at in s]) / static
    ratio = half_order_lag(s, corner_frequency(disc, iron)) / field
    assert np.abs(ratio - 1.0).max() < within
    assert np.degrees(np.abs(np.angle(ratio))).max() < 6.5
    assert np.degrees(np.angle(field[-1])) < -25.0


@pytest.mark.parametrize(
    ("wrong", "facts"),
    [
        ((0.0, 500.0, 0.02), ("conductivity", "0 S/m", "> 0 S/m")),
        ((4e6, 1.0, 0.02), ("permeability", "1", "> 1")),
        ((4e6, 500.0, 0.02, 0.9), ("leakage", "0.9", ">= 1", "<= 3")),
        ((4e6, 500.0, -1.0), ("slot_depth", "-1 m", "> 0 m")),
    ],
)
def test_invalid_iron_is_refused(wrong, facts):
    with raises_naming(ValueError, *facts):
        SolidIron(*wrong)
