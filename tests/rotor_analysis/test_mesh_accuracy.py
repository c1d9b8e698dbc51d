"""Meshes refined until the first modes have the required accuracy."""

from itertools import pairwise

import numpy as np
import pytest
from analysis_cases import STEEL, natural_frequencies

from rotor_analysis.mesh_accuracy import refine_to_accuracy
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.parts import Bearing, Disc, Site
from rotor_analysis.reduced_rotor import reduction_error
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.sections import ShaftSection
from rotor_analysis.shaft import SectionedShaft
from tests.support.messages import raises_naming

SECTIONS = (
    ShaftSection(0.3, 0.04, diameter_end=0.06),
    ShaftSection(0.6, 0.06, 0.02),
    ShaftSection(0.02, 0.09),
    ShaftSection(0.4, 0.05),
)
K = ((2e7, 0.0), (0.0, 2e7))
PUMP = """
name = "pump"
[shaft]
material = "steel"
theory = "rayleigh"
[[shaft.sections]]
length = 0.5
diameter = 0.05
[materials.steel]
youngs_modulus = 2.1e11
density = 7800
poissons_ratio = 0.3
"""


def stepped(mass_matrix, *bearings):
    parts = (Disc("impeller", z=0.7, mass=12.0, radius=0.12, width=0.04),), tuple(bearings), (Site("seal", z=0.75),)
    return Rotor("stepped", SectionedShaft(SECTIONS, mass_matrix=mass_matrix, **STEEL), *parts)


def divided(rotor, count):
    """The rotor with every element in `count` equal parts."""
    z = rotor.shaft.nodes
    inner = [place for a, b in pairwise(z) for place in np.linspace(a, b, count + 1)[:-1].tolist()]
    return rotor.on_mesh(rotor.shaft.on_nodes((*inner, z[-1])))


HELD = {
    "free": (),
    "on one bearing": (Bearing("a", z=0.2, stiffness=K),),
    "on two bearings": (Bearing("a", z=0.1, stiffness=K), Bearing("b", z=1.2, stiffness=K)),
}


@pytest.mark.parametrize(("mass_matrix", "accuracy"), [("consistent", 1e-3), ("consistent", 1e-4), ("diagonal", 3e-3)])
@pytest.mark.parametrize("held", HELD)
def test_first_modes_are_as_accurate_as_stated(held, mass_matrix, accuracy):
    rotor = stepped(mass_matrix, *HELD[held])
    mesh = refine_to_accuracy(rotor, 6, accuracy)
    much_finer = natural_frequencies(divided(mesh, 6), 6)
    error = np.max(np.abs(natural_frequencies(mesh, 6) / much_finer - 1.0))
    assert error < 4.0 / 3.0 * accuracy  # second order: all further changes add up to a third of this one
    assert np.max(np.abs(natural_frequencies(rotor, 6) / much_finer - 1.0)) > accuracy


@pytest.mark.parametrize("stiffness", [1.0, 1e-3, 1e-9])
def test_soft_bearings_need_no_finer_mesh(stiffness):
    """Motions that hardly bend the rotor have only the rounding error of its stiffness, which no mesh removes."""
    soft, stiff = (
        stepped(
            "consistent", *(Bearing(name, z=z, stiffness=((k, 0.0), (0.0, k))) for name, z in (("a", 0.1), ("b", 1.2)))
        )
        for k in (stiffness, 1e3)
    )
    mesh = refine_to_accuracy(soft, 6, 1e-4)
    assert mesh.shaft.nodes == refine_to_accuracy(stiff, 6, 1e-4).shaft.nodes
    assert np.max(np.abs(reduction_error(mesh, 6).percent[2:])) < 0.1, "the plant's model, of bending modes"


def test_parts_keep_their_positions_in_a_refined_mesh():
    mesh = refine_to_accuracy(stepped("consistent", *HELD["on two bearings"]), 6, 1e-4)
    z = mesh.shaft.nodes
    assert [z[part.node - 1] for part in (*mesh.bodies, *mesh.bearings, *mesh.sites)] == [0.7, 0.1, 1.2, 0.75]
    assert max(np.diff(z)) < 0.2


def test_file_with_sections_is_refined_to_its_accuracy(tmp_path):
    def count(more=""):
        path = tmp_path / "pump.toml"
        path.write_text(PUMP + more)
        return len(load_rotor(path).shaft.nodes)

    assert 5 < count() < count("[mesh]\naccuracy = 1e-5\n") < count("[mesh]\naccuracy = 1e-5\nmodes = 12\n")


def test_accuracy_beyond_rounding_is_refused(tmp_path):
    with raises_naming(ValueError, "mesh.accuracy", "1e-15", "500 nodes"):
        refine_to_accuracy(stepped("diagonal"), 6, 1e-15)


def test_file_with_nodes_is_refined_only_on_request(tmp_path):
    rig, path = rotor_path().read_text(encoding="utf-8"), tmp_path / "rig.toml"
    path.write_text(rig + "[mesh]\nmodes = 4\naccuracy = 1e-3\n", encoding="utf-8")
    fine, coarse = load_rotor(path), load_rotor()
    assert len(fine.shaft.nodes) > len(coarse.shaft.nodes)
    for rotor in (fine, coarse):
        assert [rotor.shaft.nodes[node - 1] for node in rotor.masters] == [0.0, 0.455, 0.624, 1.286, 1.321, 1.948]
