"""Gyroscopic moments of a rigid disc: sign and size."""

import numpy as np
import pytest
from rotor_cases import OnePlane, plant_rotor
from scipy.linalg import eig

from rotor_analysis.assembly import assemble
from rotor_analysis.parts import Disc
from rotor_analysis.shaft import Shaft
from rotor_analysis.spectrum import eigenvalues


def complex_eigenvalues(M, D, K):
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-K, -D]])
    B = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), M]])
    return eig(A, B, right=False)


@pytest.mark.parametrize(("radius", "width"), [(0.2, 0.01), (0.05, 0.3)])
def test_free_rigid_disc_precesses_forward_at_the_ratio_of_its_inertias(radius, width):
    """Torque-free motion: I_d r'' = i Omega I_p r', a precession at Omega I_p / I_d."""
    shaft = Shaft((0.0, 0.01, 0.02), (0.1,), 2e15, 1e-9, 0.3)
    body = Disc("disc", 2, 30.0, radius, width)
    rotor = plant_rotor("disc", shaft, (body,), (1, 2, 3), (1, 3))
    Omega = 100.0
    model = OnePlane.of(plant_rotor("disc", shaft, (body,), (1, 3), (1, 3)))
    ratio = 6 * radius**2 / (3 * radius**2 + width**2)  # (m r^2 / 2) / (m (3 r^2 + w^2) / 12)
    whirl = complex_eigenvalues(model.M, -1j * Omega * model.G, model.K)
    assert np.max(whirl.imag) == pytest.approx(ratio * Omega, rel=1e-5)  # positive: forward
    result = eigenvalues(assemble(rotor), Omega)
    assert np.min(np.abs(result - 1j * ratio * Omega)) < 1e-4 * Omega
    angular = np.zeros((12, 1), dtype=complex)
    angular[6], angular[7] = 1.0, -1j  # slopes x', y' of the disc in forward whirl: y follows x
    full = assemble(rotor)
    rate = ratio * Omega
    moment = (-(rate**2) * full.M + 1j * rate * Omega * full.G) @ angular
    assert np.abs(moment[6, 0]) < 1e-9 * rate**2 * full.M[6, 6]
