"""Synchronous receptance: the transfer functions that the controller inverts."""

from dataclasses import replace

import numpy as np
import pytest
from rotor_cases import BEARINGS, OnePlane, both, discs_at, plant, run

from rotor_analysis.receptance import receptance
from rotor_analysis.rotor_file import load_rotor

SENSORS = [f"s{k}" for k in range(1, 9)]
COLLOCATED = [4, 5, 2, 3]  # sensors at mb1 x, y and mb2 x, y


def test_static_receptance_is_that_of_two_springs_under_a_beam():
    """Two bearings hold the rotor statically determinate: a force on one deflects its spring alone, by 1/k_b."""
    at_rest = receptance(np.array([0.0]))[0]
    np.testing.assert_allclose(at_rest[COLLOCATED], 1e-6 * np.eye(4), atol=1e-15)
    z = np.array([1.948, 1.321, 0.624, 0.0])  # sensor planes
    lever = 1e-6 * (1.321 - z) / (1.321 - 0.624)  # the free ends follow as a rigid body
    np.testing.assert_allclose(at_rest[0::2, 0], lever, atol=1e-14)
    np.testing.assert_allclose(at_rest[1::2, 3], 1e-6 - lever, atol=1e-14)


@pytest.mark.parametrize("Omega", [40.0, 120.0, 250.0])
def test_receptance_matches_the_model_in_complex_coordinates(Omega):
    rotor = load_rotor()
    model = OnePlane.of(rotor, 1e6, 5000.0)
    R = receptance(np.array([Omega]))[0]
    place = [rotor.masters.index(node) for node in rotor.sensor_nodes]
    for sign in (1.0, -1.0):  # force e^(+-i Omega t) in the complex plane
        dynamic = -(Omega**2) * model.M + 1j * sign * Omega * (model.C - 1j * Omega * model.G) + model.K
        response = np.linalg.inv(dynamic)[np.ix_(place, model.bearings)]
        # real phasors of force (1, -+j) and of the response, r = x + i y
        x = R[0::2, 0::2] - sign * 1j * R[0::2, 1::2]
        y = R[1::2, 0::2] - sign * 1j * R[1::2, 1::2]
        expected = response if sign > 0 else response.conj()
        np.testing.assert_allclose(x, expected, rtol=1e-6, atol=1e-13)
        np.testing.assert_allclose(y, -sign * 1j * expected, rtol=1e-6, atol=1e-13)


def test_unbalance_orbit_is_the_receptance_to_its_rotating_force():
    """Unbalance at the bearings makes exactly synchronous forces u Omega^2 (1, -j): no hold, so nearly exact."""
    rotor = load_rotor()
    masses = (replace(body, name=f"body_{body.name}", unbalance=False) for body in rotor.bodies)
    rotor = replace(rotor, bodies=(*masses, *discs_at(4, 4, 11, 11)))
    Omega, steps, turns = 120.0, 200, 60
    h = 2.0 * np.pi / Omega / steps
    x = plant(BEARINGS | both("rb.clearance", 0.1) | {"Omega": Omega, "d1.u": 2e-3, "d3.u": 1e-3, "d3.phi": 1.1}, rotor)
    run(x, steps * (turns - 1), h=h)
    record = run(x, steps, [*SENSORS, "theta"], h=h)
    measured = 2.0 / steps * np.exp(-1j * record[:, 8]) @ record[:, :8]
    R = receptance(np.array([Omega]))[0]
    U = Omega**2 * np.array([2e-3, -2e-3j, 1e-3 * np.exp(1.1j), -1j * 1e-3 * np.exp(1.1j)])
    np.testing.assert_allclose(measured, R @ U, atol=1e-8 * np.max(np.abs(R @ U)))
