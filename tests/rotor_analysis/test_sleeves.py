"""Sleeves on the shaft."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import STEEL, natural_frequencies

from bath_thesis.meshes import coarsen
from rotor_analysis.assembly import assemble
from rotor_analysis.element import Material
from rotor_analysis.mesh_accuracy import refine_to_accuracy
from rotor_analysis.rotor import Rotor
from rotor_analysis.sections import Sleeve
from rotor_analysis.shaft import Shaft
from tests.support.messages import raises_naming

NODES = (0.0, 0.2, 0.5, 0.9)


def shaft(diameter, *sleeves, **options):
    return Rotor("shaft", Shaft(NODES, diameter, sleeves=sleeves, theory="rayleigh", **STEEL, **options))


@pytest.mark.parametrize("mass", ["consistent", "diagonal"])
def test_sleeve_of_the_same_steel_makes_the_shaft_thicker(mass):
    """Without shear: E I and rho A of core and ring add up."""
    sleeved = assemble(shaft((0.05,), Sleeve(0.2, 0.5, 0.08, 0.05)), mass)
    solid = assemble(shaft((0.05, 0.08, 0.05)), mass)
    for name in ("M", "G", "K"):
        ours, theirs = getattr(sleeved, name), getattr(solid, name)
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12 * np.max(np.abs(theirs)))


def test_sleeve_of_another_material_adds_its_mass():
    bronze = {"bronze": Material(1.1e11, 8800.0, 0.34)}
    bare, ring = shaft((0.05,)), Sleeve(0.3, 0.8, 0.08, 0.05, material="bronze")
    sleeved = replace(bare, shaft=replace(bare.shaft, sleeves=(ring,)), materials=bronze)
    assert sleeved.mass - bare.mass == pytest.approx(8800.0 * np.pi / 4.0 * (0.08**2 - 0.05**2) * 0.5, rel=1e-12)
    assert sleeved.shaft.nodes == (0.0, 0.2, 0.3, 0.5, 0.8, 0.9)  # it ends at nodes


def test_conical_sleeve_is_the_same_on_any_mesh():
    ring = Sleeve(0.0, 0.9, 0.09, 0.05, diameter_end=0.06)
    coarse = shaft((0.05,), ring, mass_matrix="consistent")
    fine = refine_to_accuracy(coarse, 3, 1e-5)
    assert fine.mass == pytest.approx(coarse.mass, rel=1e-12)
    ends = tuple(0.09 - 0.03 * z / 0.9 for z in NODES)
    solid = Shaft(NODES, ends[:-1], diameter_end=ends[1:], theory="rayleigh", mass_matrix="consistent", **STEEL)
    whole = natural_frequencies(refine_to_accuracy(Rotor("cone", solid), 3, 1e-5), 3)
    np.testing.assert_allclose(natural_frequencies(fine, 3), whole, rtol=3e-5)


def test_mesh_keeps_the_ends_of_sleeves():
    rotor = shaft((0.05,), Sleeve(0.2, 0.5, 0.08, 0.05))
    with raises_naming(ValueError, "nodes", "[0.0, 0.9] m", "0.2 m"):
        coarsen(rotor, (1, 4))


@pytest.mark.parametrize(
    ("begin", "end", "outer", "inner", "facts"),
    [
        (0.5, 0.2, 0.08, 0.05, ("end", "0.2 m", "> 0.5 m")),
        (0.5, 1.2, 0.08, 0.05, ("sleeves[0].end", "1.2 m", "0 m to 0.9 m")),
        (0.2, 0.5, 0.05, 0.06, ("inner_diameter", "0.06 m")),
    ],
)
def test_impossible_sleeve_is_refused(begin, end, outer, inner, facts):
    with raises_naming(ValueError, *facts):
        shaft((0.05,), Sleeve(begin, end, outer, inner))
