"""Damping of the rotor between its bearings: proportional and modal, at rest and turning with the shaft."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import MASS, STEEL, D, E, L, jeffcott, one_plane, tensor
from scipy.optimize import brentq

from rotor_analysis.assembly import assemble
from rotor_analysis.damping import Damping
from rotor_analysis.modes import modes
from rotor_analysis.pairs import turned
from rotor_analysis.parts import Bearing, Body, Disc
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.response import dynamic_stiffness
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming

NODES = tuple(np.linspace(0.0, 1.2, 9).tolist())
FREE = Rotor("free", Shaft(NODES, 0.05, **STEEL), (Disc("end", 1, 5.0, 0.1, 0.02), Disc("inner", 4, 8.0, 0.1, 0.02)))
METHODS = {
    "msdc": ReductionOptions("msdc", (1, 3, 4, 7, 9)),
    "free_modes": ReductionOptions("free_modes", modes=3),
    "none": ReductionOptions("none"),
}


def elastic_ratios(rotor):
    """Damping ratios of the elastic modes of a free rotor in one plane, lowest first."""
    return [mode.damping_ratio for mode in modes(supported_rotor(rotor).model, 0.0) if mode.frequency > 100.0][::2]


def test_proportional_damping_is_half_of_alpha_over_omega_plus_beta_omega():
    """zeta = (alpha / omega + beta omega) / 2, of a shaft without bodies: `mass` is that of the shaft alone."""
    alpha, beta = 3.0, 2e-6
    rotor = replace(FREE, bodies=(), damping=Damping(mass=alpha, stiffness=beta))
    elastic = [mode for mode in modes(supported_rotor(rotor).model, 0.0) if mode.frequency > 100.0][:8]
    omega = np.array([abs(mode.eigenvalue) for mode in elastic])
    np.testing.assert_allclose([m.damping_ratio for m in elastic], 0.5 * (alpha / omega + beta * omega), rtol=1e-6)


def test_shaft_damping_does_not_damp_bodies_or_bearings():
    damped = replace(FREE, damping=Damping(mass=5.0))
    on_bearing = replace(damped, bearings=(Bearing("a", 1, tensor(1e6)),))
    np.testing.assert_array_equal(supported_rotor(on_bearing).full.C, assemble(damped).C)
    np.testing.assert_array_equal(assemble(damped).C, assemble(replace(damped, bodies=())).C)


def test_modal_ratios_are_those_of_the_free_elastic_modes():
    """One by one, and the last one for all beyond."""
    result = elastic_ratios(replace(FREE, damping=Damping(modal=(0.01, 0.03, 0.02))))
    np.testing.assert_allclose(result[:6], [0.01, 0.03, 0.02, 0.02, 0.02, 0.02], rtol=1e-7)


@pytest.mark.parametrize("damping", [Damping(stiffness=1e-5), Damping(modal=0.02), Damping(loss_factor=0.02)])
def test_rigid_motion_is_not_damped_internally(damping):
    model = assemble(replace(FREE, damping=damping)).viscous()
    along, tilting = np.zeros((2, model.size // 2))
    along[::2], tilting[::2], tilting[1::2] = 1.0, NODES, 1.0
    R = one_plane(model.R)
    assert np.max(np.abs(R @ np.stack([along, tilting], axis=1))) < 1e-9 * np.max(np.abs(R))


def internally_damped(c_e, beta, rotating=1.0):
    """Jeffcott's rotor on stiff bearings with external damping c_e at its disc and internal damping beta k."""
    rotor = replace(jeffcott(1e14, c_e).rotor, damping=Damping(stiffness=beta, rotating=rotating))
    return supported_rotor(rotor, planes=(2,)).model


def growth(model, Omega):
    return float(np.max(eigenvalues(model, Omega).real))


@pytest.mark.parametrize("c_e", [0.0, 20.0, 80.0])
def test_internal_damping_makes_a_jeffcott_rotor_unstable_above_threshold(c_e):
    """Omega_th = omega_n (1 + c_e / c_i) (Kimball 1924; Genta, Dynamics of Rotating Systems, 2005)."""
    k = 48.0 * E * np.pi * D**4 / 64.0 / L**3
    omega, beta = np.sqrt(k / MASS), 2e-5
    model, threshold = internally_damped(c_e, beta), omega * (1.0 + c_e / (beta * k))
    assert brentq(lambda Omega: growth(model, Omega), 0.5 * threshold, 2.0 * threshold) == pytest.approx(threshold)
    assert growth(model, 0.99 * threshold) < 0.0 < growth(model, 1.01 * threshold)
    assert growth(model, -0.99 * threshold) < 0.0 < growth(model, -1.01 * threshold)
    for sense, whirl in ((1.0, "forward"), (-1.0, "backward")):
        (unstable,) = (m for m in modes(model, sense * 1.01 * threshold) if m.damping_ratio < 0.0)
        assert unstable.whirl == whirl


def test_damping_in_the_fixed_frame_is_stable_at_any_speed():
    for Omega in (0.0, 100.0, 1e4):
        assert growth(internally_damped(0.0, 2e-5, rotating=0.0), Omega) < 0.0


def test_rotating_damping_does_not_resist_a_bend_rotating_with_it():
    """A synchronous forward circle is at rest in the frame of the shaft; a backward one is not."""
    Omega, forward = 300.0, np.tile([1.0, -1j], 2 * len(NODES))
    damped, undamped = assemble(replace(FREE, damping=Damping(modal=0.05))), assemble(FREE)
    size = np.kron(np.arange(1.0, len(NODES) + 1) ** 2, np.ones(4))  # a bent shape
    difference = dynamic_stiffness(damped, Omega) - dynamic_stiffness(undamped, Omega)
    scale = np.max(np.abs(difference @ (size * forward.conj())))
    assert np.max(np.abs(difference @ (size * forward))) < 1e-10 * scale


def test_share_that_rotates_is_taken_from_the_fixed_frame():
    parts = [assemble(replace(FREE, damping=Damping(mass=1.0, modal=0.01, rotating=r))) for r in (0.0, 0.3, 1.0)]
    fixed, mixed, rotating = parts
    np.testing.assert_allclose(mixed.R, 0.3 * rotating.R, rtol=1e-12)
    np.testing.assert_allclose(mixed.C + mixed.R, fixed.C, rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(rotating.C, assemble(replace(FREE, damping=Damping(mass=1.0))).C)


@pytest.mark.parametrize("method", METHODS)
def test_coordinates_of_every_reduction_come_in_pairs_x_and_y(method):
    """Rotating all pairs by a right angle leaves an isotropic rotor unchanged."""
    model = reduced_rotor(replace(FREE, reduction=METHODS[method], damping=Damping(mass=1.0, modal=0.01))).model
    J = turned(model.size)
    for matrix in (model.M, model.C, model.R, model.G, model.K):
        np.testing.assert_allclose(matrix @ J, J @ matrix, atol=1e-12 * np.max(np.abs(matrix)))
    assert model.R.any()
    np.testing.assert_allclose(model.G, -model.G.T, rtol=1e-9, atol=1e-9)


def test_reduced_rotor_keeps_the_ratios_of_its_first_modes():
    rotor = replace(FREE, reduction=METHODS["free_modes"], damping=Damping(modal=0.02))
    ratios = [mode.damping_ratio for mode in modes(reduced_rotor(rotor).model, 0.0) if mode.frequency > 100.0]
    np.testing.assert_allclose(ratios[:4], 0.02, rtol=1e-3)


def test_thesis_rig_has_no_damping_to_the_last_bit():
    model = assemble(load_rotor())
    assert not model.C.any()
    assert not model.R.any()
    assert not np.signbit(model.C).any()
    assert model.at(100.0).K is model.K


def test_rotating_damping_requires_anisotropic_bearings_as_masters():
    shaft = Shaft(NODES, 0.05, **STEEL)
    bearings = (Bearing("a", 2, tensor(1e6)), Bearing("b", 8, ((1e6, 0.0), (0.0, 2e6))))
    rotor = Rotor("on_oil", shaft, (Body("disc", 4, 5.0, 0.02, 0.04),), bearings, damping=Damping(modal=0.01))
    assert supported_rotor(rotor, planes=(2, 4, 8)).model.size == 6
    with raises_naming(ValueError, "anisotropic bearings"):
        supported_rotor(rotor, planes=(1, 4, 9))
    assert supported_rotor(replace(rotor, damping=Damping(modal=0.01, rotating=0.0)), planes=(1, 4, 9)).model.size == 6
