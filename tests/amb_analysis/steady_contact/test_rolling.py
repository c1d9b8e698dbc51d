"""Forces and friction of rolling over the angle between two journals, which is free."""

from types import SimpleNamespace

import numpy as np
import pytest

from amb_analysis.steady_contact import rolling as module
from amb_analysis.steady_contact.rolling import rolling
from rotor_contact.contact.site import SITE

CLEARANCES = np.array([2e-4, 3e-4])
ANGLES = np.linspace(0.0, 2.0 * np.pi, 200_001)
SITES = ("left", "right", "seal")


def rotor_of(monkeypatch, R, clearances):
    """A rotor with receptances R at the frequency of rolling; the seal has another ratio of radius to clearance."""
    c = np.array(clearances)
    names, radii = SITES[: len(c)], (100.0 * c[0], 100.0 * c[1], 1.0)
    records = np.zeros(len(c), SITE)
    records["journal_radius"] = radii[: len(c)]
    monkeypatch.setattr(module, "receptances", lambda loop, omega: SimpleNamespace(R=R))
    return SimpleNamespace(sites=names, c=c, loop=lambda Omega: None, records=records, valid_to=np.inf)


def receptances(seed):
    """Receptances whose inverse holds both journals outwards: -E has positive real parts on its diagonal."""
    random = np.random.default_rng(seed)
    E = -1e7 * np.array([[1.0, 0.0], [0.0, 1.4]]) + 1e6 * (random.uniform(-2.0, 2.0, (2, 2, 2)) @ [1.0, 1.0j])
    return np.linalg.inv(E), E


def over_angles(E):
    """N_j (1 + i t_j) = -conj(p_j) sum_k E_jk c_k p_k at many angles, shape (angles, 2), and the journals' p."""
    p = np.stack([np.ones(len(ANGLES), dtype=complex), np.exp(1j * ANGLES)], axis=1)
    return -p.conj() * ((p * CLEARANCES) @ E.T), p


@pytest.mark.parametrize("seed", range(5))
def test_forces_and_friction_of_two_journals_are_maxima_over_angles(seed, monkeypatch):
    R, E = receptances(seed)
    (both,) = [r for r in rolling(rotor_of(monkeypatch, R, CLEARANCES), 100.0) if len(r.contact) == 2]
    N, _ = over_angles(E)
    np.testing.assert_allclose(list(both.N.values()), N.real[:-1].mean(axis=0), rtol=1e-9)
    np.testing.assert_allclose(
        list(both.swing.values()), np.abs(N.real - N.real[:-1].mean(axis=0)).max(axis=0), rtol=1e-7
    )
    assert both.friction == pytest.approx(np.abs(N.imag / N.real).max(), rel=1e-7)


@pytest.mark.parametrize(("share", "count"), [(1.00001, 1), (0.99999, 0)])
def test_a_journal_at_a_third_site_touches_at_its_worst_angle(share, count, monkeypatch):
    """Two journals roll only if their motion at no angle takes the rotor across the clearance of the seal."""
    inner, E = receptances(3)
    coupling = 1e-8 * np.array([2.0 + 1.0j, -1.5 + 2.5j])
    R = np.block([[inner, coupling[:, None]], [coupling[None, :], np.array([[1e-7]])]])
    _, p = over_angles(E)
    reached = np.abs(((p * CLEARANCES) @ E.T) @ coupling).max()
    rotor = rotor_of(monkeypatch, R, [*CLEARANCES, share * reached])
    assert len([r for r in rolling(rotor, 100.0) if r.contact == ("left", "right")]) == count
