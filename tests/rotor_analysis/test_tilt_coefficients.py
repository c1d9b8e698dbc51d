"""Moments of bearings and seals over the slopes of the shaft, against closed forms of a rigid rotor."""

from dataclasses import replace

import numpy as np
import pytest

from amb_analysis.linear.rotor_and_magnets import rotor_component
from amb_cosim.model_constants.plant_data import plant
from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.harmonic import harmonic_model
from rotor_analysis.parts import NO_TENSOR, AtSpeed, Bearing, Body
from rotor_analysis.rigid_body import floating_motions
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.supported_rotor import supported_plant, supported_rotor
from rotor_analysis.undamped import planes_are_alike, undamped_frequencies

K, C, MASS, I_D, I_P, SPEED = 4e5, 200.0, 5.0, 0.0205, 0.0245, 1500.0
A, B = -0.1, 0.15  # m, of both bearings from the body


def turned(direct, cross=0.0):
    return ((direct, cross), (-cross, direct))


def rigid(*seals, nodes=(0.0, 0.1, 0.25), method="none"):
    shaft = Shaft(nodes, (0.2,), youngs_modulus=1e15, density=1e-6, poissons_ratio=0.3)
    bearings = (Bearing("a", 1, turned(K), turned(C)), Bearing("b", len(nodes), turned(K), turned(C)))
    body = Body("wheel", nodes.index(0.1) + 1, MASS, I_D, I_P)
    return Rotor("rigid", shaft, (body,), bearings, seals=seals, reduction=ReductionOptions(method))


def closed_form(K_t, C_t=0.0, Omega=SPEED):
    """Eigenvalues of r = x + i y: of translation and slope at the body, with complex K_t = k - i Q of the moments."""
    stiffness = np.array([[2.0 * K, K * (A + B)], [K * (A + B), K * (A * A + B * B) + K_t]])
    damping = np.array([[2.0 * C, C * (A + B)], [C * (A + B), C * (A * A + B * B) + C_t - 1j * Omega * I_P]])
    M = np.diag([MASS, I_D])
    A_2 = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, stiffness), -np.linalg.solve(M, damping)]])
    return np.linalg.eigvals(A_2)


def slowest(values, count=8):
    """Eigenvalues of x and y: those of r and their conjugates, without the modes of the stiff shaft."""
    values = values[np.abs(values) < 1e5]
    return np.sort_complex(np.round(values, 3))[:count]


def expected(*moments):
    values = closed_form(*moments)
    return slowest(np.concatenate([values, values.conj()]))


@pytest.mark.parametrize(
    ("stiffness", "damping", "moments"),
    [
        (turned(3000.0), NO_TENSOR, (3000.0,)),
        (turned(-3000.0), turned(5.0), (-3000.0, 5.0)),
        (turned(500.0, 2000.0), turned(1.0, 0.5), (500.0 - 2000.0j, 1.0 - 0.5j)),
    ],
)
def test_moments_act_on_the_slopes_of_a_rigid_rotor(stiffness, damping, moments):
    seal = Bearing("disc", 2, tilt_stiffness=stiffness, tilt_damping=damping)
    constant = rigid(seal)
    table = tuple(AtSpeed(speed, tilt_stiffness=stiffness, tilt_damping=damping) for speed in (0.0, 3000.0))
    for rotor in (constant, rigid(replace(seal, tilt_stiffness=NO_TENSOR, tilt_damping=NO_TENSOR, at_speed=table))):
        result = slowest(eigenvalues(on_bearings(assemble(rotor), rotor), SPEED))
        np.testing.assert_allclose(result, expected(*moments), rtol=1e-5, atol=2e-2)
    assert np.abs(expected(*moments) - expected(0.0)).max() > 10.0


def test_a_negative_tilt_stiffness_is_that_of_three_springs_without_net_force():
    """-k, 2 k, -k at distances h on a rigid shaft: -2 k h^2. On a flexible one they also bend it between them."""
    h, k = 0.003, 1.345e7
    nodes = (0.0, 0.1 - h, 0.1, 0.1 + h, 0.25)
    springs = tuple(Bearing(f"s{n}", n, turned(v)) for n, v in ((2, -k), (3, 2.0 * k), (4, -k)))
    three = rigid(*springs, nodes=nodes)
    moment = rigid(Bearing("disc", 3, tilt_stiffness=turned(-2.0 * k * h * h)), nodes=nodes)
    results = [slowest(eigenvalues(on_bearings(assemble(rotor), rotor), 0.0)) for rotor in (three, moment)]
    np.testing.assert_allclose(*results, rtol=1e-3, atol=0.1)


SEAL = Bearing(
    "gland", 4, turned(2e5, 3e4), turned(100.0), tilt_stiffness=turned(4e3, -900.0), tilt_damping=turned(3.0, 0.4)
)
TABLE = tuple(
    AtSpeed(speed, turned(k), turned(90.0), tilt_stiffness=turned(0.02 * k, 300.0), tilt_damping=turned(2.0))
    for speed, k in ((0.0, 1e5), (1000.0, 3e5), (2500.0, 4e5))
)


def flexible(*seals, method="free_modes"):
    shaft = Shaft(tuple(np.linspace(0.0, 0.4, 9)), (0.03,), youngs_modulus=2.05e11, density=7850.0, poissons_ratio=0.29)
    bodies = (Body("wheel", 9, MASS, I_D, I_P, unbalance=True, offset=0.02),)
    bearings = (Bearing("a", 2, turned(2e6), turned(300.0)), Bearing("b", 7, turned(2e6), turned(300.0)))
    reduction = ReductionOptions(method, modes=6) if method == "free_modes" else ReductionOptions(method)
    return Rotor("flexible", shaft, bodies, bearings, seals=seals, reduction=reduction)


@pytest.mark.parametrize("seal", [SEAL, Bearing("gland", 4, at_speed=TABLE)], ids=["constant", "over speed"])
def test_a_reduced_rotor_has_the_same_moments(seal):
    rotor = flexible(seal)
    full, reduced = (support(rotor).model for support in (supported_rotor, supported_plant))
    exact, result = (slowest(eigenvalues(model, SPEED), 400) for model in (full, reduced))
    lowest = exact[np.argsort(np.abs(exact))[:6]]
    nearest = np.array([np.abs(result - value).min() for value in lowest])
    assert np.max(nearest / np.abs(lowest)) < 2e-3
    without = flexible(replace(seal, tilt_stiffness=NO_TENSOR, tilt_damping=NO_TENSOR, at_speed=_without(seal)))
    other = slowest(eigenvalues(supported_rotor(without).model, SPEED), 400)
    assert max(np.abs(other - value).min() / abs(value) for value in lowest) > 1e-2


def _without(seal):
    return tuple(AtSpeed(row.speed, row.stiffness, row.damping) for row in seal.at_speed)


@pytest.mark.parametrize("method", ["none", "free_modes"])
@pytest.mark.parametrize("seal", [SEAL, Bearing("gland", 4, at_speed=TABLE)], ids=["constant", "over speed"])
def test_the_plant_has_the_moments_of_the_analyses(seal, method):
    """From the constants of the FMU, in which they are a further seal."""
    rotor = flexible(seal, method=method)
    model, constants = plant(rotor)
    held = {f"{b}.{name}": value for b in "ab" for name, value in (("k_b", 2e6), ("c_b", 300.0))}
    A_plant = rotor_component("plant", model.layout, constants, held, SPEED).law.A
    exact = eigenvalues(supported_plant(rotor).model, SPEED)
    result = np.linalg.eigvals(A_plant)
    for value in exact[np.abs(exact) < 2e4]:
        assert np.abs(result - value).min() < 1e-6 * max(abs(value), 1.0)
    assert {"gland.beyond_table", "gland.tilt.beyond_table"} <= set(model.interface.position)


def test_a_harmonic_force_meets_the_moments():
    rotor, omega = flexible(SEAL), 900.0
    supports = (*rotor.bearings, *rotor.seals)
    unit = np.eye(20)[:, [16]]  # x of the last of nine nodes; then come x and y of the wheel's centre of mass
    result = harmonic_model(rotor, [9], omega, supports).response(np.array([omega]), SPEED, unit, unit.T, None)[0, 0, 0]
    full = on_bearings(assemble(rotor), rotor).at(SPEED)
    D = -(omega**2) * full.M + 1j * omega * (full.C + SPEED * full.G) + full.K
    assert result == pytest.approx(np.linalg.inv(D)[32, 32], rel=1e-3)


def test_a_single_bearing_with_tilt_stiffness_holds_a_rotor():
    shaft = Shaft((0.0, 0.1), (0.2,), youngs_modulus=1e15, density=1e-6, poissons_ratio=0.3)
    one = Rotor("one", shaft, (Body("wheel", 1, MASS, I_D, I_P),), (Bearing("a", 1, turned(K)),))
    held = replace(one, bearings=(Bearing("a", 1, turned(K), tilt_stiffness=turned(800.0)),))
    speeds = np.array([0.0])
    assert floating_motions(one, speeds) == 2
    assert floating_motions(held, speeds) == 0
    result = undamped_frequencies(on_bearings(assemble(held), held), held, 2)
    np.testing.assert_allclose(result, np.sort([np.sqrt(K / MASS), np.sqrt(800.0 / I_D)]), rtol=1e-5)
    unlike = replace(held, bearings=(Bearing("a", 1, turned(K), tilt_stiffness=((800.0, 0.0), (0.0, 700.0))),))
    assert planes_are_alike(held)
    assert not planes_are_alike(unlike)
    four = undamped_frequencies(on_bearings(assemble(unlike), unlike), unlike, 2)
    exact = np.sqrt([K / MASS, K / MASS, 800.0 / I_D, 700.0 / I_D])
    np.testing.assert_allclose(four, np.sort(exact), rtol=1e-5)
