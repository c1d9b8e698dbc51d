"""Beam elements against closed forms and against properties of every beam."""

import math

import numpy as np
import pytest
from analysis_cases import one_plane
from hypothesis import given, settings
from hypothesis import strategies as st
from rotor_cases import STEEL, shaft_only

from rotor_analysis.assembly import assemble
from tests.support.messages import raises_naming

LENGTH = 1.2


def random_shafts():
    spans = st.lists(st.floats(0.05, 1.0), min_size=1, max_size=6)
    return st.builds(
        lambda gaps, diameter, nu, density: shaft_only(
            np.concatenate([[0.0], np.cumsum(gaps)]), diameter, poissons_ratio=nu, density=density
        ),
        spans,
        st.floats(0.01, 0.2),
        st.floats(0.0, 0.49),
        st.floats(1e3, 2e4),
    )


def rigid_motions(rotor):
    """Unit translation and unit rotation about z = 0, both planes, in the columns; shape (4 nodes, 4)."""
    motions = np.zeros((4 * len(rotor.shaft.nodes), 4))
    for axis in range(2):
        motions[axis::4, axis] = 1.0
        motions[axis::4, 2 + axis] = rotor.shaft.nodes
        motions[2 + axis :: 4, 2 + axis] = 1.0
    return motions


@pytest.mark.parametrize("elements", [1, 3])
@pytest.mark.parametrize("diameter", [0.02, 0.05, 0.4])
def test_cantilever_bends_under_force_and_moment_as_a_timoshenko_beam(elements, diameter):
    rotor = shaft_only(np.linspace(0.0, LENGTH, elements + 1), diameter)
    clamped = one_plane(assemble(rotor).K)[2:, 2:]
    E, nu = STEEL["youngs_modulus"], STEEL["poissons_ratio"]
    EI, area = E * math.pi * diameter**4 / 64, math.pi * diameter**2 / 4
    kGA = 6 * (1 + nu) / (7 + 6 * nu) * E / (2 * (1 + nu)) * area
    force, moment = np.zeros(2 * elements), np.zeros(2 * elements)
    force[-2], moment[-1] = 1.0, 1.0
    tip = np.linalg.solve(clamped, force)[-2:]
    np.testing.assert_allclose(tip, [LENGTH**3 / (3 * EI) + LENGTH / kGA, LENGTH**2 / (2 * EI)], rtol=1e-9)
    tip = np.linalg.solve(clamped, moment)[-2:]
    np.testing.assert_allclose(tip, [LENGTH**2 / (2 * EI), LENGTH / EI], rtol=1e-9)


@pytest.mark.parametrize("kind", ["consistent", "diagonal"])
@settings(max_examples=30)
@given(rotor=random_shafts())
def test_matrices_of_any_shaft_have_symmetry_and_rigid_motions(kind, rotor):
    full = assemble(rotor, kind)
    np.testing.assert_array_equal(full.M, full.M.T)
    assert np.linalg.eigvalsh(full.M)[0] > 0.0
    np.testing.assert_allclose(full.K, full.K.T, atol=1e-12 * np.max(full.K))
    np.testing.assert_array_equal(full.G, -full.G.T)
    scale = 1.0 / np.sqrt(np.diag(full.K))
    stiffness = np.linalg.eigvalsh(scale[:, None] * full.K * scale)
    assert np.all(np.abs(stiffness[:4]) < 1e-10)
    assert stiffness[4] > 1e-9
    motions = rigid_motions(rotor)
    assert np.max(np.abs(scale[:, None] * (full.K @ motions))) < 1e-9 * np.sqrt(np.max(full.K))


@settings(max_examples=30)
@given(rotor=random_shafts())
def test_consistent_mass_gives_a_rigid_shaft_its_mass_and_inertia(rotor):
    shaft = rotor.shaft
    full = assemble(rotor, "consistent")
    length, diameter = shaft.nodes[-1], shaft.diameter[0]
    mass = shaft.density * math.pi / 4 * diameter**2 * length
    about_the_end = mass * (length**2 / 3 + diameter**2 / 16)
    expected = np.kron([[mass, mass * length / 2], [mass * length / 2, about_the_end]], np.eye(2))
    motions = rigid_motions(rotor)
    np.testing.assert_allclose(motions.T @ full.M @ motions, expected, rtol=1e-10, atol=1e-10 * expected.max())
    gyroscopic = motions.T @ full.G @ motions
    assert gyroscopic[2, 3] == pytest.approx(mass * diameter**2 / 8, rel=1e-9)
    np.testing.assert_allclose(gyroscopic[:2], 0.0, atol=1e-10 * expected.max())


def test_unknown_mass_model_is_refused_by_name():
    with raises_naming(ValueError, "lumped", "consistent", "diagonal"):
        assemble(shaft_only((0.0, 1.0)), "lumped")
