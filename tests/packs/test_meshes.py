"""Finer and coarser meshes of one rotor."""

from itertools import pairwise

import numpy as np
import pytest

from bath_thesis.meshes import coarsen, even_nodes, mesh_family, refine
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming

RIG = load_rotor()
STEPPED = Rotor("stepped", Shaft((0.0, 0.2, 0.5, 0.6), (0.05, 0.08, 0.06), 2e11, 7800.0, 0.3, (0.0, 0.02, 0.0)))


def places(rotor):
    """What sits where (m)."""
    z = rotor.shaft.nodes
    parts = (*rotor.bodies, *rotor.bearings, *rotor.sites, *rotor.sensors)
    return {part.name: z[part.node - 1] for part in parts} | {"masters": [z[n - 1] for n in rotor.masters]}


def test_family_of_the_rig_has_the_meshes_of_the_thesis():
    meshes = mesh_family(RIG)
    assert list(meshes) == [23, 19, 13, 6]
    for count, mesh in meshes.items():
        assert len(mesh.shaft.nodes) == count
        assert places(mesh) == places(RIG)
        assert mesh.mass == pytest.approx(RIG.mass, rel=1e-12)
    assert meshes[13] == RIG
    assert meshes[6].masters == (1, 2, 3, 4, 5, 6)


def test_even_nodes_move_bearings_outwards_and_keep_the_mass():
    """The moment arm of the bearings about the middle grows by 1.67, so the conical mode is half as fast again."""
    mesh = even_nodes(RIG)
    z = np.array(mesh.shaft.nodes)
    assert np.diff(z) == pytest.approx(np.full(5, 1.948 / 5.0))
    assert [bearing.node for bearing in mesh.bearings] == [2, 5]
    assert sum(body.mass for body in mesh.bodies) == pytest.approx(sum(body.mass for body in RIG.bodies))
    first, moved = (
        damped_frequencies(supported_rotor(rotor, "diagonal").model, 0.0, 2).mean() for rotor in (RIG, mesh)
    )
    assert moved / first == pytest.approx(1.54, abs=0.03)


def test_refinement_halves_the_longest_elements_and_keeps_the_nodes():
    mesh = refine(RIG, 19)
    new = sorted(set(mesh.shaft.nodes) - set(RIG.shaft.nodes))
    halves = [(a + b) / 2 for a, b in pairwise(RIG.shaft.nodes)]
    assert len(new) == 6
    assert len([z for z in new if np.min(np.abs(np.array(halves) - z)) < 1e-12]) == 5  # the sixth halves a half
    assert np.max(np.diff(mesh.shaft.nodes)) < np.max(np.diff(RIG.shaft.nodes))


def test_refinement_keeps_the_positions_of_sections():
    fine = refine(STEPPED, 9)
    for z, diameter, inner in zip(fine.shaft.nodes, fine.shaft.diameter, fine.shaft.inner_diameter, strict=False):
        assert (diameter, inner) == ((0.05, 0.0) if z < 0.2 else (0.08, 0.02) if z < 0.5 else (0.06, 0.0))
    assert fine.mass == pytest.approx(STEPPED.mass, rel=1e-12)
    assert coarsen(fine, tuple(fine.shaft.nodes.index(z) + 1 for z in STEPPED.shaft.nodes)) == STEPPED


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda: refine(RIG, 12), ("nodes", "12", "13")),
        (lambda: coarsen(RIG, (1, 4, 11, 13)), ("[1, 3, 4, 10, 11, 13]",)),
        (lambda: coarsen(STEPPED, (1, 4)), ("0 m to 0.6 m", "(0.05, 0.0)")),
        (lambda: coarsen(RIG, (0, 99)), ("node numbers", "1 to 13")),
    ],
)
def test_impossible_meshes_are_refused(call, facts):
    with raises_naming(ValueError, *facts):
        call()
