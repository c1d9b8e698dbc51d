"""Reach of magnets and sensors at bending modes, against the closed form of a uniform free beam."""

import math

import numpy as np
import pytest

from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.mode_reach import BearingReach, ModeReach, mode_reaches
from rotor_analysis.rotor_file import rotor_from

LENGTH = 2.0
BETA = 4.730040744862704  # first root of cos x cosh x = 1


def beam_shape(z):
    """First bending mode of a free uniform beam over its value at the ends."""
    x = BETA * z / LENGTH
    sigma = (math.cosh(BETA) - math.cos(BETA)) / (math.sinh(BETA) - math.sin(BETA))
    return (math.cosh(x) + math.cos(x) - sigma * (math.sinh(x) + math.sin(x))) / 2.0


def beam(places):
    """Rotor that is a slender beam, with magnets and sensors at (z of magnet, z of sensor)."""
    pairs = list(enumerate(places))
    data = {
        "name": "beam",
        "materials": {"steel": {"youngs_modulus": 2.1e11, "density": 7850.0, "poissons_ratio": 0.3}},
        "shaft": {"material": "steel", "sections": [{"length": LENGTH, "diameter": 0.01}]},
        "bearings": [{"name": f"b{k}", "z": z, "stiffness": 1.0} for k, (z, _) in pairs],
        "sensors": [{"name": f"s{k}", "z": z} for k, (_, z) in pairs],
    }
    return rotor_from(data, "beam")


@pytest.mark.parametrize(
    "places",
    [((0.2, 0.25), (1.8, 1.75)), ((0.3, 0.6), (1.7, 1.4)), ((0.6, 0.3), (1.75, 1.4)), ((0.2, 0.25), (1.7, 1.4))],
)
def test_reach_is_the_signed_product_of_the_shape_of_a_free_beam(places):
    first = mode_reaches(beam(places), ("b0", "b1"), 1)[0]
    for at, (magnet, sensor) in zip(first.bearings, places, strict=True):
        product = beam_shape(magnet) * beam_shape(sensor)
        assert abs(product) > 0.01
        assert at.value == pytest.approx(math.copysign(math.sqrt(abs(product)), product), abs=0.01)


def test_damping_across_a_node_drives_the_mode_by_its_reach():
    """-2 Re s = c phi_m phi_s/m: the exact poles with a damper that pushes at the magnet as the sensor moves."""
    c = 1e-3
    for place in ((0.2, 0.25), (0.3, 0.6), (0.6, 0.3)):
        rotor = beam((place, (1.6, 1.62)))
        free = assemble(rotor)
        M, K = free.M[::2, ::2], free.K[::2, ::2]
        omega, shapes = free_modes(M, K)
        rows = [free.translations[node][0] // 2 for node in sorted(free.translations)]
        phi = shapes[:, 0] / shapes[rows, 0][np.abs(shapes[rows, 0]).argmax()]
        C = np.zeros_like(M)
        C[rows[rotor.bearings[0].node - 1], rows[rotor.sensors[0].node - 1]] = c
        n = len(M)
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
        poles = np.linalg.eigvals(A)
        growth = poles[np.abs(poles - 1j * omega[0]).argmin()].real
        reach = mode_reaches(rotor, ("b0", "b1"), 1)[0].bearings[0].value
        assert growth == pytest.approx(-0.5 * c * reach * abs(reach) / (phi @ M @ phi), rel=0.02)


@pytest.mark.parametrize(
    ("shapes", "bearing", "value"),
    [
        (((0.3, 0.3), (0.4, 0.4)), "b", 0.4),
        (((0.3, 0.3), (0.4, -0.4)), "b", -0.4),
        (((-0.2, 0.2), (0.9, 0.9)), "a", -0.2),
        (((0.0, 0.5), (0.01, -0.01)), "a", 0.0),
        (((-0.5, -0.5), (0.0, 0.3)), "a", 0.5),
    ],
)
def test_the_bearing_that_drives_a_mode_decides(shapes, bearing, value):
    bearings = tuple(BearingReach(name, "s", *pair) for name, pair in zip("ab", shapes, strict=True))
    deciding = ModeReach(1, 100.0, np.zeros(1), bearings).deciding
    assert (deciding.bearing, deciding.value) == (bearing, pytest.approx(value))


@pytest.mark.parametrize(
    ("pair", "kind"), [((1.0, 0.4), ""), ((1.0, -0.6), "non-collocated"), ((1.0, 0.01), "at a node")]
)
def test_a_node_between_magnet_and_sensor_is_named(pair, kind):
    assert BearingReach("b", "s", *pair).kind == kind
