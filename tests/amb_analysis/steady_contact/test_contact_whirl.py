"""Ends of long-lasting whirls in contact, from the closed form of a rotor with one mass and one site."""

from types import SimpleNamespace

import numpy as np
import pytest

from amb_analysis.steady_contact import contact_whirl as module
from amb_analysis.steady_contact.contact_whirl import contact_whirls

M, K, C = 10.0, 1e6, 1e-3  # kg, N/m, m: 316.2 rad/s


def whirls_of(monkeypatch, damping, mu, Omega=300.0):
    """Whirls of N + i L = c (m omega^2 - k) - i c d omega."""

    def receptances(loop, omega):
        return SimpleNamespace(R=np.array([[1.0 / (K - M * omega**2 + 1j * damping * omega)]]))

    monkeypatch.setattr(module, "receptances", receptances)
    rotor = SimpleNamespace(sites=("ring",), c=np.array([C]), loop=lambda Omega: None, mu=lambda Omega: np.array([mu]))
    return contact_whirls(rotor, Omega)


def end(damping, ratio):
    """d omega = ratio (m omega^2 - k), and N = c d omega/ratio there."""
    omega = (damping + np.sqrt(damping**2 + 4.0 * ratio**2 * M * K)) / (2.0 * ratio * M)
    return omega, C * damping * omega / ratio


@pytest.mark.parametrize("damping", [0.3, 3.0, 30.0])
def test_whirl_with_friction_ends_where_its_required_force_is_a_tenth(damping, monkeypatch):
    """With mu = 0.15 between ratios 0.25 and 0.05: a band of 0.08 % of its frequency with the least damping."""
    (whirl,) = whirls_of(monkeypatch, damping, 0.15)
    (low, least), (high, largest) = end(damping, 0.25), end(damping, 0.05)
    assert whirl.frequencies == pytest.approx((low, high), rel=1e-9)
    assert whirl.N["ring"] == pytest.approx((least, largest), rel=1e-6)


def test_whirl_without_friction_ends_at_the_limit_of_the_search(monkeypatch):
    (whirl,) = whirls_of(monkeypatch, 3.0, 0.0)
    low, least = end(3.0, 0.1)
    assert whirl.frequencies == pytest.approx((low, 600.0), rel=1e-9)
    assert whirl.N["ring"] == pytest.approx((least, C * (M * 600.0**2 - K)), rel=1e-6)


def test_forces_of_a_whirl_near_a_mode_without_damping_have_no_limit(monkeypatch):
    """N = -c k (omega^2 - a^2)/(omega^2 - b^2) with b at 400.1234 rad/s, below which it is positive from a on."""

    a, b = 350.1234, 400.1234

    def receptances(loop, omega):
        return SimpleNamespace(R=np.array([[(omega**2 - b**2) / (K * ((omega**2 - a**2) or 1e-9))]], dtype=complex))

    monkeypatch.setattr(module, "receptances", receptances)
    rotor = SimpleNamespace(sites=("ring",), c=np.array([C]), loop=lambda Omega: None, mu=lambda Omega: np.zeros(1))
    (whirl,) = contact_whirls(rotor, 300.0)
    assert whirl.frequencies == pytest.approx((a, b), rel=1e-9)
    assert whirl.N["ring"][0] == pytest.approx(0.0, abs=1e-6)
    assert whirl.N["ring"][1] is None
