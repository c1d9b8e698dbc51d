"""Poles of a sampled loop at the frequency of the plant's motion, also above half the sample rate."""

import math

import numpy as np
import pytest

from amb_analysis.linear.aliasing import continuous_poles
from amb_analysis.linear.components import zoh
from amb_analysis.linear.linear_source import source_of_run
from amb_analysis.linear.loop import Loop
from amb_analysis.studies.loop_vibrations import vibrations
from amb_cosim.results.component_names import PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario

SAMPLE_TIME = 1e-3  # s; half the sample rate is 500 Hz


def loop(fast: float, coupling: float, damping: float = 0.01):
    """A free mass of 1 kg under sampled PD control, coupled to a mode of the plant at `fast` (Hz).

    Returns A of the plant, its mass and the poles and eigenvectors of the sampled loop.
    """
    omega = 2.0 * math.pi * fast
    mass = np.diag([1.0, 0.5])
    K, C = np.diag([0.0, 0.5 * omega**2]), np.diag([0.0, damping * omega])
    B = np.array([[0.0], [0.0], *np.linalg.solve(mass, np.array([[1.0], [coupling]]))])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(mass, K), -np.linalg.solve(mass, C)]])
    Phi, Gamma = zoh(A, B, SAMPLE_TIME)
    slow = 2.0 * math.pi * 20.0
    gains = np.array([[slow**2, coupling * slow**2, 1.0 * slow, coupling * slow]])
    z, vectors = np.linalg.eig(Phi - Gamma @ gains)
    return A, mass, z.astype(np.complex128), vectors.astype(np.complex128)


def frequencies(s):
    """Of the vibrations (Hz), ascending."""
    return np.sort(s.imag[s.imag > 1.0]) / (2.0 * math.pi)


@pytest.mark.parametrize("fast", [120.0, 480.0, 560.0, 936.0, 1021.0, 1700.0, 2250.0])
def test_mode_of_the_plant_keeps_its_frequency_above_half_the_sample_rate(fast):
    """Those at 936 and 1021 Hz look like 64 and 21 Hz, the latter like the controlled motion at about 20 Hz."""
    A, mass, z, vectors = loop(fast, 0.02)
    s = continuous_poles(z, SAMPLE_TIME, vectors, A, mass)
    np.testing.assert_allclose(np.exp(s * SAMPLE_TIME), z, rtol=1e-9)
    slow, plant = frequencies(s)
    assert slow == pytest.approx(20.0, rel=0.2)
    assert plant == pytest.approx(fast, rel=2e-3)


def test_sense_of_whirl_is_not_that_of_the_alias():
    """Forward whirl at 936 Hz, x + i y = exp(s t), is backward at 64 Hz in the samples."""
    omega = 2.0 * math.pi * 936.0
    K, G = omega**2 * np.eye(2), 2.0 * 50.0 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    A = np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -G]])
    z, vectors = np.linalg.eig(zoh(A, np.zeros((4, 1)), SAMPLE_TIME)[0])
    s = continuous_poles(z, SAMPLE_TIME, vectors, A, np.eye(2))
    exact = np.linalg.eigvals(A)
    np.testing.assert_allclose(np.sort(s.imag), np.sort(exact.imag), rtol=1e-6)
    for pole, (x, y) in zip(s, vectors[:2].T, strict=True):
        sense = 2.0 * (x * np.conj(y)).imag / (abs(x) ** 2 + abs(y) ** 2)
        forward = abs(pole.imag) > omega
        assert math.copysign(1.0, sense * pole.imag) == (1.0 if forward else -1.0)


def test_pole_at_zero_and_a_resting_plant_have_no_alias():
    A, mass = np.block([[np.zeros((1, 1)), np.eye(1)], [-1e4 * np.eye(1), np.zeros((1, 1))]]), np.eye(1)
    z = np.array([0.0, 0.5 + 0.1j])
    s = continuous_poles(z, SAMPLE_TIME, np.zeros((2, 2), dtype=np.complex128), A, mass)
    assert s[0] == 0.0
    assert s[1] == pytest.approx(np.log(z[1]) / SAMPLE_TIME)


def test_fast_modes_of_a_machine_are_those_of_its_rotor():
    """Half the sample rate is 2 kHz; the rig has 28 modes above, up to 9959 Hz, that control hardly reaches."""
    prepared = prepare_run(as_scenario("drop", None).machine())
    loop = Loop(source_of_run(prepared))
    Omega = 100.0
    (plant,) = loop.linear_components.at(Omega).parts([PLANT])
    above = 1.01 * math.pi / loop.sample_time  # poles of the controller are at half the sample rate itself
    exact = np.linalg.eigvals(plant.law.A).imag
    s = vibrations(loop, Omega).poles
    np.testing.assert_allclose(np.sort(s.imag[s.imag > above]), np.sort(exact[exact > above]), rtol=1e-3)
