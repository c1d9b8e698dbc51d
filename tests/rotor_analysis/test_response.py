"""Unbalance response and the linear system: closed forms with their phase, and independent models of the rig."""

import numpy as np
import pytest
from analysis_cases import MASS, jeffcott, rigid, spring, tensor
from rotor_cases import OnePlane

from rotor_analysis.assembly import Matrices
from rotor_analysis.parts import Bearing
from rotor_analysis.reduction import unreduced
from rotor_analysis.response import orbit, synchronous_motion, unbalance_response
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import SupportedRotor, supported_rotor
from tests.support.messages import raises_naming

SPEEDS = np.array([20.0, 150.0, 310.0, 900.0])


def test_jeffcott_orbit_is_the_closed_form_in_size_and_phase():
    """r_0 = u Omega^2 / (k - m Omega^2 + i c Omega) e^(i phi): in phase below the critical speed, opposed far above."""
    c, u = 500.0, 2e-3 * np.exp(0.7j)
    k = spring()
    amplitudes = unbalance_response(jeffcott(damping=c), {2: u}, SPEEDS, (2,))
    expected = u * SPEEDS**2 / (k - MASS * SPEEDS**2 + 1j * c * SPEEDS)
    np.testing.assert_allclose(amplitudes[:, 0, 0], expected, rtol=1e-8)
    np.testing.assert_allclose(amplitudes[:, 0, 1], -1j * expected, rtol=1e-8)
    major, minor, phase = orbit(amplitudes[:, 0])
    np.testing.assert_allclose(major, np.abs(expected), rtol=1e-8)
    np.testing.assert_allclose(minor, np.abs(expected), rtol=1e-8)
    np.testing.assert_allclose(phase, np.angle(expected), rtol=1e-8)
    lag = phase - 0.7
    assert -0.1 < lag[0] < 0.0
    assert -np.pi < lag[-1] < -0.9 * np.pi


def test_cases_of_unbalance_superpose_under_any_support():
    """In a support of stiffness k_s + i c Omega alone, Q = Omega^2 (u, -i u)/(k_s + i c Omega), in every case."""
    support, k, c = jeffcott(), 3e5, 20.0
    cases = [{2: 1e-3}, {2: 2e-3j}, {2: 1e-3 + 2e-3j}]

    def held(Omega):
        return (k + 1j * c * Omega) * np.eye(support.model.size)

    motion = synchronous_motion(support, held, cases, SPEEDS, (2,))
    expected = 1e-3 * SPEEDS**2 / (k + 1j * c * SPEEDS)
    np.testing.assert_allclose(motion[:, 0, 0], np.stack([expected, -1j * expected], axis=1), rtol=1e-12)
    np.testing.assert_allclose(motion[:, 0] + motion[:, 1], motion[:, 2], rtol=1e-12)


def test_nodes_between_the_masters_follow_the_static_deflection():
    """Half the spring's force bends each bearing: x_1 = x_2 k / (2 k_b)."""
    amplitudes = unbalance_response(jeffcott(k_bearing=4e5, damping=100.0), {2: 1e-3}, SPEEDS, (1, 2, 3))
    share = spring(4e5) / (2 * 4e5)
    np.testing.assert_allclose(amplitudes[:, 0], share * amplitudes[:, 1], rtol=1e-7)
    np.testing.assert_allclose(amplitudes[:, 2], share * amplitudes[:, 1], rtol=1e-7)


def test_anisotropic_orbit_is_backward_between_two_critical_speeds():
    k_x, k_y, c, u = 5e5, 2e6, 30.0, 1e-3
    support = rigid(((k_x, 0.0), (0.0, k_y)), tensor(c))
    first, second = np.sqrt(2 * k_x / MASS), np.sqrt(2 * k_y / MASS)
    speeds = np.array([0.5 * first, np.sqrt(first * second), 2.0 * second])
    amplitudes = unbalance_response(support, {2: u}, speeds, (2,))[:, 0]
    x = u * speeds**2 / (2 * k_x - MASS * speeds**2 + 2j * c * speeds)
    y = -1j * u * speeds**2 / (2 * k_y - MASS * speeds**2 + 2j * c * speeds)
    np.testing.assert_allclose(amplitudes, np.column_stack([x, y]), rtol=1e-7)
    major, minor, _ = orbit(amplitudes)
    assert np.sign(minor).tolist() == [1.0, -1.0, 1.0]
    angle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 100_001))
    for k in range(3):
        radius = np.hypot((x[k] * angle).real, (y[k] * angle).real)
        assert major[k] == pytest.approx(radius.max(), rel=1e-8)
        assert abs(minor[k]) == pytest.approx(radius.min(), rel=1e-8)


@pytest.mark.parametrize("condensed", [True, False])
def test_response_of_the_rig_matches_the_independent_planar_model(condensed):
    rotor = load_rotor()
    u = np.array([3e-3, 1e-3j, 0.0, -2e-3 + 1e-3j])
    on_equal = rotor.on_equal_bearings(1e6, 5000.0)
    one_plane = OnePlane.of(rotor, 1e6, 5000.0)
    support = supported_rotor(on_equal, planes=rotor.masters if condensed else None)
    unbalance = dict(zip(rotor.disc_nodes, u, strict=True))
    result = unbalance_response(support, unbalance, np.array([90.0, 180.0]), rotor.masters)
    expected = np.array([one_plane.orbit(Omega, u) for Omega in (90.0, 180.0)])
    if condensed:
        np.testing.assert_allclose(result[:, :, 0], expected, rtol=1e-6)
    else:  # the condensation costs a little, and not nothing
        np.testing.assert_allclose(result[:, :, 0], expected, atol=2e-3 * np.max(np.abs(expected)))
        assert np.max(np.abs(result[:, :, 0] - expected)) > 1e-6 * np.max(np.abs(expected))


def test_slow_unbalance_between_masters_acts_by_static_deflection():
    """f_R = f_m - R_E f_s, where R_E is not the transpose of R_D if a cross-coupled bearing sits between masters."""
    oil = ((1e6, 4e5), (-6e5, 8e5))
    rig = load_rotor()
    rotor = Rotor("oil", rig.shaft, rig.bodies, (Bearing("a", 6, oil), Bearing("b", 12, oil)))
    masters, slowly = (1, 4, 11, 13), np.array([1e-3])
    full, condensed = supported_rotor(rotor), supported_rotor(rotor, planes=masters)
    expected, result = (unbalance_response(s, {5: 1e-3}, slowly, masters) for s in (full, condensed))
    np.testing.assert_allclose(result, expected, rtol=1e-5)


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda s: unbalance_response(s, {9: 1e-3}, SPEEDS, (1,)), ("node", "9")),
        (lambda s: unbalance_response(s, {2: 1e-3}, SPEEDS, (0,)), ("node", "0")),
        (lambda s: unbalance_response(s, {2: np.nan}, SPEEDS, (1,)), ("node 2", "nan kg m")),
        (lambda s: unbalance_response(s, {2: 1.0}, np.array([np.inf]), (1,)), ("Omega", "inf rad/s")),
    ],
)
def test_invalid_arguments_are_refused_by_name(call, facts):
    with raises_naming(ValueError, *facts):
        call(jeffcott(damping=1.0))


def test_undamped_rotor_at_its_critical_speed_has_no_steady_state():
    eye, zero = np.eye(2), np.zeros((2, 2))
    mass = Matrices(eye, zero, zero, zero, 9.0 * eye, {1: (0, 1)})
    with raises_naming(ValueError, "Omega", "3.0 rad/s", "critical speed"):
        unbalance_response(SupportedRotor(load_rotor(), mass, unreduced(mass)), {1: 1.0}, np.array([3.0]), (1,))
