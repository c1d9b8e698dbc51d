"""Whirls sustained by friction of two masses on springs, each within its ring."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import root

from amb_analysis.steady_contact import whirl as module
from amb_analysis.steady_contact.whirl import whirls

MASSES = np.array([3.0, 2.0])  # kg
C = np.array([2e-4, 3e-4])  # m
HIGHEST = 1500.0  # rad/s


def dynamic_stiffness(omega, springs, dampers):
    """Z with Z q = F, for springs to the ground and between the masses (N/m), and dampers to the ground (N s/m)."""
    first, second, between = springs
    own = np.array([first + between, second + between]) - MASSES * omega**2 + 1j * np.array(dampers) * omega
    return np.array([[own[0], -between], [-between, own[1]]])


def sustained(monkeypatch, springs, dampers, mu, order):
    """Frequencies of the whirls by the sites in contact, with the rings in an order."""

    def receptances(loop, omega):
        return SimpleNamespace(R=np.linalg.inv(dynamic_stiffness(omega, springs, dampers))[np.ix_(order, order)])

    motion = SimpleNamespace(rates=np.array([-1.0, 0.0]), frequencies=np.zeros(2))
    monkeypatch.setattr(module, "receptances", receptances)
    monkeypatch.setattr(module, "Dynamics", lambda *_: SimpleNamespace(about=lambda *_: motion))
    rotor = SimpleNamespace(
        sites=tuple("ab"[k] for k in order),
        c=C[order],
        records=[SimpleNamespace(journal_radius=0.02)] * 2,
        loop=lambda Omega: SimpleNamespace(sample_time=None),
        mu=lambda Omega, omega: np.array(mu)[order],
        mu_slope=lambda Omega, omega: np.zeros(2),
        valid_to=np.inf,
    )
    found = whirls(rotor, 300.0, HIGHEST)
    return sorted(("".join(sorted(whirl.contact)), whirl.frequency) for whirl in found)


def solved(springs, dampers, mu):
    """Frequencies of (1) for both sites: Im N = 0 in frequency and angle by Powell's method from many starts."""

    def forces(omega, angle):
        p = np.exp(1j * np.array([0.0, angle]))
        return -p.conj() * (dynamic_stiffness(omega, springs, dampers) @ (C * p)) / (1.0 + 1j * np.array(mu))

    found = set()
    for omega in np.outer((-1.0, 1.0), np.geomspace(100.0, HIGHEST, 25)).ravel():
        for angle in np.arange(6) * np.pi / 3.0:
            end = root(lambda at: forces(*at).imag, (omega, angle), tol=1e-11)
            if end.success and abs(end.x[0]) < HIGHEST and (forces(*end.x).real > 0.0).all():
                found.add(round(float(end.x[0]), 4))
    return sorted(found)


FOLDS = {
    "one beside a fold": ((163236.75, 591228.90, 62079.497), (190.42788, 10.750190), (0.052779573, 0.37452460)),
    "two in a step": ((1348639.6, 1098036.5, 21822.957), (171.02241, 34.508502), (0.38461583, 0.17067921)),
    "one by each order": ((1710380.9, 1042043.9, 21820.583), (212.36363, 20.778593), (0.46156420, 0.087636487)),
    "close to a fold": ((533078.86, 316103.25, 10930.893), (22.136333, 40.209151), (0.39372158, 0.20341008)),
}


@pytest.mark.parametrize("case", FOLDS)
@pytest.mark.parametrize("order", [[0, 1], [1, 0]], ids=["in order", "reversed"])
def test_all_whirls_beside_folds_are_found_in_any_order_of_the_sites(case, order, monkeypatch):
    computed = [omega for contact, omega in sustained(monkeypatch, *FOLDS[case], order) if contact == "ab"]
    np.testing.assert_allclose(computed, solved(*FOLDS[case]), rtol=1e-6)


def test_a_single_site_whirls_where_its_force_is_real(monkeypatch):
    """Im E = (d omega - mu (k - m omega^2))/(1 + mu^2) vanishes at one negative omega with N > 0."""
    springs, dampers, mu = (1e5, 5e8, 0.0), (30.0, 30.0), (0.2, 0.2)
    backward = -dampers[0] - np.sqrt(dampers[0] ** 2 + 4.0 * mu[0] ** 2 * MASSES[0] * springs[0])
    computed = sustained(monkeypatch, springs, dampers, mu, [0, 1])
    assert [contact for contact, _ in computed] == ["a"]
    assert computed[0][1] == pytest.approx(backward / (2.0 * mu[0] * MASSES[0]), rel=1e-9)


@pytest.mark.parametrize("dampers", [(0.0, 0.0), (20.0, 30.0)])
def test_nothing_sustains_a_whirl_without_friction(dampers, monkeypatch):
    """Rounding about natural frequencies of the pinned rotor, where forces are unbounded, is no zero."""
    assert sustained(monkeypatch, (3e5, 2e5, 5e4), dampers, (0.0, 0.0), [0, 1]) == []
