"""Bodies whose centre of mass lies off their seat, against closed forms and a rigid stub."""

import math

import numpy as np
import pytest

from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.element import Material
from rotor_analysis.harmonic import harmonic_model, harmonic_points
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.parts import Bearing, Body, CentreOfMass, Sensor
from rotor_analysis.response import unbalance_response
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.static_load import carried_masses
from rotor_analysis.supported_rotor import supported_plant, supported_rotor

STEEL = {"youngs_modulus": 2.05e11, "density": 7850.0, "poissons_ratio": 0.29}
MASS, I_D, I_P, OFFSET = 5.0, 0.0205, 0.0245, -0.081
SPEED = 3000.0


def bell(node: int, offset: float = OFFSET, name: str = "bell") -> Body:
    return Body(name, node, MASS, I_D, I_P, unbalance=True, offset=offset)


def overhung(*bodies: Body, nodes=None, stub: bool = False) -> Rotor:
    """A flexible shaft of 0.3 m in two bearings; with `stub`, a stiff, massless element follows its last node."""
    z = np.linspace(0.0, 0.3, 13)
    shaft = Shaft(tuple(z), (0.03,), **STEEL)
    materials = {}
    if stub:
        materials = {"steel": Material(2.05e11, 7850.0, 0.29), "rigid": Material(2.05e18, 0.0, 0.29)}
        shaft = Shaft((*z, 0.3 + 0.06), (*([0.03] * 12), 0.03), material=(*["steel"] * 12, "rigid"))
    bearings = (Bearing("a", 2, 2e6, 300.0), Bearing("b", 9, 3e6, 300.0))
    return Rotor("overhung", shaft, bodies, bearings, sensors=(Sensor("tip", 13),), materials=materials)


def spectrum(rotor: Rotor, Omega: float = SPEED, count: int = 8):
    values = eigenvalues(on_bearings(assemble(rotor), rotor), Omega)
    return np.sort_complex(values[values.imag > 1.0])[np.argsort(np.abs(np.sort_complex(values[values.imag > 1.0])))][
        :count
    ]


def test_a_rigid_body_off_its_seat_has_the_modes_of_the_closed_form():
    """Translation x of the centre of mass and tilt, with springs at a and -b from it, and gyroscopic moments."""
    k, z_seat, z_1, z_2 = 4e5, 0.1, 0.0, 0.25
    shaft = Shaft((z_1, z_seat, z_2), (0.2,), youngs_modulus=1e15, density=1e-9, poissons_ratio=0.3)
    rotor = Rotor("rigid", shaft, (bell(2),), (Bearing("a", 1, k), Bearing("b", 3, k)))
    a, b = z_1 - (z_seat + OFFSET), z_2 - (z_seat + OFFSET)
    K = k * np.array([[2.0, a + b], [a + b, a * a + b * b]])
    M, gyro = np.diag([MASS, I_D]), np.diag([0.0, I_P * SPEED])
    # x + i y = r exp(i omega t):  (K - omega^2 M + omega gyro) r = 0 by the convention of `critical_speeds`
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [np.linalg.solve(M, K), np.linalg.solve(M, gyro)]])
    exact = np.sort(np.abs(np.linalg.eigvals(A).real))
    values = eigenvalues(on_bearings(assemble(rotor), rotor), SPEED)
    result = np.sort(values.imag[(values.imag > 1.0) & (values.imag < 1e5)])
    np.testing.assert_allclose(result, exact, rtol=1e-6)


def test_a_body_off_its_seat_has_the_modes_of_a_body_on_a_rigid_stub():
    result = spectrum(overhung(bell(13, 0.06)))
    np.testing.assert_allclose(result, spectrum(overhung(bell(14, 0.0), stub=True)), rtol=1e-5)
    wrong = spectrum(overhung(bell(13, -0.06)))
    assert abs(wrong[0] / result[0] - 1.0) > 0.1


@pytest.mark.parametrize("reduce", [supported_rotor, supported_plant])
def test_unbalance_acts_at_the_centre_of_mass(reduce):
    offset, stub = overhung(bell(13, 0.06)), overhung(bell(14, 0.0), stub=True)
    speeds, nodes = np.array([300.0, 900.0, 2500.0]), (2, 9, 13)
    exact = unbalance_response(supported_rotor(stub), {14: 1e-5}, speeds, nodes)
    point = offset.point_of("bell")
    assert point == CentreOfMass(13, 0.06)
    result = unbalance_response(reduce(offset), {point: 1e-5}, speeds, nodes)
    scale = np.abs(exact).max(axis=(1, 2), keepdims=True)
    assert np.max(np.abs(result - exact) / scale) < (1e-4 if reduce is supported_rotor else 2e-3)
    at_seat = unbalance_response(reduce(offset), {13: 1e-5}, speeds, nodes)
    assert np.max(np.abs(at_seat - exact) / scale) > 0.1


def test_weight_acts_at_the_centre_of_mass():
    """Of a body in the middle of the span, the bearing towards which it hangs carries m (1/2 + |d|/L)."""
    shaft = Shaft((0.0, 0.5, 1.0), (0.05,), youngs_modulus=2e11, density=1e-9, poissons_ratio=0.3)
    rotor = Rotor("beam", shaft, (bell(2, 0.1),), (Bearing("left", 1, 1e6), Bearing("right", 3, 1e6)))
    carried = carried_masses(rotor)
    assert carried["left"] == pytest.approx(0.4 * MASS, rel=1e-6)
    assert carried["right"] == pytest.approx(0.6 * MASS, rel=1e-6)


def test_mass_centre_and_inertias_are_those_of_the_body_in_its_place():
    rotor = overhung(bell(10, -0.05))
    exact = rigid_body(overhung(bell(8, 0.0)))  # 0.05 m before
    result = rigid_body(rotor)
    for name in ("mass", "centre", "polar_inertia", "diametral_inertia"):
        assert getattr(result, name) == pytest.approx(getattr(exact, name), rel=1e-12)
    assert rotor.position_of(rotor.point_of("bell")) == pytest.approx(0.175)


def test_a_harmonic_force_on_a_body_acts_at_its_centre_of_mass():
    rotor, omega = overhung(bell(13, 0.06)), 2.0 * math.pi * 300.0
    model = harmonic_model(rotor, [13], omega, rotor.bearings)
    points = harmonic_points(rotor)
    assert points[-1] == CentreOfMass(13, 0.06)
    assert len(points) == 14
    unit = np.eye(2 * len(points))[:, [26]]
    result = model.response(np.array([omega]), SPEED, unit, np.eye(2 * len(points)), None)[0]
    full = on_bearings(assemble(rotor), rotor).at(SPEED)
    force = np.zeros(full.size)
    force[48], force[50] = 1.0, 0.06  # along x at the last node, and the moment along its slope
    D = -(omega**2) * full.M + 1j * omega * (full.C + SPEED * full.G) + full.K
    q = np.linalg.solve(D, force)
    exact = np.array([*q.reshape(-1, 4)[:, :2].ravel(), *(q[48:50] + 0.06 * q[50:52])])
    assert np.max(np.abs(result[:, 0] - exact)) < 2e-3 * np.max(np.abs(exact))


def test_an_offset_in_mm_is_reported():
    assert any("offset of bell" in text for text in implausible_sizes(overhung(bell(10, -50.0))))
    assert not implausible_sizes(overhung(bell(10, -0.05)))


def test_an_offset_follows_its_body_onto_another_mesh():
    rotor = overhung(bell(13, 0.06))
    finer = rotor.on_mesh(rotor.shaft.on_nodes(tuple(np.linspace(0.0, 0.3, 25))))
    assert finer.point_of("bell") == CentreOfMass(25, 0.06)
