"""Conical, hollow and compound shafts against closed forms and against their own limits."""

import math
from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import STEEL, one_plane

from rotor_analysis import beam, tapered
from rotor_analysis.assembly import assemble
from rotor_analysis.element import Element, Material
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.sections import ShaftSection
from rotor_analysis.shaft import SectionedShaft, Shaft

MATERIAL = Material(**STEEL)
LENGTH, THICK, THIN = 0.9, 0.08, 0.04


def cone(count, **changes):
    """A solid cone from THICK at z = 0 to THIN, in `count` elements."""
    ends = np.linspace(THICK, THIN, count + 1)
    nodes = tuple(np.linspace(0.0, LENGTH, count + 1))
    return Rotor("cone", Shaft(nodes, tuple(ends[:-1]), diameter_end=tuple(ends[1:]), **STEEL, **changes))


@pytest.mark.parametrize("theory", ["rayleigh", "timoshenko"])
def test_integrals_along_a_uniform_element_are_the_closed_forms(theory):
    element = Element(0.1, (0.05, 0.05), (0.02, 0.02), MATERIAL, theory)
    phi = beam.shear_parameter(element)
    for integral, closed in (
        (tapered.stiffness, beam.stiffness),
        (tapered.translational_mass, beam.consistent_translational_mass),
        (tapered.rotary_inertia, beam.consistent_rotary_inertia),
    ):
        np.testing.assert_allclose(integral(element, phi), closed(element), rtol=1e-12, atol=1e-12)
    lumped = np.ravel(tapered.lumped(element))
    np.testing.assert_allclose(np.diag(lumped), beam.diagonal_mass(element)[0], rtol=1e-12)


@pytest.mark.parametrize("mass", ["consistent", "diagonal"])
def test_cone_has_the_mass_and_centre_of_a_frustum(mass):
    rotor = cone(3, mass_matrix=mass)
    M, z = one_plane(assemble(rotor).M), np.array(rotor.shaft.nodes)
    along, turning = np.zeros((2, len(M)))
    along[::2], turning[::2], turning[1::2] = 1.0, z, 1.0
    volume = math.pi * LENGTH / 12.0 * (THICK**2 + THICK * THIN + THIN**2)
    share = (THICK**2 + 2.0 * THICK * THIN + 3.0 * THIN**2) / (4.0 * (THICK**2 + THICK * THIN + THIN**2))
    assert along @ M @ along == pytest.approx(7800.0 * volume, rel=1e-12)
    assert rotor.mass == pytest.approx(7800.0 * volume, rel=1e-12)
    assert along @ M @ turning == pytest.approx(7800.0 * volume * share * LENGTH, rel=1e-12)


def test_reversed_cone_is_its_mirror_image():
    elements = Element(0.2, (0.08, 0.04), (0.03, 0.01), MATERIAL), Element(0.2, (0.04, 0.08), (0.01, 0.03), MATERIAL)
    mirror = np.array([[0, 0, 1, 0], [0, 0, 0, -1], [1, 0, 0, 0], [0, -1, 0, 0]], dtype=float)
    for matrix in (beam.stiffness, beam.consistent_translational_mass, beam.consistent_rotary_inertia):
        forward, backward = map(matrix, elements)
        np.testing.assert_allclose(
            mirror.T @ backward @ mirror, forward, rtol=1e-12, atol=1e-9 * np.max(np.abs(forward))
        )


@pytest.mark.parametrize("theory", ["rayleigh", "timoshenko"])
def test_gyroscopic_moment_of_a_cone_is_its_polar_inertia(theory):
    rotor = cone(1, theory=theory)
    _, polar = beam.diagonal_mass(rotor.elements[0][0])
    exact = math.pi * 7800.0 * LENGTH / 160.0 * (THICK**5 - THIN**5) / (THICK - THIN)
    assert rigid_body(rotor).polar_inertia == pytest.approx(exact, rel=1e-12)
    assert np.trace(polar) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(
    ("inner", "shear", "kappa"),
    [
        (0.0, "cowper", 6 * 1.3 / 8.8),
        (0.0, "hutchinson", 6 * 1.69 / 10.96),  # Hutchinson 2001, solid circle
        (0.0499999999, "cowper", 2 * 1.3 / 4.9),  # Cowper 1966, thin tube: 2 (1 + nu) / (4 + 3 nu)
        (0.0499999999, "hutchinson", 1.3 / 2.3),  # thin tube: (1 + nu) / (2 + nu)
    ],
)
def test_shear_coefficient_is_that_of_the_source(inner, shear, kappa):
    element = Element(0.1, (0.05, 0.05), (inner, inner), MATERIAL, shear=shear)
    assert element.shear_coefficient == pytest.approx(kappa, rel=1e-7)


def test_sections_and_nodes_with_diameters_give_the_same_shaft():
    sections = (ShaftSection(0.3, 0.05), ShaftSection(0.2, 0.08, 0.02, 0.06, material="aluminium"))
    materials = {"aluminium": Material(0.7e11, 2700.0, 0.33)}
    by_sections = Rotor("shaft", SectionedShaft(sections, **STEEL), materials=materials)
    shaft = Shaft(
        (0.0, 0.3, 0.5),
        (0.05, 0.08),
        diameter_end=(0.05, 0.06),
        inner_diameter=(0.0, 0.02),
        material=(None, "aluminium"),
        mass_matrix="consistent",
        **STEEL,
    )
    assert by_sections == Rotor("shaft", shaft, materials=materials)
    assert [element.material.density for (element,) in by_sections.elements] == [7800.0, 2700.0]


def test_cut_cone_is_the_same_cone():
    shaft = cone(1).shaft.with_nodes_at([0.3, 0.6])
    exact = cone(3).shaft
    np.testing.assert_allclose(shaft.diameter, exact.diameter, rtol=1e-12)
    np.testing.assert_allclose(shaft.diameter_end, exact.diameter_end, rtol=1e-12)
    assert shaft.diameter[1] == shaft.diameter_end[0]


def test_changed_diameter_leaves_a_uniform_shaft_uniform():
    shaft = Shaft((0.0, 0.5, 1.0), (0.05,), diameter_end=(0.05,), **STEEL)
    assert not any(element.is_tapered for (element,) in replace(shaft, diameter=(0.06,)).elements({}))
