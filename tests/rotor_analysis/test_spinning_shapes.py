"""Plants of rotors whose gyroscopic moments matter: whirl, responses and receptances of all elements at speed."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import STEEL
from scipy.linalg import eigvals

from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from rotor_analysis.free_rotor import free_rotor
from rotor_analysis.parts import Bearing, Body, Site
from rotor_analysis.reduced_rotor import reduced_rotor, whirl_error, with_modes
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.spinning_shapes import whirl
from tests.support.messages import raises_naming

SPEED = 90000.0 * np.pi / 30.0
BAND = 2.0 * np.pi * 2000.0  # the default
SITES, WHEELS = (8, 30), (3, 35)


def micro_turbine(**options):
    """A turbine and a compressor wheel overhang on thin ends, 0.9 kg together with the shaft."""
    ends = [0.014 if k < 6 or k >= 30 else 0.024 for k in range(36)]
    shaft = Shaft(tuple(np.linspace(0.0, 0.18, 37)), tuple(ends), mass_matrix="consistent", **STEEL)
    turbine, wheel = Body("turbine", 3, 0.22, 4e-5, 6e-5, unbalance=True), Body("wheel", 35, 0.16, 3e-5, 4.5e-5)
    bearings = (Bearing("a", 12), Bearing("b", 26))
    sites = tuple(Site(f"s{node}", node) for node in SITES)
    return Rotor("micro", shaft, (turbine, wheel), bearings, sites, reduction=ReductionOptions(**options))


def frequencies(model, Omega):
    """Of whirl in either direction (rad/s), ascending, by the eigenvalues of both planes together."""
    n = model.size
    right = np.linalg.solve(model.M, np.hstack([-model.K, -Omega * model.G]))
    omega = eigvals(np.vstack([np.eye(n, 2 * n, n), right])).imag
    return np.sort(omega[omega > 50.0])


def circle(model, omega, Omega):
    """Dynamic stiffness of a forward circle x + i y = r exp(i omega t), shape (n, n)."""
    return model.K[::2, ::2] - omega**2 * model.M[::2, ::2] + omega * Omega * model.G[::2, 1::2]


def displacement_error(rotor, omega, Omega, nodes):
    """Of circles at the sites due to forces at nodes, over the largest of them."""
    full, plant = assemble(rotor), reduced_rotor(rotor)
    at, forces = [full.rows(SITES)[k] for k in (0, 2)], [full.rows(nodes)[k] for k in (0, 2)]
    exact = np.linalg.inv(circle(full, omega, Omega))[np.ix_([row // 2 for row in at], [row // 2 for row in forces])]
    result = plant.right[at, ::2] @ np.linalg.solve(circle(plant.model, omega, Omega), plant.left[::2, forces])
    return np.max(np.abs(result - exact)) / np.max(np.abs(exact))


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_plant_with_a_speed_whirls_as_with_all_elements(share):
    """At full speed: 60 Hz (tilt), 1.7 kHz backward, 2.4 kHz forward; at rest 2.0 kHz twice."""
    rotor = micro_turbine(speed=SPEED)
    count = 3 if share else 2
    exact = frequencies(assemble(rotor), share * SPEED)[:count]
    plants = [reduced_rotor(one).model for one in (rotor, micro_turbine())]
    errors = [np.max(np.abs(frequencies(plant, share * SPEED)[:count] / exact - 1.0)) for plant in plants]
    assert errors[0] < 1e-4
    assert errors[1] > 5e-3 * share**2 - 1e-9, "without a speed the error grows with its square"
    assert plants[0].size == plants[1].size + 2


@pytest.mark.parametrize("nodes", [SITES, WHEELS], ids=["sites", "wheels"])
@pytest.mark.parametrize("omega", [SPEED, BAND, -BAND], ids=["unbalance", "forward", "backward"])
def test_displacements_at_speed_are_those_of_all_elements(omega, nodes):
    """Forces at the sites and unbalance of the wheels, whirl up to the end of the band in either direction."""
    error = displacement_error(micro_turbine(speed=SPEED), omega, SPEED, nodes)
    assert error < 5e-4
    assert displacement_error(micro_turbine(), omega, SPEED, nodes) > 10.0 * error


@pytest.mark.parametrize("name", ["nelson_mcvaugh", "compressor", "turbo_expander"])
def test_plant_that_is_accurate_at_its_speed_keeps_every_bit(name):
    rotor = load_rotor(name)
    assert rotor.reduction.speed > 0.0
    at_rest = replace(rotor, reduction=replace(rotor.reduction, speed=0.0))
    error, band = whirl_error(rotor), 2.0 * np.pi * rotor.reduction.band
    count = int(np.sum(error.backward <= band))
    assert count >= 1
    assert np.max(np.abs([*error.forward_error[: count + 1], *error.backward_error[:count]])) < 0.1
    for part in ("M", "G", "K"):
        np.testing.assert_array_equal(*(getattr(reduced_rotor(one).model, part) for one in (rotor, at_rest)))


def test_errors_that_are_told_are_those_of_the_matrices():
    rotor = micro_turbine(speed=SPEED)
    error = whirl_error(rotor, 2)
    told = np.sort([*error.forward, *error.backward])
    np.testing.assert_allclose(told[:4], frequencies(assemble(rotor), SPEED)[:4], rtol=1e-8)
    of_plant = [
        *(error.forward * (1.0 + error.forward_error / 100.0)),
        *(error.backward * (1.0 + error.backward_error / 100.0)),
    ]
    np.testing.assert_allclose(np.sort(of_plant)[:4], frequencies(reduced_rotor(rotor).model, SPEED)[:4], rtol=1e-8)
    assert whirl_error(micro_turbine()) is None


def test_speed_and_accuracy_decide_how_many_shapes_are_added():
    by_speed = [reduced_rotor(micro_turbine(speed=share * SPEED)).model.size for share in (0.01, 1.0)]
    assert by_speed == [16, 18]
    by_accuracy = [
        reduced_rotor(micro_turbine(modes=2, speed=SPEED, accuracy=e)).model.size for e in (1e-2, 1e-4, 1e-6)
    ]
    assert by_accuracy == sorted({*by_accuracy})


def test_no_further_mode_of_the_rotor_at_rest_is_retained():
    """Sampled control may see a mode above half the sample rate only in a residual shape, whatever the speed."""
    exact = free_rotor(assemble(micro_turbine())).frequencies
    of_plants = (reduced_rotor(micro_turbine(speed=speed)).model for speed in (0.0, SPEED))
    same = [
        np.isclose(free_modes(m.M[::2, ::2], m.K[::2, ::2])[0][:4], exact[:4], rtol=1e-8, atol=0.0) for m in of_plants
    ]
    assert same[0].tolist() == same[1].tolist() == [True, True, False, False]


@pytest.mark.parametrize("modes", [0, 1, 3])
def test_modes_that_a_file_counts_whirl_as_with_all_elements(modes):
    rotor = micro_turbine(modes=modes, speed=SPEED, accuracy=1e-4)
    error = whirl_error(rotor, modes)
    assert np.max(np.abs([*error.forward_error, *error.backward_error])) <= 0.01


@pytest.mark.parametrize("modes", [2, 4])
def test_plant_with_more_or_fewer_modes_whirls_as_with_all_elements(modes):
    """The study of modes compares plants at speed; without the speed of the file whirl has an error of 0.5 %."""
    rotor = with_modes(micro_turbine(band=2500.0, speed=SPEED, accuracy=1e-5), modes)
    exact, plant = (frequencies(model, SPEED)[:3] for model in (assemble(rotor), reduced_rotor(rotor).model))
    np.testing.assert_allclose(plant, exact, rtol=1e-5)
    assert with_modes(replace(rotor, reduction=ReductionOptions("none")), modes).reduction.modes == modes


def test_rigid_rotor_whirls_at_the_ratio_of_its_inertias():
    """Free flight: omega = Omega I_p/I_d, and without elastic shapes there is no backward whirl."""
    rotor = micro_turbine()
    full, body = assemble(rotor), rigid_body(rotor)
    omega, _ = whirl(np.zeros(2), free_rotor(full).rigid, SPEED * full.G[::2, 1::2])
    np.testing.assert_allclose(omega, [SPEED * body.polar_inertia / body.diametral_inertia], rtol=1e-6)


def test_accuracy_of_whirl_beyond_rounding_is_refused():
    with raises_naming(ValueError, "reduction.accuracy", "1e-15", "reduction.speed", "9424.78 rad/s"):
        reduced_rotor(micro_turbine(modes=2, speed=SPEED, accuracy=1e-15))
